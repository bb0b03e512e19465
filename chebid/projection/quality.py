"""How good a projection is, known before anyone identifies with it."""

import numpy as np
import scipy.signal

from chebid.basis import Array
from chebid.projection.operator import Operator

TOLERATED_SHARE = 3e-3  # of the acceleration's energy above the cut-off: beyond, an identification is biased
_END_FACTOR = 2.0  # an end is where the noise of the derivative is beyond this many times its median
_DENSE_WORK = 4e9  # operations: a costlier noise profile is replaced by its asymptotic law


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
    return gain / np.median(gain)


def end_length(operator: Operator, order: int) -> float:
    """Seconds at the worse end within which the noise of the derivative is beyond twice its median."""
    inside = np.flatnonzero(noise_profile(operator, order) <= _END_FACTOR)
    t = operator.t
    return float(max(t[inside[0]] - t[0], t[-1] - t[inside[-1]]))


def lag1_autocorrelation(residual: Array) -> float:
    """Correlation of neighbouring residuals (N,); near 0 when only white noise was left out."""
    r = residual - residual.mean()
    power = float(r @ r)
    return float(r[1:] @ r[:-1]) / power if power > 0 else 0.0


def energy_left_out(t: Array, fitted: Array, residual: Array, bandwidth: float) -> float:
    """Share of the acceleration's energy between the bandwidth and four times it, noise removed; all (N,), s and Hz.

    Spectra are weighted with f^4; the noise is the median of the residual's spectrum beyond four times the bandwidth
    (or in the upper fifth of the spectrum), and only what stands clear of its scatter counts.
    """
    rate = (len(t) - 1) / float(t[-1] - t[0])
    grid = np.linspace(t[0], t[-1], len(t))
    length = min(len(t), max(256, int(16 * rate / bandwidth)))
    segments = max(1, 2 * len(t) // length - 1)
    f, left = _spectrum(np.interp(grid, t, residual), rate, length)
    _, kept = _spectrum(np.interp(grid, t, fitted), rate, length)
    quiet = f > min(4 * bandwidth, 0.4 * rate)
    noise = float(np.median(left[quiet])) if np.any(quiet) else 0.0
    clear = np.where(left > noise * (1 + 4 / np.sqrt(segments)), left - noise, 0.0)
    band = (f > bandwidth) & (f <= 4 * bandwidth)
    lost, total = np.sum((f**4 * clear)[band]), np.sum((f**4 * kept)[f <= bandwidth])
    return float(lost / (lost + total)) if lost > 0 else 0.0


def _spectrum(x: Array, rate: float, length: int) -> tuple[Array, Array]:
    # a window whose side lobes fall fast: position spectra span ten decades
    f, power = scipy.signal.welch(x, rate, window="blackmanharris", nperseg=length, detrend=scipy.signal.detrend)
    return f, power
