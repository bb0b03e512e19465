"""What the sensors add: torque noise, white or coloured, and the averaging of the torque."""

import numpy as np
from scipy.signal import lfilter

from chebid.robots import Array

CORRELATION_TIME = 0.02  # s: coloured noise has the autocorrelation exp(-abs(delay) / 0.02 s)


def torque_noise(random: np.random.Generator, kind: str, sd: Array, count: int, step: float) -> Array:
    """(N, J) of the given standard deviations (J,): `white`, or `coloured`, an AR(1) process of that correlation."""
    white = random.standard_normal((count, len(sd)))
    if kind == "none":
        return np.zeros_like(white)
    if kind == "coloured":
        memory = np.exp(-step / CORRELATION_TIME)
        start, white[1:] = white[:1].copy(), white[1:] * np.sqrt(1 - memory**2)
        white[0] = start
        white = lfilter([1.0], [1.0, -memory], white, axis=0)
    return white * sd


def encoder(q: Array, count: Array, phase: Array) -> Array:
    """(N, J) of what the encoders show: whole counts from a zero that lies `phase` of a count beside theirs."""
    counts = np.where(count > 0, count, 1.0)
    return np.where(count > 0, count * (np.rint(q / counts + phase) - phase), q)


def averaged(clock: Array, drive: Array, at: Array, step: float) -> Array:
    """(N, J) means of the held torque (K, J) over `step` s centred on each instant `at` (N,), cut at both ends."""
    knots = np.append(clock, max(at[-1], clock[-1]) + step)
    total = np.vstack([np.zeros(drive.shape[1]), np.cumsum(np.diff(knots)[:, None] * drive, axis=0)])
    low, high = np.clip([at - step / 2, at + step / 2], clock[0], max(at[-1], clock[-1]))
    tiny = 1e-6 * step  # an instant before the start or after the end has the first or last torque
    low, high = np.where(high - low < tiny, [np.minimum(low, knots[-1] - tiny), high + tiny], [low, high])
    ends = [np.column_stack([np.interp(x, knots, column) for column in total.T]) for x in (low, high)]
    return (ends[1] - ends[0]) / (high - low)[:, None]


def held(clock: Array, drive: Array, at: Array, step: float) -> Array:
    """(N, J) torque that the drive was last commanded at each instant."""
    period = clock[1] - clock[0] if len(clock) > 1 else step
    last = np.searchsorted(clock, at + 1e-9 * period, side="right") - 1
    return drive[np.clip(last, 0, len(clock) - 1)]
