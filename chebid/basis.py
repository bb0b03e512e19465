"""Families of orthogonal polynomials on [-1, 1]: values, derivative matrix, weight, norms, conversions.

Coefficients are row vectors, as in the paper (eq. 7): x(tau) = sum_i c_i P_i(tau), and x' has coefficients ``c @ D``.
Arrays of coefficients carry the degree on their first axis: shape (n + 1, ...).

Every family here obeys a three-term recurrence  P_{i+1} = alpha_i tau P_i - gamma_i P_{i-1}  and a derivative rule
P_j' = b_j sum_{k < j, j - k odd} a_k P_k  (eq. 12 for Chebyshev I; the others: Abramowitz & Stegun, ch. 22), so a
family is four sequences, a weight and the squared norms.

Source: Pham et al., JESA 46(6-7), 2012, eq. 1-14, 27, 28 and annex 5 (errata: eq. 1 starts at i = 0, eq. 12 is d/dtau).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
import scipy.linalg
from numpy.typing import NDArray

from chebid.errors import UsageError

Array = NDArray[np.float64]
_BLOCK = 2048  # points at which polynomials are held at a time: they stay in cache


@dataclass(frozen=True)
class Family:
    """One family: `alpha`, `gamma`, `rise` (a) and `fall` (b) map an index array to the sequences described above."""

    name: str
    alpha: Callable[[Array], Array]
    gamma: Callable[[Array], Array]
    rise: Callable[[Array], Array]
    fall: Callable[[Array], Array]
    weight: Callable[[Array], Array]
    norms: Callable[[Array], Array]

    def values(self, tau: Array, degree: int) -> Array:
        """P_0 .. P_n at `tau` (N,) as an (N, n + 1) matrix, by the recurrence."""
        index = np.arange(degree + 1.0)
        alpha, gamma = self.alpha(index), self.gamma(index)
        out = np.empty((degree + 1, len(tau)))
        out[0] = 1.0
        if degree:
            out[1] = alpha[0] * tau
        for i in range(1, degree):
            np.multiply(tau, out[i], out=out[i + 1])
            out[i + 1] *= alpha[i]
            out[i + 1] -= gamma[i] * out[i - 1]
        return out.T

    def evaluate(self, tau: Array, coefficients: Array) -> Array:
        """sum_i c_i P_i(tau) for coefficients (n + 1, ...): shape (N, ...). Memory is that of the result."""
        flat = coefficients.reshape(len(coefficients), -1)
        out = np.empty((len(tau), flat.shape[1]))
        for start in range(0, len(tau), _BLOCK):
            piece = slice(start, start + _BLOCK)
            out[piece] = self.values(tau[piece], len(flat) - 1) @ flat
        return out.reshape(len(tau), *coefficients.shape[1:])

    def derivative_matrix(self, degree: int) -> Array:
        """D of eq. 13, (n + 1, n + 1): the coefficients of x' are ``c @ D`` (eq. 27 for n even, eq. 28 for n odd)."""
        j, k = np.arange(degree + 1.0)[:, None], np.arange(degree + 1.0)[None, :]
        return np.where((j > k) & ((j - k) % 2 == 1), self.fall(j) * self.rise(k), 0.0)

    def differentiate(self, coefficients: Array, order: int = 1) -> Array:
        """Coefficients (n + 1, ...) of the derivative in tau of any order, in O(n): ``c @ D`` without the matrix."""
        for _ in range(order):
            coefficients = self._differentiate_once(coefficients)
        return coefficients

    def _differentiate_once(self, c: Array) -> Array:
        index = np.arange(float(len(c))).reshape(-1, *[1] * (c.ndim - 1))
        weighted = self.fall(index) * c
        out = np.zeros_like(weighted)
        # entry k sums the weighted entries k+1, k+3, ...: running sums from the top of every second one
        odd = np.cumsum(weighted[1::2][::-1], axis=0)[::-1]
        even = np.cumsum(weighted[2::2][::-1], axis=0)[::-1]
        out[0::2][: len(odd)] = odd
        out[1::2][: len(even)] = even
        out *= self.rise(index)
        return out

    def inner(self, f: Callable[[Array], Array], g: Callable[[Array], Array], nodes: int = 400) -> float:
        """<f, g> = integral of f g weight over [-1, 1] (eq. 2): `nodes` Gauss-Legendre points in arccos tau."""
        x, w = np.polynomial.legendre.leggauss(nodes)
        theta = (x + 1) * np.pi / 2
        tau = np.cos(theta)
        return float(np.sum(w * f(tau) * g(tau) * self.weight(tau) * np.sin(theta)) * np.pi / 2)


