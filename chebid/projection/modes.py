"""The two least-squares fits as one thing: samples -> modes -> coefficients.

On the samples of one window both fits have an orthonormal basis U (N, m) in which they act mode by mode:
    z = U^T x,   fitted samples = U (f z),   coefficients = G (g z)
with a transfer f and a gain g per mode. `DegreeModes` (eq. 11): f = 1 up to degree n and 0 above. `PenaltyModes`:
f = s^2 / (s^2 + weight), where the penalty is weight times the integral of the squared fourth derivative.
Since U is orthonormal, residuals, generalised cross-validation and the noise of any derivative follow from z, f and g.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from chebid.basis import CHEBYSHEV, LEGENDRE, Array

PENALISED = 4  # order of the derivative in the penalty


@dataclass(frozen=True)
class DegreeModes:
    """Least squares on Chebyshev polynomials (eq. 11), nested in the degree: mode i is the part that degree i adds."""

    samples: Array  # U (N, n + 1)
    synthesis: Array  # G (n + 1, n + 1): Chebyshev coefficients of the modes

    family = CHEBYSHEV

    def transfer(self, degree: float) -> Array:
        """F (m,) of the fit of that degree."""
        return (np.arange(self.samples.shape[1]) <= degree).astype(float)

    gain = transfer


@dataclass(frozen=True)
class PenaltyModes:
    """Penalised least squares: the Demmler-Reinsch basis of polynomials of degree n on the given samples."""

    samples: Array  # U (N, n + 1); the first four modes are the cubics, which the penalty leaves alone
    synthesis: Array  # G (n + 1, n + 1): Legendre coefficients of the modes
    singular: Array  # s (n - 3,), of the penalised modes

    family = LEGENDRE

    def transfer(self, weight: float) -> Array:
        """F (m,) under the penalty `weight`, in units of tau."""
        square = self.singular**2
        return np.concatenate([np.ones(PENALISED), square / (square + weight)])

    def gain(self, weight: float) -> Array:
        return np.concatenate([np.ones(PENALISED), self.singular / (self.singular**2 + weight)])


def degree_modes(tau: Array, degree: int) -> DegreeModes:
    """Modes of the least-squares fits of degree 0 .. `degree` on samples at `tau` (N,), N > degree."""
    u, r = np.linalg.qr(CHEBYSHEV.values(tau, degree))
    return DegreeModes(u, scipy.linalg.solve_triangular(r, np.eye(len(r))))


def penalty_modes(tau: Array, degree: int) -> PenaltyModes:
    """Modes of the penalised fits of degree n on samples at `tau` (N,), N > n >= 4.

    A polynomial is a cubic plus the fourfold integral of y = sum_j y_j p_j, p_j orthonormal Legendre, so that the
    penalty is |y|^2 exactly: nothing is differentiated, and the conditioning is that of integration.
    """
    parts = np.hstack([np.eye(degree + 1, PENALISED), _fourfold_integrals(degree)])
    q, r = np.linalg.qr(LEGENDRE.values(tau, degree) @ parts)
    u, singular, v = np.linalg.svd(r[PENALISED:, PENALISED:])
    q[:, PENALISED:] = q[:, PENALISED:] @ u
    # modes to coefficients of `parts`: the penalised ones by v, the cubic takes away what they have in common with it
    solve = np.eye(degree + 1)
    solve[PENALISED:, PENALISED:] = v.T
    solve[:PENALISED, PENALISED:] = -r[:PENALISED, PENALISED:] @ v.T
    solve[:PENALISED] = scipy.linalg.solve_triangular(r[:PENALISED, :PENALISED], solve[:PENALISED])
    return PenaltyModes(q, parts @ solve, singular)


def _fourfold_integrals(degree: int) -> Array:
    """Legendre coefficients (n + 1, n - 3) of a fourfold integral of the orthonormal p_0 .. p_{n-4}.

    From (2 j + 1) P_j = P'_{j+1} - P'_{j-1} (Abramowitz & Stegun 8.5.4); constants of integration are cubics, left out.
    """
    index = np.arange(degree + 1.0)
    out = np.diag(np.sqrt((2 * index + 1) / 2))[:, : degree + 1 - PENALISED]
    for _ in range(PENALISED):
        scaled = out / (2 * index + 1)[:, None]
        out = np.zeros_like(scaled)
        out[1:] += scaled[:-1]
        out[:-1] -= scaled[1:]
    return out
