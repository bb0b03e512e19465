"""How likely the samples are under a penalty: restricted maximum likelihood, which chooses its weight and its shape.

On tiles of N_t samples, side by side, the modes z of a penalised fit (see `modes`) are independent with variances
sigma^2 / (1 - f), and the rest of the samples is noise. With sigma^2 put where it is most likely,

    -2 log L / N = log sigma^2 - sum log(1 - f) / N,     sigma^2 = (rest + sum (1 - f) z^2) / N,

N without the free polynomials (Wahba, Ann. Statist. 13, 1985; Rasmussen & Williams, Gaussian Processes, 2006, ch. 5).
Shapes without a band leave more polynomials free, which the likelihood does not charge: they are preferred unless a
band explains much more, and do better on motions that are no stationary noise (point to point, stopped by friction).

Generalised cross-validation looks at the error of positions only: it scatters more, and cannot compare shapes.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from chebid.basis import Array
from chebid.projection.fold import HALVES, symmetric_grid
from chebid.projection.modes import Frame, Modes, frame
from chebid.projection.spectrum import Spectrum

_STEPS = 48  # half-gain frequencies tried at once
_RANGE = 64  # from the highest of them to the lowest


@dataclass(frozen=True)
class Likely:
    """A penalty and how likely it is: `score` -2 log L / N (lower is better), half-gain frequency `half` Hz."""

    score: float
    spectrum: Spectrum
    half: float


@dataclass(frozen=True)
class Tiles:
    """Samples x (K, N_t) of K tiles at `rate` Hz, and the degree on each. `floor`: rounding error of a sample."""

    x: Array
    rate: float
    degree: int
    floor: float

    @property
    def cut(self) -> float:
        """Hz that the degree resolves in the middle of a tile."""
        return self.degree * self.rate / (np.pi * (self.x.shape[1] - 1))

    def best(self, shapes: list[tuple[int, float]]) -> Likely:
        """The most likely of shapes (slope, band as a share of the cut), with its half-gain frequency."""
        return min((self._likely(*shape) for shape in shapes), key=lambda found: found.score)

    def _likely(self, slope: int, share: float) -> Likely:
        # in cycles per tile: the same shapes, and their modes, on all tiles of that size
        steps, cut = self.x.shape[1] - 1, self.degree / np.pi
        shape, halves = (Spectrum(slope, share * cut), np.geomspace(max(cut / _RANGE, 0.5), cut, _STEPS))
        score = self._scores(shape, np.asarray(shape.weight(halves, steps))[:, None])
        best = int(np.argmin(score))
        return Likely(float(score[best]), shape.scaled(steps / self.rate), float(halves[best]) * self.rate / steps)

    def _scores(self, shape: Spectrum, weights: Array) -> Array:
        """-2 log L / N (P,) for weights (P, 1)."""
        count, power, logs = self.x.size, self._rest, 0.0
        for coordinates, modes in zip(self._coordinates, _modes(*self._size, shape), strict=True):
            inside = coordinates[:, modes.free :]
            z = inside @ modes.turn
            kept = weights / (modes.singular**2 + weights)  # 1 - f
            power = power + np.sum((inside - z @ modes.turn.T) ** 2) + kept @ np.sum(z**2, axis=0)
            logs = logs + len(z) * np.sum(np.log(kept), axis=1)
            count -= modes.free * len(z)
        return np.log(np.maximum(power / max(count, 1), self.floor**2)) - logs / max(count, 1)

    @property
    def _size(self) -> tuple[int, int]:
        return self.x.shape[1], self.degree

    @cached_property
    def _folded(self) -> list[Array]:
        return [part.fold.samples(self.x) for part in _frames(*self._size)]

    @cached_property
    def _coordinates(self) -> list[Array]:
        """Q^T x (K, k) of each fold."""
        return [part.coordinates(self.x) for part in _frames(*self._size)]

    @cached_property
    def _rest(self) -> float:
        """Squares of what no polynomial of that degree explains."""
        parts = zip(self._folded, self._coordinates, _frames(*self._size), strict=True)
        return float(sum(np.sum((x - c @ part.samples.T) ** 2) for x, c, part in parts))


@lru_cache(maxsize=16)
def _frames(samples: int, degree: int) -> tuple[Frame, ...]:
    tau = symmetric_grid(samples)
    return tuple(frame(tau, degree, fold) for fold in HALVES)


@lru_cache(maxsize=256)
def _modes(samples: int, degree: int, shape: Spectrum) -> tuple[Modes, ...]:
    return tuple(part.modes(shape) for part in _frames(samples, degree))
