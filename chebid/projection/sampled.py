"""A signal as the choice of a plan looks at it: on a uniform grid, in stretches and tiles in which something moves."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from chebid.basis import Array
from chebid.projection.clock import is_uniform, rate_of
from chebid.projection.likelihood import Tiles
from chebid.projection.plan import limit
from chebid.projection.stairs import STAIRS, samples_per_change

_TILES = 128  # looked at, at most
_SEGMENTS, _SEGMENT = 16, 1 << 15  # number and samples of the stretches of a first look, at most
_OVERSAMPLING = 8  # rate of a tile over the frequency it resolves: means of samples stand for them
_QUIET = 1e-4  # of the energy of the liveliest tile: a tile at rest says nothing about motions
_GAP = 20  # median steps: a longer one cannot be interpolated


@dataclass(frozen=True)
class Sampled:
    """Samples x (N,) at `rate` Hz, between -1 and 1. `floor`: what rounding may have done to them."""

    x: Array
    rate: float
    floor: float

    @classmethod
    def of(cls, t: Array, x: Array) -> "Sampled":
        """Uneven stamps are interpolated, by cubics that do not overshoot; of a quantised signal, stairs are merged."""
        t, x = _longest_stretch(t, x)
        stairs = samples_per_change(x)
        largest = float(np.max(np.abs(x)))
        x = x - x.mean()
        scale = float(np.max(np.abs(x))) or 1.0
        floor = max(2 * np.finfo(float).eps * largest / scale, 1e-150)
        x = x / scale
        if not is_uniform(t):
            x = PchipInterpolator(t, x)(np.linspace(t[0], t[-1], len(t)))
        merged = int(stairs) if stairs >= STAIRS else 1
        return cls(_means(x, merged), rate_of(t) / merged, floor)

    @property
    def span(self) -> float:
        """Duration in s."""
        return (len(self.x) - 1) / self.rate

    def segments(self) -> Array:
        """Overlapping stretches (K, N_s)."""
        length = max(min(len(self.x), 256), min(len(self.x) // 4, _SEGMENT))
        count = min(2 * len(self.x) // length - 1, _SEGMENTS)
        starts = np.linspace(0, len(self.x) - length, count).astype(int)
        return _lively(self.x[starts[:, None] + np.arange(length)])

    def whole(self, degree: int) -> Tiles:
        """The record as one tile."""
        x, rate = self._merged(degree / (np.pi * self.span))
        return Tiles(x[None], rate, min(degree, limit("smooth", len(x))), self.floor)

    def rung(self, cut: float) -> int:
        """The highest rung of a ladder, rate / 2 over 2^(rung / 2), that resolves `cut` Hz: tiles come in few sizes."""
        return max(0, int(2 * np.log2(self.rate / 2 / max(cut, 6 / self.span))))

    def tiles(self, rung: int, degree: int) -> Tiles:
        """Tiles side by side of that degree, or a higher one where there are few."""
        cut = self.rate / 2 * 2 ** (-rung / 2)
        x, rate = self._merged(cut)
        size = round(degree / (np.pi * cut) * rate)
        count = max(1, len(x) // size)
        if count < 8:
            size = len(x) // count
        degree = int(np.clip(round(np.pi * cut * size / rate), 12, limit("smooth", size)))
        return Tiles(_lively(x[: size * count].reshape(count, size)), rate, degree, self.floor)

    def _merged(self, cut: float) -> tuple[Array, float]:
        """Means of neighbouring samples, and their rate, where the rate is much higher than a frequency looked at."""
        merged = max(1, int(self.rate / (_OVERSAMPLING * cut)))
        return _means(self.x, merged), self.rate / merged


def _longest_stretch(t: Array, x: Array) -> tuple[Array, Array]:
    """The samples between two gaps."""
    steps = np.diff(t)
    edges = np.concatenate([[0], np.flatnonzero(steps > _GAP * np.median(steps)) + 1, [len(t)]])
    best = int(np.argmax(np.diff(edges)))
    where = slice(int(edges[best]), int(edges[best + 1]))
    return t[where], x[where]


def _means(x: Array, merged: int) -> Array:
    """Means (N // merged,) of neighbouring samples."""
    return x[: len(x) // merged * merged].reshape(-1, merged).mean(axis=1) if merged > 1 else x


def _lively(x: Array) -> Array:
    """The stretches (K, N_t) in which something moves, but for a ramp; of many, some from everywhere."""
    ramp = np.linspace(-1, 1, x.shape[1])
    level = x - x.mean(axis=1, keepdims=True)
    level -= np.outer(level @ ramp / (ramp @ ramp), ramp)
    energy = np.einsum("ij,ij->i", level, level)
    kept = np.flatnonzero(energy >= _QUIET * energy.max())
    return x[kept[np.linspace(0, len(kept) - 1, min(len(kept), _TILES)).round().astype(int)]]
