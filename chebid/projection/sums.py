"""Sums over all samples without the matrix P: Re sum_k w_k z_k^m for m = 0 .. M on the unit circle, z = exp(i theta).

With m = a B + b, z^m = (z^B)^a z^b: M + 1 sums over N samples become one product of an (A, 2 N) by a (2 N, B) matrix of
real and imaginary parts, A B > M, so that only O(N sqrt(M)) powers are formed. Memory is one block of samples.

tau = cos(theta), so that T_m(tau) = Re z^m and sin(m theta) = Re(-i z^m).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array

ComplexArray = NDArray[np.complex128]
_BLOCK = 1024  # samples at a time: the buffers of one block stay in cache


def circle(tau: Array) -> ComplexArray:
    """exp(i arccos tau); both factors under the root are exact near the ends, where arccos is not."""
    return tau + 1j * np.sqrt(np.maximum((1 - tau) * (1 + tau), 0.0))


def real_sums(z: ComplexArray, weights: Sequence[ComplexArray | Array], highest: int) -> list[Array]:
    """Re sum_k w_k z_k^m, m = 0 .. `highest`, (highest + 1, J), for z (N,) and each of the weights (N, J)."""
    inner = int(np.ceil(np.sqrt(highest + 1)))
    outer = -(-(highest + 1) // inner)
    totals = [np.zeros((w.shape[1], outer, inner)) for w in weights]
    fine, coarse = (np.empty((rows, min(_BLOCK, len(z))), dtype=complex) for rows in (inner, outer))
    for start in range(0, len(z), _BLOCK):
        piece = z[start : start + _BLOCK]
        f, c = fine[:, : len(piece)], coarse[:, : len(piece)]
        _fill_powers(piece, f)
        _fill_powers(np.conj(f[-1] * piece), c)
        for total, weight in zip(totals, weights, strict=True):
            _add(total, c, f, weight[start : start + _BLOCK])
    return [total.reshape(len(total), -1)[:, : highest + 1].T for total in totals]


def _add(total: Array, coarse: ComplexArray, fine: ComplexArray, weight: NDArray) -> None:
    """Add Re (w z^{aB}) z^b, summed over the samples of a block, to `total` (J, A, B); `coarse` is conjugate."""
    if np.iscomplexobj(weight):
        scaled = _parts(coarse * np.conj(weight.T)[:, None, :])
    else:
        scaled = _parts(coarse) * np.repeat(weight.T, 2, axis=1)[:, None, :]
    total += (scaled.reshape(-1, scaled.shape[2]) @ _parts(fine).T).reshape(total.shape)


def _parts(a: ComplexArray) -> Array:
    """Real and imaginary parts (..., 2 N) side by side."""
    return np.ascontiguousarray(a).view(float)


def _fill_powers(z: ComplexArray, out: ComplexArray) -> None:
    """z**0, z**1, ... into the rows of `out`, by doubling: rounding grows with the log of their number."""
    out[0] = 1.0
    out[1:2] = z
    done = 2
    while done < len(out):
        step = min(done - 1, len(out) - done)
        np.multiply(out[1 : step + 1], out[done - 1], out=out[done : done + step])
        done += step
