"""Least squares on the samples of one window, with or without a penalty: samples -> coefficients.

`Frame`: the polynomials on the samples, P = Q R. Least squares (eq. 11) is R^-1 Q^T. With a penalty |y|^2 on
x = null part + L y (see `spectrum`), the singular value decomposition of what R L adds to the null part gives modes,
    z = U^T Q^T x,   fitted samples = Q U (f z),   coefficients = G (g z),   f = s^2 / (s^2 + weight),
in which residual, degrees of freedom, likelihood and noise of any derivative are sums over f, g and z.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from chebid.basis import CHEBYSHEV, LEGENDRE, Array, Family
from chebid.projection.fold import Fold
from chebid.projection.spectrum import Spectrum

_ROUNDING = 1e-12  # of the largest singular value: what is smaller has no digits


@dataclass(frozen=True)
class Frame:
    """Polynomials of one fold on its samples: Q (H, k) orthonormal, R (k, n_b), k = min(H, n_b)."""

    fold: Fold
    degree: int
    samples: Array  # Q
    triangle: Array  # R

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


def frame(tau: Array, degree: int, fold: Fold, family: Family = LEGENDRE) -> Frame:
    """The polynomials of degree up to n on samples at tau (N,), orthonormalised."""
    return Frame(fold, degree, *np.linalg.qr(fold.polynomials(family, tau, degree)))


def degree_modes(tau: Array, degree: int) -> Frame:
    """Orthonormal polynomials `samples` (N, n + 1) on samples at tau (N,), nested in the degree: N > n."""
    return frame(tau, degree, Fold(), CHEBYSHEV)
