"""How good a projection is, known before anyone identifies with it."""

from itertools import pairwise

import numpy as np
import scipy.signal

from chebid.basis import Array
from chebid.projection.clock import rate_of
from chebid.projection.operator import Operator
from chebid.projection.stairs import samples_per_change

TOLERATED_SHARE = 3e-3  # of the acceleration's energy above the cut-off: beyond, an identification is biased
END_FACTOR = 2.0  # an end is where the noise of the derivative is beyond this many times its median
_DENSE_WORK = 4e9  # operations: a costlier noise profile is replaced by its asymptotic law
_CYCLES = 16  # of the cut-off in a segment of a spectrum
_CHANCE = 8.0  # standard deviations of a mean of squares, which has a long tail
_CLEAR = 3.0  # times the noise: a band of the residual that holds more holds motion


def noise_profile(operator: Operator, order: int) -> Array:
    """Noise (N,) of a derivative at the samples, relative to its median over the record.

    From the operator itself; for very large least-squares problems by its law (1 - tau^2)^(-(2 k + 1) / 4), from the
    local cut-off fc / sqrt(1 - tau^2) of polynomials.
    """
    plan = operator.plan
    if operator.layout.count == 1 and len(operator.t) * plan.degree**2 > _DENSE_WORK:
        tau = np.clip(operator.layout.tau(0, operator.t), -1, 1)
        gain = np.maximum(1 - tau**2, plan.degree**-2.0) ** (-(2 * order + 1) / 4)
    else:
        gain = operator.noise_gain(order)
    middle = np.median(gain)
    return gain / middle if middle > 0 else np.ones_like(gain)  # a derivative that is zero whatever the samples


def inside(operator: Operator, order: int) -> slice:
    """The samples between the ends: from the first to the last where noise is no more than twice its median."""
    index = np.flatnonzero(noise_profile(operator, order) <= END_FACTOR)
    return slice(int(index[0]), int(index[-1]) + 1)


def end_length(operator: Operator, order: int) -> float:
    """Seconds at the worse end within which the noise of the derivative is beyond twice its median."""
    t, where = operator.t, inside(operator, order)
    return float(max(t[where.start] - t[0], t[-1] - t[where.stop - 1]))


def lag1_autocorrelation(residual: Array) -> float:
    """Correlation of neighbouring residuals (N,); near 0 when only white noise was left out."""
    r = residual - residual.mean()
    r = r / (float(np.max(np.abs(r))) or 1.0)
    power = float(r @ r)
    return float(r[1:] @ r[:-1]) / power if power > 0 else 0.0


def energy_left_out(t: Array, acceleration: Array, residual: Array, bandwidth: float, floor: float) -> float:
    """Share of the acceleration's energy between the bandwidth and four times it, noise removed; (N,), s and Hz.

    The spectrum of the residual is weighted with (2 pi f)^4. The noise is its median beyond four times the bandwidth
    (or in the upper fifth of the spectrum), no less than `floor` (see `noise_floor`); thirds of an octave that hold
    three times as much, and more than chance, hold motion.
    """
    rate, scale = rate_of(t), float(np.max(np.abs(residual))) or 1.0
    length = min(len(t), max(256, int(_CYCLES * rate / bandwidth)))
    f, power = _spectrum(np.interp(np.linspace(t[0], t[-1], len(t)), t, residual / scale), rate, length)
    quiet = power[f > min(4 * bandwidth, 0.4 * rate)]
    noise = max(float(np.median(quiet)) if len(quiet) else 0.0, (floor / scale) ** 2)
    weight, lost = (2 * np.pi * f) ** 4 * f[1], 0.0
    edges = bandwidth * 2 ** (np.arange(7) / 3)
    for low, high in pairwise(edges):
        band = (f > low) & (f <= high)
        left, noisy = np.sum((weight * power)[band]), noise * np.sum(weight[band])
        values = max(1.0, np.count_nonzero(band) * len(t) / length / 2)  # independent ones: the taper joins neighbours
        lost += left - noisy if left > (_CLEAR + _CHANCE / np.sqrt(values)) * noisy else 0.0
    kept = float(np.mean((acceleration / scale) ** 2))
    return float(lost / (lost + kept)) if lost > 0 else 0.0


def energy_beyond(t: Array, acceleration: Array, frequency: float) -> float:
    """Share of the energy of accelerations (N,) at t (N,) s above a frequency in Hz."""
    scale = float(np.max(np.abs(acceleration))) or 1.0
    grid = np.linspace(t[0], t[-1], len(t))
    f, power = _spectrum(np.interp(grid, t, acceleration / scale), rate_of(t), min(len(t), 1024))
    total = float(power.sum())
    return float(power[f > frequency].sum()) / total if total > 0 else 0.0


def noise_floor(x: Array, rate: float) -> float:
    """Density (root of squares per Hz) of what samples x (N,) cannot be without: rounding, and counts, however slow."""
    steps = np.abs(np.diff(x))
    count = float(np.min(steps[steps > 0], initial=np.max(steps)))
    rounding = 8 * np.finfo(float).eps * float(np.max(np.abs(x)))
    return float(np.hypot(rounding, count * np.sqrt(samples_per_change(x) / 12)) * np.sqrt(2 / rate))


def _spectrum(x: Array, rate: float, length: int) -> tuple[Array, Array]:
    # a window whose side lobes fall fast: what is left of a position spans many decades
    f, power = scipy.signal.welch(x, rate, window="blackmanharris", nperseg=length, detrend=scipy.signal.detrend)
    return f, power