CHEBYSHEV = Family(
    name="chebyshev",
    alpha=lambda i: np.where(i == 0, 1.0, 2.0),
    gamma=np.ones_like,
    rise=lambda k: np.where(k == 0, 1.0, 2.0),
    fall=lambda j: j,
    weight=lambda tau: 1 / np.sqrt(1 - tau**2),
    norms=lambda i: np.where(i == 0, np.pi, np.pi / 2),
)
CHEBYSHEV2 = Family(
    name="chebyshev2",
    alpha=lambda i: np.full_like(i, 2.0),
    gamma=np.ones_like,
    rise=lambda k: 2 * (k + 1),
    fall=np.ones_like,
    weight=lambda tau: np.sqrt(1 - tau**2),
    norms=lambda i: np.full_like(i, np.pi / 2),
)
LEGENDRE = Family(
    name="legendre",
    alpha=lambda i: (2 * i + 1) / (i + 1),
    gamma=lambda i: i / (i + 1),
    rise=lambda k: 2 * k + 1,
    fall=np.ones_like,
    weight=np.ones_like,
    norms=lambda i: 2 / (2 * i + 1),
)
FAMILIES = {family.name: family for family in (CHEBYSHEV, CHEBYSHEV2, LEGENDRE)}


def family(name: str) -> Family:
    """The family of that name. Raises UsageError for a name that is not in `FAMILIES`."""
    if name not in FAMILIES:
        raise UsageError(f"unknown basis {name!r}", hint=f"choose one of: {', '.join(FAMILIES)}")
    return FAMILIES[name]


def chebyshev_points(count: int) -> Array:
    """The zeros (N,) of T_N, from the right."""
    return np.cos((np.arange(count) + 0.5) * np.pi / count)


def interpolate(values: Array) -> Array:
    """Chebyshev coefficients (N, ...) of the polynomials that take `values` (N, ...) at `chebyshev_points`."""
    coefficients: Array = scipy.fft.dct(values, axis=0) / len(values)
    coefficients[0] /= 2
    return coefficients


@lru_cache(maxsize=8)
def _to_chebyshev(source: Family, degree: int) -> Array:
    """Upper triangular matrix (n + 1, n + 1), column i: Chebyshev coefficients of P_i, by the recurrence of the family.

    Multiplying by tau is  tau T_0 = T_1,  tau T_k = (T_{k+1} + T_{k-1}) / 2.
    """
    index = np.arange(degree + 1.0)
    alpha, gamma = source.alpha(index), source.gamma(index)
    columns = np.zeros((degree + 1, degree + 2))
    columns[0, 0] = 1.0
    for i in range(degree):
        shifted = columns[i, :-1] / 2
        shifted[0] *= 2
        columns[i + 1, 1:] = alpha[i] * shifted
        columns[i + 1, :-2] += alpha[i] * columns[i, 1:-1] / 2
        columns[i + 1] -= gamma[i] * columns[i - 1] if i else 0.0
    return columns[:, :-1].T


def convert(coefficients: Array, source: Family, target: Family) -> Array:
    """The same polynomials, coefficients (n + 1, ...), in another family. Exact up to rounding; O(n^2) per signal."""
    if source is target:
        return coefficients
    flat = coefficients.reshape(len(coefficients), -1)
    if source is not CHEBYSHEV:
        flat = _to_chebyshev(source, len(flat) - 1) @ flat
    if target is not CHEBYSHEV:
        flat = scipy.linalg.solve_triangular(_to_chebyshev(target, len(flat) - 1), flat)
    return flat.reshape(coefficients.shape)
