"""Sums over all samples without the matrix P: sum_k w_k z_k^m for m = 0 .. M on the unit circle, z = exp(i theta).

With m = a B + b, z^m = (z^B)^a z^b: M + 1 sums over N samples become one matrix product of an (A, N) by an (N, B)
array, A B > M, so that only O(N sqrt(M)) powers are formed. Memory is one block of samples.

tau = cos(theta), so T_m(tau) = Re z^m, and the normal matrix of the Chebyshev projection (eq. 11) is Toeplitz + Hankel,
M_ij = (S_{i+j} + S_|i-j|) / 2 with S_m = Re sum_k z_k^m. On grids symmetric about 0, odd S vanish: M splits by parity
and half of the samples are enough.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array

ComplexArray = NDArray[np.complex128]
_BLOCK = 2048  # samples at a time: the buffers of one block stay in cache


def circle(tau: Array) -> ComplexArray:
    """exp(i arccos tau); both factors under the root are exact near the ends, where arccos is not."""
    return tau + 1j * np.sqrt(np.maximum((1 - tau) * (1 + tau), 0.0))


def fill_powers(z: ComplexArray, out: ComplexArray) -> None:
    """z**0, z**1, ... into the rows of `out`, by doubling: rounding grows with the log of their number."""
    out[0] = 1.0
    out[1:2] = z
    done = 2
    while done < len(out):
        step = min(done - 1, len(out) - done)
        np.multiply(out[1 : step + 1], out[done - 1], out=out[done : done + step])
        done += step


def power_sums(z: ComplexArray, weights: NDArray, highest: int) -> ComplexArray:
    """sum_k w_k z_k^m, m = 0 .. `highest`; z (N,), weights (N, J) real or complex: (highest + 1, J)."""
    inner = int(np.ceil(np.sqrt(highest + 1)))
    outer = -(-(highest + 1) // inner)
    total = np.zeros((weights.shape[1], outer, inner), dtype=complex)
    fine, coarse, scaled = (np.empty((rows, min(_BLOCK, len(z))), dtype=complex) for rows in (inner, outer, outer))
    for start in range(0, len(z), _BLOCK):
        piece = z[start : start + _BLOCK]
        f, c, s = (buffer[:, : len(piece)] for buffer in (fine, coarse, scaled))
        fill_powers(piece, f)
        fill_powers(f[-1] * piece, c)
        for j, weight in enumerate(weights[start : start + _BLOCK].T):
            total[j] += np.multiply(c, weight, out=s) @ f.T
    return total.reshape(weights.shape[1], -1)[:, : highest + 1].T


def normal_blocks(tau: Array, x: Array, degree: int) -> Iterator[tuple[slice, Array, Array]]:
    """The normal equations M c = P^T x of eq. 11 for x (N, J), as independent blocks (which coefficients, M, P^T x).

    One block in general, one for even and one for odd degrees on a grid symmetric about 0 (uniform sampling).
    """
    if np.max(np.abs(tau + tau[::-1])) <= 4 * np.finfo(float).eps:
        yield from _parity_blocks(tau, x, degree)
        return
    z = circle(tau)
    sums = power_sums(z, np.ones((len(tau), 1)), 2 * degree).real[:, 0]
    yield (
        slice(None),
        _toeplitz_hankel(sums, degree + 1, 0),
        power_sums(z, x, degree).real,
    )


def _parity_blocks(tau: Array, x: Array, degree: int) -> Iterator[tuple[slice, Array, Array]]:
    half = len(tau) // 2
    middle = len(tau) % 2
    z = circle(tau[: half + middle])
    once = np.full((len(z), 1), 2.0)
    even, odd = (
        x[: half + middle] + x[::-1][: half + middle],
        x[: half + middle] - x[::-1][: half + middle],
    )
    if middle:
        once[-1], even[-1] = 1.0, x[half]
    square = z * z
    sums = power_sums(square, once, degree).real[:, 0]
    yield (
        slice(0, None, 2),
        _toeplitz_hankel(sums, degree // 2 + 1, 0),
        power_sums(square, even, degree // 2).real,
    )
    if degree:
        count = (degree + 1) // 2
        moments = power_sums(square, odd * z[:, None], count - 1).real
        yield slice(1, None, 2), _toeplitz_hankel(sums, count, 1), moments


def _toeplitz_hankel(sums: Array, count: int, shift: int) -> Array:
    i = np.arange(count)
    return (sums[i[:, None] + i + shift] + sums[np.abs(i[:, None] - i)]) / 2
