"""Variance of a residual as a function of frequency, joint by joint.

log v(f) is a polynomial in the root of the frequency, of a degree chosen by Akaike's criterion: constant for white
noise, falling for coloured noise, rising where noise of the positions is differentiated. Squares averaged over bands
of ten rows would make deviations that scatter by a quarter of themselves.

A residual is smaller than the noise, where the parameters took some of it. With theta = sum of y_r k_r over all rows,
e_r = y_r - w_r theta, h_r = w_r k_r and C = sum of v_r k_r k_r^T, the covariance of theta,

    E e_r^2 = (1 - 2 h_r) v_r + w_r C w_r^T,

so that each square counts as the share of itself that is left (a quasi-likelihood of squares: McCullagh and Nelder,
Generalized Linear Models, 1989, chapter 8). Variances and C are found in turns. What least squares with these
variances as weights would leave plays no part: where the model is wrong at some frequency, it would run away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chebid.basis import Array

DEGREE = 2
ROWS = 12  # for each coefficient, at least
_TURNS = 12
_SETTLED = 6  # turns after which the degrees stay as they are
_ROUNDS = 30
_LEAST = 0.02  # of its noise: the share that every row keeps at least
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Block:
    """Rows of one joint: W (R, P), influence (R, P) of each on theta, residual (R,), frequency (R,)."""

    W: Array
    influence: Array
    residual: Array
    frequency: Array


@dataclass(frozen=True)
class Spectrum:
    """Variances v (R,), and K (R, k), products of whose rows are the covariance of log v: how sure they are."""

    variance: Array
    unsure: Array


def spectra(blocks: Sequence[Block]) -> list[Spectrum]:
    """Variances of the noise of all rows that one theta was found from."""
    squares = [block.residual**2 for block in blocks]
    taken = [np.sum(block.W * block.influence, axis=1) for block in blocks]
    variances = [np.full(len(square), max(float(np.mean(square)), _TINY)) for square in squares]
    degrees, out = [list(range(DEGREE + 1))] * len(blocks), [Spectrum(v, np.ones((len(v), 1))) for v in variances]
    for turn in range(_TURNS):
        covariance = sum((b.influence * s.variance[:, None]).T @ b.influence for b, s in zip(blocks, out, strict=True))
        found = []
        for block, square, h, before, allowed in zip(blocks, squares, taken, out, degrees, strict=True):
            through = np.sum((block.W @ covariance) * block.W, axis=1) / before.variance
            found.append(_fit(square, np.clip(1 - 2 * h + through, _LEAST, 1.0), block.frequency, allowed))
        out = found
        if turn >= _SETTLED:
            degrees = [[spectrum.unsure.shape[1] - 1] for spectrum in out]
    return out


def spectrum(W: Array, Y: Array, frequency: Array) -> Spectrum:
    """Variance of the noise of Y = W theta + noise, W (R, P), by ordinary least squares."""
    influence = np.asarray(np.linalg.pinv(W).T, dtype=np.float64)
    return spectra([Block(W, influence, Y - W @ (influence.T @ Y), frequency)])[0]


def rooted(frequency: Array) -> Array:
    """The root of the frequency (R,) from -1 to 1, in which log v is a polynomial."""
    return np.asarray(2 * np.sqrt(frequency / max(float(frequency.max()), _TINY)) - 1, dtype=np.float64)


def _fit(square: Array, share: Array, frequency: Array, degrees: Sequence[int]) -> Spectrum:
    """The polynomial that is likeliest for squares (R,), each the share (R,) of a square of noise."""
    x = rooted(frequency)
    best, least = None, np.inf
    for degree in degrees:
        if best is not None and (share.sum() < ROWS * (degree + 1) or np.ptp(x) == 0):
            break
        B = np.asarray(np.polynomial.legendre.legvander(x, degree), dtype=np.float64)
        variance, likelihood = _likeliest(square / share, share, B)
        if degree + 1 - likelihood < least:
            best, least = (variance, B), degree + 1 - likelihood
    assert best is not None, "a degree is allowed"
    variance, B = best
    return Spectrum(variance, B @ np.linalg.cholesky(np.linalg.inv(0.5 * (B * share[:, None]).T @ B)))


def _likeliest(square: Array, count: Array, B: Array) -> tuple[Array, float]:
    """v = exp(B phi) (R,) of the largest likelihood of squares that count as much, and its logarithm (scoring)."""
    phi = np.zeros(B.shape[1])
    phi[0] = np.log(max(float(count @ square) / float(count.sum()), _TINY))
    information = np.linalg.inv((B * count[:, None]).T @ B)
    for _ in range(_ROUNDS):
        step = information @ (B.T @ (count * (square / np.exp(B @ phi) - 1)))
        phi = phi + np.clip(step, -1, 1)
        if np.max(np.abs(step)) < 1e-4:
            break
    variance = np.exp(B @ phi)
    return variance, -0.5 * float(np.sum(count * (np.log(variance) + square / variance)))
