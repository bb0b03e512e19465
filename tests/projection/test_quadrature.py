"""Projection by the inner product (annex 5.1): integrals, the dense twin, what it is exact for and what it is not."""

import naive
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from chebid.basis import CHEBYSHEV, CHEBYSHEV2, FAMILIES, LEGENDRE
from chebid.projection import Operator, Plan
from chebid.projection.fold import symmetric_grid
from chebid.projection.normal import least_squares
from chebid.projection.quadrature import quadrature_coefficients

EPS = np.finfo(float).eps


def uneven(samples: int, seed: int) -> np.ndarray:
    inner = np.random.default_rng(seed).uniform(-1, 1, samples - 2)
    return np.concatenate([[-1.0], np.sort(inner), [1.0]])


def test_integrals_of_the_annex() -> None:
    """The numbers of the corrected annex on [0.2, 0.5], and the integrals themselves."""
    first = [0.322240854807968, 0.113770493328833, -0.237053522469565, -0.274342851191716]
    second = [0.113770493328833, 0.042593666169201, -0.080286178931442, -0.100414808296149]
    for i in range(4):
        assert naive.annex_i(i, 0.2, 0.5) == pytest.approx(first[i], abs=1e-14)
        assert naive.annex_j(i, 0.2, 0.5) == pytest.approx(second[i], abs=1e-14)
        for power, found in ((0, naive.annex_i), (1, naive.annex_j)):
            value, _ = quad(lambda u, i=i, p=power: u**p * np.cos(i * np.arccos(u)) / np.sqrt(1 - u**2), 0.2, 0.5)
            assert found(i, 0.2, 0.5) == pytest.approx(value, abs=1e-12)


def test_the_printed_annex_is_wrong() -> None:
    """Without the i inside the second sine, J_2 would be another number: the errata are needed."""

    def printed(tau: float, i: int) -> float:
        a = np.arccos(tau)
        return (np.sin(a) * np.cos(i * a) - i * tau * np.sin(a)) / (i**2 - 1)

    assert abs(printed(0.5, 2) - printed(0.2, 2) - naive.annex_j(2, 0.2, 0.5)) > 1e-2


def test_exponential_on_eleven_points() -> None:
    t = np.linspace(-1, 1, 11)
    found = Operator(t, Plan("quadrature", degree=4)).fit(np.exp(t)).coefficients[0, :, 0]
    expected = [1.269849362031656, 1.133385810832226, 0.271475954839007, 0.043725137771943, 0.004462901884005]
    assert found == pytest.approx(expected, abs=1e-14)  # fifteen digits are given


@pytest.mark.parametrize("n", [0, 1, 2, 3, 12])
@pytest.mark.parametrize("samples", [2, 3, 9, 30])
def test_the_same_as_the_annex(n: int, samples: int) -> None:
    for tau in (symmetric_grid(samples), uneven(max(samples, 3), samples)):
        x = np.random.default_rng(n).standard_normal((len(tau), 2))
        found = quadrature_coefficients(tau, x, n)
        for j in range(2):
            # slopes of up to max(x) / min(step) cancel between neighbours
            tolerance = 100 * EPS * (n + 1) * np.abs(np.diff(x[:, j]) / np.diff(tau)).max()
            assert found[:, j] == pytest.approx(naive.annex(tau, x[:, j], n), abs=tolerance)
            assert naive.annex_dense(tau, x[:, j], n) == pytest.approx(naive.annex(tau, x[:, j], n), abs=tolerance)


def test_the_same_as_the_dense_annex_on_a_long_record() -> None:
    t = np.linspace(-1, 1, 10_000)
    x = np.sin(40 * t) + 0.3 * np.cos(7 * t)
    assert quadrature_coefficients(t, x[:, None], 125)[:, 0] == pytest.approx(naive.annex_dense(t, x, 125), abs=1e-12)


@pytest.mark.parametrize("family", [CHEBYSHEV, CHEBYSHEV2, LEGENDRE], ids=lambda one: one.name)
def test_every_family_integrates_broken_lines_exactly(family) -> None:
    tau = uneven(8, 5)
    x = np.random.default_rng(5).standard_normal(8)

    def product(i: int) -> float:
        # with tau = cos(theta) the weight costs no digits; the corners are given to the integrator
        def integrand(theta: float) -> float:
            at = np.array([np.cos(theta)])
            return float(np.interp(at, tau, x)[0] * family.values(at, 6)[0, i] * family.weight(at)[0] * np.sin(theta))

        return sum(
            quad(integrand, np.arccos(tau[k + 1]), np.arccos(tau[k]), epsabs=1e-13)[0] for k in range(len(tau) - 1)
        )

    expected = [product(i) / family.norms(np.array([float(i)]))[0] for i in range(7)]
    assert quadrature_coefficients(tau, x[:, None], 6, family)[:, 0] == pytest.approx(expected, abs=1e-10)


@given(
    name=st.sampled_from(sorted(FAMILIES)), n=st.integers(1, 30), samples=st.integers(3, 60), seed=st.integers(0, 999)
)
def test_straight_lines_are_exact(name: str, n: int, samples: int, seed: int) -> None:
    tau = uneven(samples, seed)
    found = quadrature_coefficients(tau, (2 - 3 * tau)[:, None], n, FAMILIES[name])[:, 0]
    expected = np.zeros(n + 1)
    expected[:2] = 2, -1.5 if name == "chebyshev2" else -3  # U_1 = 2 tau
    # slopes are differences over steps that may be tiny
    assert found == pytest.approx(expected, abs=1e3 * EPS * (n + 2) / np.diff(tau).min())


def test_differs_from_least_squares_by_the_broken_line_only() -> None:
    """About (w h)^2 / 12 in the coefficients, and no degree makes it less."""
    w, tau = 10.0, symmetric_grid(201)
    for n in (25, 50):
        exact = least_squares(tau, np.sin(w * tau)[:, None], n)[:, 0]
        found = quadrature_coefficients(tau, np.sin(w * tau)[:, None], n)[:, 0]
        assert np.abs(found - exact).max() / np.abs(exact).max() == pytest.approx((w * 0.01) ** 2 / 12, rel=0.25)


def test_quadratic_convergence() -> None:
    errors = []
    for samples in (101, 201, 401):
        tau = symmetric_grid(samples)
        errors.append(np.abs(quadrature_coefficients(tau, np.exp(tau)[:, None], 5)[0, 0] - 1.2660658777520084))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.02)


def test_a_record_that_does_not_reach_the_ends_is_held_constant() -> None:
    tau, x = np.linspace(-0.5, 0.5, 30), np.linspace(1, 2, 30)
    longer, held = np.concatenate([[-1.0], tau, [1.0]]), np.concatenate([[1.0], x, [2.0]])
    found = quadrature_coefficients(tau, x[:, None], 9)
    assert found == pytest.approx(quadrature_coefficients(longer, held[:, None], 9), abs=1e-13)
