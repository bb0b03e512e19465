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
    """Noise (J,) in N.m or N within the band, from every track that repeats; None when none does."""
    energy, equations, samples = np.zeros((3, len(dynamics.joints)))
    for track in tracks:
        lag = period(track)
        if lag is None:
            continue
        used = moving(track, gate)
        both = used[lag:] & used[:-lag]
        residual = track.torque - dynamics.torque(track.motion, theta)
        difference = (residual[lag:] - residual[:-lag])[:, :, None]
        for functions in moving_functions(track, both, track.valid[lag:] & track.valid[:-lag], band):
            rows = functions.rows(difference[functions.piece])
            energy += [float(np.sum(row**2)) / 2 for row in rows]
            equations += [len(row) for row in rows]
        samples += both.sum(axis=0)
    if np.any(samples < _SHORTEST) or np.any(equations == 0):
        return None
    return np.asarray(np.sqrt(energy / equations * _equations_per_sample(tracks, gate, band)))


def _equations_per_sample(tracks: list[Track], gate: Array, band: float) -> Array:
    """(J,) of the rows of all tracks, which differences of a shorter time have fewer of."""
    equations, samples = np.zeros((2, len(gate)))
    for track in tracks:
        used = moving(track, gate)
        for functions in moving_functions(track, used, track.valid, band):
            equations += [len(mix) for mix in functions.mix]
        samples += used.sum(axis=0)
    return np.asarray(equations / np.maximum(samples, 1))
