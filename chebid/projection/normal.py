"""Least squares on Chebyshev polynomials (eq. 11) by the fast normal equations, safe up to n = 4 sqrt(N).

The normal matrix is Toeplitz + Hankel, M_ij = (S_{i+j} + S_|i-j|) / 2 with S_m = sum_k T_m(tau_k). On a grid symmetric
about 0 odd S vanish: M splits into even and odd degrees, and half of the samples are enough, in powers of z^2. On a
uniform grid M depends on (N, n) alone, and its factors are kept.
"""

from functools import lru_cache

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.projection.fold import symmetric_grid
from chebid.projection.sums import circle, real_sums
from chebid.projection.uniform_sums import uniform_sums

_KEPT = 1000  # degree up to which factors are kept


def least_squares(tau: Array, x: Array, degree: int) -> Array:
    """Chebyshev coefficients (n + 1, J) of samples x (N, J) at tau (N,)."""
    if not np.array_equal(tau, -tau[::-1]):
        z = circle(tau)
        factor = _factor(real_sums(z, [np.ones((len(tau), 1))], 2 * degree)[0][:, 0], degree + 1, 0)
        return _solve(factor, real_sums(z, [x], degree)[0])
    out = np.empty((degree + 1, x.shape[1]))
    for parity, moments in enumerate(_moments(tau, x, degree)):
        out[parity::2] = _solve(_factors(tau, degree)[parity], moments)
    return out


def _moments(tau: Array, x: Array, degree: int) -> tuple[Array, Array]:
    """P^T x for even and for odd degrees, on a symmetric grid."""
    half, middle = divmod(len(tau), 2)
    z, turned = circle(tau[: half + middle]), x[::-1]
    even, odd = x[: half + middle] + turned[: half + middle], x[: half + middle] - turned[: half + middle]
    even[half:] /= 2
    sums = real_sums(z * z, [even, odd * z[:, None]], degree // 2)
    return sums[0], sums[1][: (degree + 1) // 2]


def _factors(tau: Array, degree: int) -> tuple[Array, ...]:
    """Cholesky factors of the even and of the odd block, on a symmetric grid."""
    if np.array_equal(tau, symmetric_grid(len(tau))):
        return _uniform_factors(len(tau), degree) if degree <= _KEPT else _blocks(uniform_sums(len(tau), 2 * degree))
    half, middle = divmod(len(tau), 2)
    once = np.full((half + middle, 1), 2.0)
    once[half:] = 1.0
    return _blocks(real_sums(circle(tau[: half + middle]) ** 2, [once], degree)[0][:, 0])


@lru_cache(maxsize=8)
def _uniform_factors(samples: int, degree: int) -> tuple[Array, ...]:
    return _blocks(uniform_sums(samples, 2 * degree))


def _blocks(sums: Array) -> tuple[Array, ...]:
    """Factors from S_0, S_2 .. S_2n."""
    return tuple(_factor(sums, (len(sums) + 1 - parity) // 2, parity) for parity in (0, 1))


def _factor(sums: Array, count: int, shift: int) -> Array:
    """Cholesky factor (count, count) of M_ij = (S_{i+j+shift} + S_|i-j|) / 2."""
    i = np.arange(count)
    matrix = (sums[i[:, None] + i + shift] + sums[np.abs(i[:, None] - i)]) / 2
    return scipy.linalg.cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)


def _solve(factor: Array, moments: NDArray) -> Array:
    return scipy.linalg.cho_solve((factor, True), moments, check_finite=False)
