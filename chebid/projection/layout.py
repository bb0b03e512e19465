"""How a record is divided: one interval, or equal overlapping windows whose results are blended.

Windows overlap by half. Within each overlap the result passes smoothly from the left window to the right one over its
middle 40 %, so that the outer 30 % of the half-length of a window, where a projection is least certain, is never used
except at the two ends of the record.
"""

from dataclasses import dataclass

import numpy as np

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
        left, right = self.start[1:], self.stop[:-1]
        middle, width = (left + right) / 2, _RAMP * (right - left)
        return middle - width / 2, middle + width / 2

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
    """The record at times `t` (N,) in half-overlapping windows of about `length` s that fit it exactly."""
    span = float(t[-1] - t[0])
    count = max(1, round(2 * span / length - 1))
    if count == 1:
        return Layout(t[:1].copy(), t[-1:].copy())
    step = span / (len(t) - 1)
    width = np.ceil(2 * span / (count + 1) / step) * step
    # whole sample steps, so that on a uniform grid every window has the same local times
    start = t[0] + np.round(np.linspace(0, span - width, count) / step) * step
    return Layout(start, start + width)
