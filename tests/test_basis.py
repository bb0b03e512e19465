"""Bases: closed forms, exact derivatives, algebra, the three families against each other and against numpy."""

import naive
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from chebid.basis import (
    CHEBYSHEV,
    CHEBYSHEV2,
    FAMILIES,
    LEGENDRE,
    chebyshev_points,
    convert,
    family,
    interpolate,
)
from chebid.errors import UsageError

EPS = np.finfo(float).eps
TAU = np.linspace(-1, 1, 41)
NAMES = sorted(FAMILIES)

names = st.sampled_from(NAMES)
numbers = st.floats(-1e3, 1e3, allow_subnormal=False)


def coefficients(most: int = 12, signals: int | None = None) -> st.SearchStrategy:
    """Of one polynomial of any degree up to `most`, or of several."""
    more = () if signals is None else (signals,)
    return st.integers(1, most + 1).flatmap(lambda n: arrays(float, (n, *more), elements=numbers))


# --- values


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("n", [0, 1, 2, 7, 60])
def test_values_are_the_closed_forms(name: str, n: int) -> None:
    expected = naive.polynomials(name, TAU, n)
    # the closed form of U_n divides by sin(theta): n^2 roundings near the ends
    assert FAMILIES[name].values(TAU, n) == pytest.approx(expected, abs=10 * EPS * (n + 1) ** 2)


@pytest.mark.parametrize("name", NAMES)
def test_values_at_the_ends_are_exact(name: str) -> None:
    k = np.arange(31)
    right = k + 1 if name == "chebyshev2" else np.ones(31)
    assert FAMILIES[name].values(np.array([1.0]), 30)[0] == pytest.approx(right, rel=30 * EPS)
    assert FAMILIES[name].values(np.array([-1.0]), 30)[0] == pytest.approx(right * (-1.0) ** k, rel=30 * EPS)


@given(name=names, c=coefficients(30, 3))
def test_evaluate_is_the_sum_of_the_polynomials(name: str, c: np.ndarray) -> None:
    n = len(c) - 1
    expected = naive.polynomials(name, TAU, n) @ c
    assert FAMILIES[name].evaluate(TAU, c) == pytest.approx(expected, abs=1e3 * 20 * EPS * (n + 1) ** 3)


def test_many_points_are_evaluated_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    tau, c = np.linspace(-1, 1, 1001), np.random.default_rng(1).standard_normal((9, 2))
    whole = LEGENDRE.evaluate(tau, c)
    monkeypatch.setattr("chebid.basis._BLOCK", 100)
    assert LEGENDRE.evaluate(tau, c) == pytest.approx(whole, abs=20 * EPS)
    assert LEGENDRE.evaluate(tau[:0], c).shape == (0, 2)


# --- inner products


@pytest.mark.parametrize("name", NAMES)
def test_orthogonal_with_the_stated_norms(name: str) -> None:
    """Eq. 3: <P_i, P_j> = 0, and the squared norms, which the paper leaves open (pi, pi / 2 for Chebyshev)."""
    one = FAMILIES[name]
    for i in range(6):
        for j in range(6):
            product = one.inner(lambda tau, i=i: one.values(tau, 5)[:, i], lambda tau, j=j: one.values(tau, 5)[:, j])
            # the weight 1 / sqrt(1 - tau^2) loses digits at the outermost nodes, where 1 - tau^2 is 1e-10
            assert product == pytest.approx(one.norms(np.arange(6.0))[i] if i == j else 0, abs=1e-11)


def test_norms_of_the_paper() -> None:
    assert CHEBYSHEV.norms(np.array([0.0, 1.0, 9.0])) == pytest.approx([np.pi, np.pi / 2, np.pi / 2], rel=EPS)
    assert CHEBYSHEV2.norms(np.array([0.0, 9.0])) == pytest.approx([np.pi / 2, np.pi / 2], rel=EPS)
    assert LEGENDRE.norms(np.array([0.0, 1.0, 2.0])) == pytest.approx([2, 2 / 3, 2 / 5], rel=EPS)


# --- derivatives


def test_derivative_matrix_of_the_paper() -> None:
    """Eq. 27 (n even) and eq. 28 (n odd), as printed."""
    printed = [
        [0, 0, 0, 0, 0, 0],
        [1, 0, 0, 0, 0, 0],
        [0, 4, 0, 0, 0, 0],
        [3, 0, 6, 0, 0, 0],
        [0, 8, 0, 8, 0, 0],
        [5, 0, 10, 0, 10, 0],
    ]
    assert np.array_equal(CHEBYSHEV.derivative_matrix(5), printed)
    assert np.array_equal(CHEBYSHEV.derivative_matrix(4), np.array(printed)[:5, :5])
    for n in (0, 1, 8, 125):
        assert np.array_equal(CHEBYSHEV.derivative_matrix(n), naive.derivative_matrix(n))


@given(name=names, c=coefficients(40, 2), order=st.integers(0, 4))
def test_differentiate_is_the_row_vector_times_d(name: str, c: np.ndarray, order: int) -> None:
    d = np.linalg.matrix_power(FAMILIES[name].derivative_matrix(len(c) - 1), order)
    scale = np.abs(c).T @ np.abs(d) + np.finfo(float).tiny
    error = np.abs(FAMILIES[name].differentiate(c, order).T - c.T @ d)
    assert np.all(error <= 100 * EPS * scale)  # sums of up to 40 terms, up to four times


