"""Noise from repeats: where a motion comes again, the difference of the residuals of two passes is noise alone.

Nothing is assumed about the noise (colour, spectrum), and whatever the model misses is the same in both passes and
drops out. Differences of the motion itself drop out too, because residuals are compared, not torques.
"""

import numpy as np
import scipy.fft

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.equations.functions import moving_functions
from chebid.equations.gate import moving
from chebid.motion import Track

_ALIKE = 2e-3  # of the variance of the positions: two passes that differ by less (5 % in amplitude) repeat
_SHORTEST = 64  # samples in a period
_FEWEST = 8  # equations: from these on, the one number that is fitted to them does not count


def period(track: Track) -> int | None:
    """Number of samples after which the motion repeats, or None. Needs an even clock and 1.5 periods at least."""
    if not track.projections[0].operator.uniform:
        return None
    q = track.motion.q - track.motion.q.mean(axis=0)
    scale = q.std(axis=0)
    q = q[:, scale > 0] / scale[scale > 0]
    count = len(q)
    most = 2 * count // 3
    if q.shape[1] == 0 or most <= _SHORTEST:
        return None
    spectrum = scipy.fft.rfft(q, 2 * count, axis=0)
    product = scipy.fft.irfft(np.sum(np.abs(spectrum) ** 2, axis=1), 2 * count)[:most]
    energy = np.concatenate([[0.0], np.cumsum(np.sum(q**2, axis=1))])
    lags = np.arange(most)
    both = energy[count - lags] + energy[count] - energy[lags]
    unlike = (both - 2 * product) / np.maximum(both, np.finfo(float).tiny)
    candidates = lags[_SHORTEST:-1]
    at = unlike[candidates]
    lowest = (at < _ALIKE) & (at <= unlike[candidates - 1]) & (at <= unlike[candidates + 1])
    return int(candidates[lowest][0]) if lowest.any() else None


def repeat_floor(tracks: list[Track], dynamics: Dynamics, theta: Array, gate: Array, band: float) -> Array | None:
    """Noise (J,) in N.m or N within the band, from every track that repeats; None when none does.

    Without what a delay of the torque would make of that in which the passes differ: a drive that jitters never
    repeats its torque exactly, and a millisecond between torque and position then looks like noise.
    """
    products, equations, samples = np.zeros((len(gate), 2, 2)), np.zeros(len(gate)), np.zeros(len(gate))
    for track in tracks:
        lag = period(track)
        if lag is None:
            continue
        used = moving(track, gate)
        both = used[lag:] & used[:-lag]
        difference = _differences(track, dynamics, theta, lag)
        for functions in moving_functions(track, both, track.valid[lag:] & track.valid[:-lag], band):
            rows = functions.rows(difference[functions.piece])
            products += [row.T @ row for row in rows]
            equations += [len(row) for row in rows]
        samples += both.sum(axis=0)
    if np.any(samples < _SHORTEST) or np.any(equations < _FEWEST):
        return None
    energy = (products[:, 0, 0] - _delayed(products)) / 2
    return np.asarray(np.sqrt(energy / equations * _equations_per_sample(tracks, gate, band)))


def _differences(track: Track, dynamics: Dynamics, theta: Array, lag: int) -> Array:
    """Of two passes: their residuals, and the rates of the model's torque, (N - lag, J, 2)."""
    model = dynamics.torque(track.motion, theta)
    both = np.stack([track.torque - model, np.gradient(model, track.motion.t, axis=0)], axis=2)
    return both[lag:] - both[:-lag]


def _delayed(products: Array) -> Array:
    """Squares (J,) of that part of the first column which is a multiple of the second; products (J, 2, 2)."""
    mixed, power = products[:, 0, 1], products[:, 1, 1]
    return np.divide(mixed**2, power, out=np.zeros_like(mixed), where=power > 0)


def _equations_per_sample(tracks: list[Track], gate: Array, band: float) -> Array:
    """(J,) of the rows of all tracks, which differences of a shorter time have fewer of."""
    equations, samples = np.zeros((2, len(gate)))
    for track in tracks:
        used = moving(track, gate)
        for functions in moving_functions(track, used, track.valid, band):
            equations += [len(mix) for mix in functions.mix]
        samples += used.sum(axis=0)
    return np.asarray(equations / np.maximum(samples, 1))
