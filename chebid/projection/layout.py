"""How a record is divided: one interval, or equal overlapping windows whose results are blended.

Windows overlap by half. Within each overlap the result passes smoothly from the left window to the right one over its
middle 40 %, so that the outer 30 % of the half-length of a window, where a projection is least certain, is never used
except at the two ends of the record.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array

_RAMP = 0.4  # share of an overlap over which the blend passes from 0 to 1


@dataclass(frozen=True)
class Layout:
    """Intervals [start, stop] in s of the windows of one record, in order; shape (W,) each."""

    start: Array
    stop: Array

    @property
    def count(self) -> int:
        return len(self.start)

    @property
    def half(self) -> Array:
        """Half-lengths (W,) in s: the factor 2 / (tf - t0) of eq. 13 is its inverse."""
        return (self.stop - self.start) / 2

    def tau(self, window: int, t: Array) -> Array:
        """Times (N,) in s to [-1, 1] of one window (eq. 4)."""
        middle = (self.start[window] + self.stop[window]) / 2
        return (t - middle) / self.half[window]

    def ramps(self) -> tuple[Array, Array]:
        """Start and stop in s of the blends between neighbours; shape (W - 1,) each."""
        return self._ramps

    @cached_property
    def _ramps(self) -> tuple[Array, Array]:
        left, right = self.start[1:], self.stop[:-1]
        middle, width = (left + right) / 2, _RAMP * (right - left)
        return middle - width / 2, middle + width / 2

    def touched(self, t: Array) -> range:
        """The windows that have weight at some of the sorted times `t` (N,)."""
        if len(t) == 0:
            return range(0)
        begin, end = self.ramps()
        return range(int(np.searchsorted(end, t[0])), int(np.searchsorted(begin, t[-1], "right")) + 1)

    def active(self, window: int, t: Array) -> slice:
        """Indices of the sorted times `t` (N,) at which the window has weight."""
        begin, end = self.ramps()
        first = np.searchsorted(t, begin[window - 1], "left") if window > 0 else 0
        last = np.searchsorted(t, end[window], "right") if window < self.count - 1 else len(t)
        return slice(int(first), int(last))

    def weight(self, window: int, t: Array) -> Array:
        """Blending weight (N,) of the window at times inside its active range; the weights of all windows sum to 1."""
        begin, end = self.ramps()
        out = np.ones(len(t))
        if window > 0:
            out *= _step((t - begin[window - 1]) / (end[window - 1] - begin[window - 1]))
        if window < self.count - 1:
            out *= 1 - _step((t - begin[window]) / (end[window] - begin[window]))
        return out


def _step(u: Array) -> Array:
    """0 below 0, 1 above 1, with three continuous derivatives between (smoothstep of degree 7)."""
    u = np.clip(u, 0.0, 1.0)
    return u**4 * (35 - u * (84 - u * (70 - 20 * u)))


def divide(t: Array, length: float) -> Layout:
    """The record at times `t` (N,) in half-overlapping windows of about `length` s that fit it exactly.

    They begin every `hop` mean steps, so that on a uniform grid every window has the same local times.
    """
    steps = len(t) - 1
    step = float(t[-1] - t[0]) / steps
    hop, count = _hop(steps, length / step)
    if count == 1:
        return Layout(t[:1].copy(), t[-1:].copy())
    start = t[0] + step * hop * np.arange(count)
    return Layout(start, start + step * (steps - hop * (count - 1)))


def samples_in(t: Array, layout: Layout) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First sample (W,) of each window of the record at times `t` (N,), and one past its last."""
    near = (t[-1] - t[0]) / max(len(t) - 1, 1) / 4
    return np.searchsorted(t, layout.start - near), np.searchsorted(t, layout.stop + near)


def usual_samples(t: Array, window: float | None) -> int:
    """Samples (median) of the windows of that length in s."""
    if window is None:
        return len(t)
    first, last = samples_in(t, divide(t, window))
    return int(np.median(last - first))


def _hop(steps: int, width: float) -> tuple[int, int]:
    """Steps from window to window, and number of windows: two hops and what is left of the record make a window.

    Of all hops within a tenth of half the width, the one whose windows come nearest to it.
    """
    if 3 * width > 4 * steps:
        return steps, 1
    hops = np.arange(max(1, int(0.45 * width)), max(2, int(0.55 * width) + 1) + 1)
    counts = np.maximum(steps // hops - 1, 1)
    best = int(np.argmin(np.abs(steps - hops * (counts - 1) - width)))
    return int(hops[best]), int(counts[best])
