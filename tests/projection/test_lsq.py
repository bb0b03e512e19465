"""Least squares (eq. 11): reference numbers, the dense twin, exact polynomials, conditioning."""

import naive
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import jv

from chebid.basis import CHEBYSHEV, FAMILIES
from chebid.projection import Operator, Plan
from chebid.projection.fold import symmetric_grid
from chebid.projection.normal import least_squares
from chebid.projection.sums import circle, real_sums
from chebid.projection.uniform_sums import uniform_sums

EPS = np.finfo(float).eps


def warped(samples: int, strength: float) -> np.ndarray:
    """Stamps whose step varies smoothly by the factor (1 + s) / (1 - s)."""
    u = np.linspace(0, 1, samples)
    return u + strength * np.sin(2 * np.pi * u) / (2 * np.pi)


# --- reference numbers


def test_exponential_on_eleven_points() -> None:
    t = np.linspace(-1, 1, 11)
    found = Operator(t, Plan(degree=4)).fit(np.exp(t)).coefficients[0, :, 0]
    expected = [1.266076868969945, 1.13049317720813, 0.271512789924623, 0.044374193617509, 0.005475919300274]
    assert found == pytest.approx(expected, abs=1e-14)  # fifteen digits are given


@pytest.mark.parametrize(("w", "phi"), [(10.0, 0.3), (2.5, -1.0), (20.0, 0.0)])
def test_coefficients_of_a_sine_are_bessel_functions(w: float, phi: float) -> None:
    """Jacobi-Anger: c_k = (2 - delta_k0) J_k(w) sin(phi + k pi / 2); a degree that leaves nothing out."""
    n = int(w + 8 * w ** (1 / 3)) + 6
    tau = symmetric_grid(4001)
    found = least_squares(tau, np.sin(w * tau + phi)[:, None], n)[:, 0]
    k = np.arange(n + 1)
    assert found == pytest.approx(np.where(k == 0, 1, 2) * jv(k, w) * np.sin(phi + k * np.pi / 2), abs=1e-12)


def test_bessel_coefficients_as_given() -> None:
    tau = symmetric_grid(4001)
    found = least_squares(tau, np.sin(10 * tau + 0.3)[:, None], 30)[:6, 0]
    expected = [
        -0.072678987936077, 0.083062201395218, -0.150496805844937, -0.111543902525498, -0.129794062360502,
        -0.447215037154691,
    ]  # fmt: skip
    assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("samples", "n", "expected"), [(101, 10, 2.90281496061), (1001, 50, 5.2093144925), (1001, 63, 5.5375484072)]
)
def test_condition_numbers(samples: int, n: int, expected: float) -> None:
    assert np.linalg.cond(CHEBYSHEV.values(symmetric_grid(samples), n)) == pytest.approx(expected, rel=1e-10)


def test_law_of_the_condition_number() -> None:
    """0.69 to 0.92 sqrt(n) up to n = 2 sqrt(N), then by and by as exp(0.45 n^2 / N)."""
    for samples in (400, 2500):
        tau = symmetric_grid(samples)
        for n in (int(np.sqrt(samples)), int(2 * np.sqrt(samples))):
            assert 0.68 < np.linalg.cond(CHEBYSHEV.values(tau, n)) / np.sqrt(n) < 0.93
        logs = [np.log(np.linalg.cond(CHEBYSHEV.values(tau, int(k * np.sqrt(samples))))) for k in (4, 5.5)]
        assert logs[1] - logs[0] == pytest.approx(0.45 * (5.5**2 - 4**2), rel=0.1)


@pytest.mark.parametrize(("duration", "condition"), [(5, 1.1e5), (10, 104), (20, 10), (40, 7.8)])
def test_condition_of_the_papers_degree(duration: int, condition: float) -> None:
    p = CHEBYSHEV.values(symmetric_grid(100 * duration + 1), 125)
    assert np.linalg.cond(p) == pytest.approx(condition, rel=0.05)  # two digits are given


# --- the dense twin


@pytest.mark.parametrize("name", sorted(FAMILIES))
@pytest.mark.parametrize(("samples", "n"), [(2, 1), (5, 0), (6, 5), (40, 13), (41, 13), (300, 34), (301, 35)])
@pytest.mark.parametrize("strength", [0.0, 0.5])
def test_the_same_as_the_pseudo_inverse(name: str, samples: int, n: int, strength: float) -> None:
    t = warped(samples, strength)
    x = np.random.default_rng(samples).standard_normal((samples, 2))
    operator = Operator(t, Plan(basis=name, degree=n))
    tau = symmetric_grid(samples) if strength == 0 else operator.layout.tau(0, t)
    expected = naive.pseudo_inverse(name, tau, x, n)
    condition = np.linalg.cond(naive.polynomials("chebyshev", tau, n))
    # the normal equations square the condition number, in the Chebyshev basis; converting grows with the degree
    tolerance = 50 * EPS * condition**2 * np.abs(expected).max() * (n + 1)
    assert operator.fit(x).coefficients[0] == pytest.approx(expected, abs=tolerance)


