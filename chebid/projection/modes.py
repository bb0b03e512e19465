"""Least squares on the samples of one window, with or without a penalty: samples -> coefficients.

`Frame`: the polynomials on the samples, P = Q R. Least squares (eq. 11) is R^-1 Q^T. With a penalty |y|^2 on
x = null part + L y (see `spectrum`), the singular value decomposition of what R L adds to the null part gives modes,
    z = U^T Q^T x,   fitted samples = Q U (f z),   coefficients = G (g z),   f = s^2 / (s^2 + weight),
in which residual, degrees of freedom, likelihood and noise of any derivative are sums over f, g and z.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from chebid.basis import CHEBYSHEV, LEGENDRE, Array, Family
from chebid.projection.fold import Fold
from chebid.projection.spectrum import Spectrum

_WELL = 4.0  # n_b^2 / H up to which polynomials on samples are well conditioned: exp(0.45 n^2 / N) is below 40
_STORED = 1 << 24  # samples times degree up to which Q is kept: 128 MB
_BLOCK = 4096
_ROUNDING = 1e-12  # of the largest singular value: what is smaller has no digits


@dataclass(frozen=True)
class Frame:
    """Polynomials of one fold on its samples: Q (H, k) orthonormal, R (k, n_b), k = min(H, n_b)."""

    fold: Fold
    degree: int
    samples: Array  # Q
    triangle: Array  # R

    def coordinates(self, x: Array) -> Array:
        """Q^T x (..., k) of samples x (..., N)."""
        return self.fold.samples(x) @ self.samples

    def inverse(self) -> Array:
        """R^-1 (n_b, n_b): coefficients of least squares from Q^T x; for n < N."""
        return scipy.linalg.solve_triangular(self.triangle, np.eye(len(self.triangle)))

    def modes(self, spectrum: Spectrum) -> "Modes":
        """The modes of that penalty, `band` in cycles per window. The frame is one of Legendre polynomials."""
        where = self.fold.degrees(self.degree)
        free = len(range(min(spectrum.null, self.degree + 1))[where])
        columns = spectrum.columns(self.degree)[where]
        columns = columns[:, np.any(columns, axis=0)]
        seen = self.triangle @ columns
        u, singular, v = _decompose(seen[free:])
        return Modes(self, free, u, singular, columns @ v.T, seen[:free] @ v.T)


def _decompose(a: Array) -> tuple[Array, Array, Array]:
    if a.size == 0:
        return np.zeros((len(a), 0)), np.zeros(0), np.zeros((0, a.shape[1]))
    u, singular, v = np.linalg.svd(a, full_matrices=False)
    sound = singular > _ROUNDING * singular[0]
    return u[:, sound], singular[sound], v[sound]


@dataclass(frozen=True)
class Modes:
    """Modes of a penalised fit: the `free` first coordinates as they are, the others turned by U."""

    frame: Frame
    free: int
    turn: Array  # U (k - free, K)
    singular: Array  # s (K,)
    shapes: Array  # Legendre coefficients L V (n_b, K)
    shared: Array  # what they have of the free polynomials (free, K)

    def transfer(self, weight: float) -> Array:
        """F (K,) of the penalised modes."""
        return self.singular**2 / (self.singular**2 + weight)

    def coefficients(self, weight: float) -> Array:
        """Matrix (n_b, k): Legendre coefficients of the fit from Q^T x."""
        gain = (self.singular / (self.singular**2 + weight))[:, None] * self.turn.T
        out = np.hstack([np.zeros((len(self.shapes), self.free)), self.shapes @ gain])
        # the free polynomials take what is theirs and give up what the others have of them
        rest = np.hstack([np.eye(self.free), -self.shared @ gain])
        out[: self.free] += scipy.linalg.solve_triangular(self.frame.triangle[: self.free, : self.free], rest)
        return out


@dataclass(frozen=True)
class LongFrame(Frame):
    """The same for so many samples that Q is not kept: Q^T x = R^-T P^T x, a block of samples at a time."""

    tau: Array
    family: Family

    def coordinates(self, x: Array) -> Array:
        folded = self.fold.samples(x)
        moments = np.zeros((*folded.shape[:-1], len(self.triangle)))
        for rows, p in _blocks(self.fold, self.family, self.tau, self.degree):
            moments += folded[..., rows] @ p
        return moments @ self.inverse()


def frame(tau: Array, degree: int, fold: Fold, family: Family = LEGENDRE) -> Frame:
    """The polynomials of degree up to n on samples at tau (N,), orthonormalised."""
    if len(tau) * (degree + 1) <= _STORED:
        return Frame(fold, degree, *_orthonormalise(fold.polynomials(family, tau, degree)))
    # so many samples per degree are well conditioned: the square of P does
    count = len(range(degree + 1)[fold.degrees(degree)])
    square = np.zeros((count, count))
    for _, p in _blocks(fold, family, tau, degree):
        square += p.T @ p
    return LongFrame(fold, degree, np.empty((0, 0)), scipy.linalg.cholesky(square), tau, family)


def _blocks(fold: Fold, family: Family, tau: Array, degree: int) -> Iterator[tuple[slice, Array]]:
    """Rows of P on a fold, some at a time."""
    for start in range(0, fold.rows(len(tau)), _BLOCK):
        rows = slice(start, min(start + _BLOCK, fold.rows(len(tau))))
        yield rows, fold.polynomials(family, tau, degree, rows)


def _orthonormalise(p: Array) -> tuple[Array, Array]:
    """Q (H, k), R (k, n_b) of p (H, n_b); where p is well conditioned by two Cholesky factorisations, which are faster.

    Yamamoto et al., Electron. Trans. Numer. Anal. 44, 2015: as good as reflections for condition numbers below 1e8.
    """
    rows, columns = p.shape
    if columns**2 > _WELL * rows:
        return np.linalg.qr(p)
    try:
        q, first = _cholesky_step(p)
        q, second = _cholesky_step(q)
    except np.linalg.LinAlgError:  # stamps with large gaps
        return np.linalg.qr(p)
    return q, second @ first


def _cholesky_step(p: Array) -> tuple[Array, Array]:
    r = scipy.linalg.cholesky(p.T @ p)
    return p @ scipy.linalg.solve_triangular(r, np.eye(len(r))), r


def degree_modes(tau: Array, degree: int) -> Frame:
    """Orthonormal polynomials `samples` (N, n + 1) on samples at tau (N,), nested in the degree: N > n."""
    return frame(tau, degree, Fold(), CHEBYSHEV)
