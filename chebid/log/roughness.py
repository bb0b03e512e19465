"""How rough a sampled signal is: its quantisation, its local noise, and how far each sample is from its neighbours.

The measure of roughness is the distance of a sample from the cubic through its four neighbours,
r_i = x_i - (4 (x_{i-1} + x_{i+1}) - (x_{i-2} + x_{i+2})) / 6, a sixth of the fourth difference. White noise of
deviation s gives r a deviation of sqrt(70)/6 s; smooth motion gives next to nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from chebid.log.record import is_single, is_uniform

Array = NDArray[np.float64]

WHITE = np.sqrt(70.0) / 6.0  # deviation of r for white noise of deviation 1
_NORMAL = 1.4826  # deviation of normal noise per median of its magnitude
_EXACT = 1e-3  # of a count, to which steps are whole counts
_RARE = 1e-3
_BLOCK = 512  # samples over which noise is taken as constant


def roughness(t: Array, x: Array) -> Array:
    """|r| of every sample (N,); the two at each end take that of the third.

    On uneven stamps r is the distance from the cubic through the four neighbours at their own times, scaled so that
    white noise gives the same deviation as on even ones.
    """
    r = np.empty_like(x)
    if is_uniform(t):
        inner = x[2:-2] - (4.0 * (x[1:-3] + x[3:-1]) - (x[:-4] + x[4:])) / 6.0
    else:
        inner = _uneven(t, x)
    r[2:-2] = np.abs(inner)
    r[:2], r[-2:] = r[2], r[-3]
    return r


def _uneven(t: Array, x: Array) -> Array:
    """r (N - 4,) by Lagrange's formula on the four neighbours' stamps."""
    around = (t[:-4], t[1:-3], t[3:-1], t[4:])
    values = (x[:-4], x[1:-3], x[3:-1], x[4:])
    at, off, square = t[2:-2], x[2:-2].copy(), np.ones(len(t) - 4)
    for node, value in zip(around, values, strict=True):
        weight = np.ones_like(at)
        for other in around:
            if other is not node:
                weight *= (at - other) / (node - other)
        off -= weight * value
        square += weight**2
    return off * (WHITE / np.sqrt(square))


def local_noise(r: Array) -> Array:
    """Deviation (N,) of white noise that would give the roughness `r`, by the median over blocks."""
    count = max(len(r) // _BLOCK, 1)
    edges = np.linspace(0, len(r), count + 1).astype(int)
    whole = (len(r) // count) * count
    medians = np.median(r[:whole].reshape(count, -1), axis=1) if count > 1 else np.array([np.median(r)])
    return np.repeat(medians, np.diff(edges)) * (_NORMAL / WHITE)


def usual_noise(r: Array) -> float:
    """The noise where there is any: by the median of the roughness that is not zero."""
    some = _sample(r)
    some = some[some > 0]
    return float(np.median(some)) * _NORMAL / WHITE if len(some) else 0.0


def printed_resolution(x: Array, most: int = 7) -> Array | float:
    """Resolution (N,) of values written with few significant digits, which is coarser for larger values; else 0."""
    some = x[:: max(len(x) // 500, 1)]
    some = some[some != 0]
    for digits in range(3, most + 1):
        if len(some) and np.mean([float(f"{value:.{digits - 1}e}") == value for value in some.tolist()]) > 0.98:
            size = np.abs(x)
            exponent = np.floor(np.log10(np.where(size > 0, size, 1.0)))
            return np.where(size > 0, 10.0 ** (exponent - digits + 1), 0.0)
    return 0.0


def quantum(x: Array, fine: float = 0.0) -> float:
    """The step of an encoder that counts, 0 when the values are on no grid; they are written to within `fine`."""
    step = np.abs(np.diff(x))
    step = step[step > 1e-9 * np.ptp(x)]
    if len(step) == 0:
        return 0.0
    some = _sample(step)
    for least in (float(step.min()), float(np.partition(some, len(some) // 100)[len(some) // 100])):
        few = some[some < 50.5 * least] / least
        near = min(0.05, _EXACT + 2.0 * fine / least)
        if len(few) > 0.02 * len(some) and np.mean(np.abs(few - np.rint(few)) < near) > 0.95:
            return least
    return 0.0


@dataclass(frozen=True)
class Scale:
    """What is usual in one column, by which a suspect is judged; short stretches of rest alone would mislead.

    `fine` (N,) the least meaningful difference at each sample; `noise` its usual noise; `fastest` the speed (per s) and
    `longest` the step that one step in a thousand exceeds.
    """

    fine: Array
    noise: float
    fastest: float
    longest: float

    def at(self, places: NDArray[np.intp]) -> "Scale":
        """The same for some of the samples."""
        return Scale(self.fine[places], self.noise, self.fastest, self.longest)


def scale_of(t: Array, x: Array, cuts: Sequence[int] = ()) -> Scale:
    """The scale of `x` (N,) at stamps `t` (N,), neither noise nor speed taken across `cuts`."""
    stretches = [slice(low, high) for low, high in pairwise([0, *cuts, len(x)]) if high - low > 4]
    rough = [roughness(t[part], x[part]) for part in stretches]
    steps = np.concatenate([np.abs(np.diff(x[part])) for part in stretches] or [np.zeros(1)])
    speed = steps / np.concatenate([np.diff(t[part]) for part in stretches] or [np.ones(1)])
    noise = usual_noise(np.concatenate(rough)) if rough else 0.0
    return Scale(resolution(x), noise, _rarely_exceeded(speed), _rarely_exceeded(steps))


def _rarely_exceeded(values: Array) -> float:
    """The value that one in a thousand exceeds, and that the five largest do."""
    some = _sample(values)
    return float(np.quantile(some, 1.0 - min(max(_RARE, 5.0 / len(some)), 0.5)))


def _sample(values: Array) -> Array:
    """Every so many values, enough for a quantile."""
    return values[:: max(len(values) // 100_000, 1)]


def resolution(x: Array) -> Array:
    """Least meaningful difference (N,): the quantum, the printed digits or single precision, whichever is coarsest."""
    single = 2e-7 * np.abs(x) if is_single(x) else 1e-15 * np.abs(x)
    fine = np.maximum(printed_resolution(x), single)
    return np.maximum(quantum(x, float(np.median(fine))), fine)