@pytest.mark.parametrize(("samples", "n"), [(1000, 60), (10_001, 125), (20_000, 380)])
def test_the_same_as_numpy(samples: int, n: int) -> None:
    tau = symmetric_grid(samples)
    x = np.random.default_rng(0).standard_normal(samples)
    expected = np.polynomial.chebyshev.chebfit(tau, x, n)
    assert least_squares(tau, x[:, None], n)[:, 0] == pytest.approx(expected, abs=3e-13)


def test_factors_are_kept_and_the_same() -> None:
    tau, x = symmetric_grid(500), np.random.default_rng(0).standard_normal((500, 1))
    assert np.array_equal(least_squares(tau, x, 40), least_squares(tau, x, 40))


# --- sums


@given(
    samples=st.integers(1, 70), highest=st.integers(0, 40), signals=st.integers(1, 3), seed=st.integers(0, 2**32 - 1)
)
def test_sums_of_powers(samples: int, highest: int, signals: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    theta = random.uniform(0, np.pi, samples)
    w = random.standard_normal((samples, signals))
    m = np.arange(highest + 1)
    cosines, sines = real_sums(np.exp(1j * theta), [w, (-1j * w).astype(complex)], highest)
    tolerance = 20 * EPS * samples * (1 + highest)
    assert cosines == pytest.approx(np.cos(np.outer(m, theta)) @ w, abs=tolerance)
    assert sines == pytest.approx(np.sin(np.outer(m, theta)) @ w, abs=tolerance)


def test_sums_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    z, w = circle(symmetric_grid(1000)), np.random.default_rng(0).standard_normal((1000, 2))
    whole = real_sums(z, [w], 30)[0]
    monkeypatch.setattr("chebid.projection.sums._BLOCK", 64)
    assert real_sums(z, [w], 30)[0] == pytest.approx(whole, abs=1e-11)


@pytest.mark.parametrize(
    ("samples", "n"), [(5, 4), (20, 10), (1001, 20), (1000, 125), (10_001, 250), (30_000, 2), (100_000, 632)]
)
def test_sums_over_a_uniform_grid(samples: int, n: int) -> None:
    """By Euler and Maclaurin where it pays, against sums of cosines."""
    theta = np.arccos(symmetric_grid(samples))
    expected = [np.sum(np.cos(m * theta)) for m in range(0, 2 * n + 1, 2 * max(1, n // 50))]
    found = uniform_sums(samples, 2 * n)[:: max(1, n // 50)]
    # arccos near the ends costs m sqrt(EPS) there in the twin, at a few samples
    assert found == pytest.approx(expected, abs=1e-14 * samples + 1e-9)


# --- what a projection is


@given(
    name=st.sampled_from(sorted(FAMILIES)), n=st.integers(0, 20), seed=st.integers(0, 2**32 - 1),
    strength=st.sampled_from([0.0, 0.6]),
)  # fmt: skip
def test_polynomials_are_reproduced_with_all_their_derivatives(name: str, n: int, seed: int, strength: float) -> None:
    t = 3.0 + 2.0 * warped(150, strength)
    c = np.random.default_rng(seed).standard_normal(n + 1)
    one = FAMILIES[name]
    operator = Operator(t, Plan(basis=name, degree=n))
    tau = operator.layout.tau(0, t)
    series = operator.fit(one.evaluate(tau, c))
    assert series.coefficients[0, :, 0] == pytest.approx(c, abs=1e-10)
    for order in range(4):
        expected = one.evaluate(tau, one.differentiate(c, order))
        scale = np.sum(np.abs(c)) * (n + 1) ** (2 * order + 1)
        assert operator.at_samples(series, order)[:, 0] == pytest.approx(expected, abs=1e-11 * scale)


def test_residuals_are_orthogonal_to_all_polynomials() -> None:
    t, n = warped(200, 0.4), 25
    x = np.random.default_rng(0).standard_normal(200)
    operator = Operator(t, Plan(degree=n))
    residual = x - operator.at_samples(operator.fit(x))[:, 0]
    products = naive.polynomials("chebyshev", operator.layout.tau(0, t), n).T @ residual
    assert products == pytest.approx(np.zeros(n + 1), abs=1e-11)