@pytest.mark.parametrize(
    ("name", "der"),
    [("chebyshev", np.polynomial.chebyshev.chebder), ("legendre", np.polynomial.legendre.legder)],
)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_differentiate_agrees_with_numpy(name: str, der, order: int) -> None:
    c = np.random.default_rng(0).standard_normal((20, 3))
    mine = FAMILIES[name].differentiate(c, order)
    assert mine[: 20 - order] == pytest.approx(der(c, order), rel=1e-12)
    assert np.all(mine[20 - order :] == 0)


@given(name=names, c=arrays(float, (6, 2), elements=numbers))
def test_the_sixth_derivative_of_a_quintic_is_exactly_zero(name: str, c: np.ndarray) -> None:
    assert np.all(FAMILIES[name].differentiate(c, 6) == 0)


@given(name=names, c=coefficients(8))
def test_the_last_derivative_is_the_leading_coefficient(name: str, c: np.ndarray) -> None:
    """n! times the coefficient of tau^n, the product of alpha_0 .. alpha_{n-1} for P_n."""
    n = len(c) - 1
    leading = np.prod(FAMILIES[name].alpha(np.arange(float(n))))
    constant = FAMILIES[name].differentiate(c, n)
    assert constant[0] == pytest.approx(c[-1] * leading * np.prod(np.arange(1.0, n + 1)), rel=50 * EPS)
    assert np.all(constant[1:] == 0)


@given(name=names, f=coefficients(8), g=coefficients(8))
def test_product_rule(name: str, f: np.ndarray, g: np.ndarray) -> None:
    """(f g)' = f' g + f g', f g being interpolated."""
    one, degree = FAMILIES[name], len(f) + len(g) - 2
    nodes = chebyshev_points(degree + 1)
    product = convert(interpolate(one.evaluate(nodes, f) * one.evaluate(nodes, g)), CHEBYSHEV, one)
    left = one.evaluate(TAU, one.differentiate(product))
    right = one.evaluate(TAU, one.differentiate(f)) * one.evaluate(TAU, g)
    right += one.evaluate(TAU, f) * one.evaluate(TAU, one.differentiate(g))
    scale = np.sum(np.abs(f)) * np.sum(np.abs(g)) * (degree + 1) ** 5  # U_n and P_n' reach n^2 at the ends, twice
    assert left == pytest.approx(right, abs=100 * EPS * scale + np.finfo(float).tiny)


# --- conversions


@pytest.mark.parametrize(
    ("source", "target", "matrix"),
    [
        # T_2 = (U_2 - U_0) / 2, T_3 = (U_3 - U_1) / 2; P_2 = (3 T_2 + T_0) / 4, P_3 = (5 T_3 + 3 T_1) / 8
        (CHEBYSHEV, CHEBYSHEV2, [[1, 0, 0, 0], [0, 0.5, 0, 0], [-0.5, 0, 0.5, 0], [0, -0.5, 0, 0.5]]),
        (LEGENDRE, CHEBYSHEV, [[1, 0, 0, 0], [0, 1, 0, 0], [0.25, 0, 0.75, 0], [0, 0.375, 0, 0.625]]),
        (CHEBYSHEV, LEGENDRE, [[1, 0, 0, 0], [0, 1, 0, 0], [-1 / 3, 0, 4 / 3, 0], [0, -3 / 5, 0, 8 / 5]]),
    ],
)
def test_conversions_of_low_degree(source, target, matrix) -> None:
    found = convert(np.eye(4), source, target).T
    assert found == pytest.approx(np.array(matrix), abs=4 * EPS)


@given(source=names, target=names, c=coefficients(30, 2))
def test_conversion_keeps_the_polynomial_and_can_be_undone(source: str, target: str, c: np.ndarray) -> None:
    a, b = FAMILIES[source], FAMILIES[target]
    there = convert(c, a, b)
    scale = (np.sum(np.abs(c)) + np.finfo(float).tiny) * len(c) ** 2
    assert b.evaluate(TAU, there) == pytest.approx(a.evaluate(TAU, c), abs=100 * EPS * scale)
    assert convert(there, b, a) == pytest.approx(c, abs=100 * EPS * scale)


@given(source=names, target=names, c=coefficients(12), order=st.integers(1, 3))
def test_families_agree_on_derivatives(source: str, target: str, c: np.ndarray, order: int) -> None:
    a, b = FAMILIES[source], FAMILIES[target]
    one = a.evaluate(TAU, a.differentiate(c, order))
    other = b.evaluate(TAU, b.differentiate(convert(c, a, b), order))
    scale = (np.sum(np.abs(c)) + np.finfo(float).tiny) * len(c) ** (2 * order + 2)  # Markov: P' <= n^2 P
    assert one == pytest.approx(other, abs=100 * EPS * scale)


@given(c=coefficients(20, 2))
def test_interpolation_gives_back_the_coefficients(c: np.ndarray) -> None:
    back = interpolate(CHEBYSHEV.evaluate(chebyshev_points(len(c)), c))
    assert back == pytest.approx(c, abs=50 * EPS * (np.sum(np.abs(c)) + np.finfo(float).tiny) * len(c))


# --- names


@pytest.mark.parametrize("name", NAMES)
def test_families_by_name(name: str) -> None:
    assert family(name).name == name


def test_an_unknown_family_is_named_with_the_choice() -> None:
    with pytest.raises(UsageError, match="unknown basis 'hermite'") as caught:
        family("hermite")
    assert all(name in caught.value.hint for name in NAMES)
