"""The error of a model within the band in which it is judged: over (q, dq) as a map, over one variable as a profile."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.critique import Diagnosis
from chebid.critique.variables import variables

_FINE, _COARSE = (24, 14), (16, 10)  # cells of a map
_MANY = 5000  # samples, for a fine map
_CLEAR = 4.0  # deviations of the mean of a cell that are strong in colour: noise stays pale
_FEWEST = 4  # samples in a cell
_BINS = 14  # of a profile
_SHARE = 0.005  # of the samples, in a bin
_LEVELS = 8  # of colour, to each side
_TAIL = 0.5  # percent of the samples at each end that may lie beyond a map


@dataclass(frozen=True)
class Map:
    """Mean error (rows, columns) of a joint over its q and dq, NaN where it was not; row 0 at the top.

    `scale`: error of the strongest colour; `levels` (rows, columns): -8 to 8.
    """

    joint: int
    q: Array
    dq: Array
    mean: Array
    scale: float

    @property
    def levels(self) -> NDArray[np.int64]:
        share = np.nan_to_num(self.mean) / self.scale
        return np.clip(np.rint(_LEVELS * share), -_LEVELS, _LEVELS).astype(int)


@dataclass(frozen=True)
class Profile:
    """Mean error in bins of a variable: centres, means, and twice their deviation, N.m or N."""

    joint: int
    variable: str
    x: Array
    mean: Array
    spread: Array


class Errors:
    """Error (N, J) of every track of a diagnosis within the band, and which samples count."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis = diagnosis
        self.motions = diagnosis.evidence.motions
        self.used = diagnosis.evidence.ground.used
        dynamics = diagnosis.evidence.dynamics
        self.torques = [dynamics.torque(motion, diagnosis.theta) for motion in self.motions]
        self.values = diagnosis.evidence.error(diagnosis.theta)

    def over(self, values: list[Array], joint: int) -> Array:
        """Values (N,) of every track where the joint is used, joined."""
        return np.concatenate([x[used[:, joint]] for x, used in zip(values, self.used, strict=True)])

    def of(self, joint: int) -> Array:
        return self.over([value[:, joint] for value in self.values], joint)

    def map(self, joint: int) -> Map:
        """The map of a joint; its strongest colour is beyond what chance would give."""
        q = self.over([m.q[:, joint] for m in self.motions], joint)
        dq = self.over([m.dq[:, joint] for m in self.motions], joint)
        cells = _FINE if len(q) >= _MANY else _COARSE
        edges = [_even_edges(x, count) for x, count in zip((q, dq), cells, strict=True)]
        error = self.of(joint)
        count, total, squares = (np.histogram2d(q, dq, edges, weights=w)[0] for w in (None, error, error**2))
        seen = count >= _FEWEST
        mean = np.where(seen, total / np.maximum(count, 1), np.nan)
        scale = _strongest(mean[seen], squares[seen], count[seen]) if seen.any() else 1.0
        return Map(joint, edges[0], edges[1], mean.T[::-1], scale)

    def profile(self, joint: int, name: str) -> Profile | None:
        """The error over a variable of `critique.variables`; None for one that is not among these."""
        known = variables(joint, self.diagnosis.evidence.dynamics.joints)
        variable = next((one for one in known if one.name == name), None)
        if variable is None:
            return None
        pairs = list(zip(self.motions, self.torques, strict=True))
        x = self.over([variable.x(motion, tau) for motion, tau in pairs], joint)
        error = self.of(joint)
        if variable.times is not None:
            error = error * np.sign(self.over([variable.times(motion, tau) for motion, tau in pairs], joint))
        if name == "distance since reversal":
            x = np.exp(x)
        edges = _even_edges(x, _BINS)
        bins = [(x >= low) & (x <= high) for low, high in itertools.pairwise(edges)]
        bins = [inside for inside in bins if inside.sum() >= max(_FEWEST, _SHARE * len(x))]
        if len(bins) < 2:
            return None
        independent = 2 * self.diagnosis.evidence.ground.band / self.diagnosis.evidence.ground.tracks[0].rate
        counts = np.array([max(1.0, float(inside.sum()) * min(1.0, independent)) for inside in bins])
        spread = 2 * np.array([float(error[inside].std()) for inside in bins]) / np.sqrt(counts)
        centre = np.array([float(np.median(x[inside])) for inside in bins])
        return Profile(joint, name, centre, np.array([float(error[inside].mean()) for inside in bins]), spread)


def _strongest(mean: Array, squares: Array, count: Array) -> float:
    """The error (of cells with these means, sums of squares and counts) that gets the strongest colour."""
    within = max(float(np.sum(squares - count * mean**2) / np.sum(count)), 0.0)
    chance = _CLEAR * np.sqrt(within / np.percentile(count, 5))
    return max(float(np.percentile(np.abs(mean), 98)), float(chance), float(np.finfo(float).tiny))


def _even_edges(x: Array, count: int) -> Array:
    """Edges (count + 1,) of equal cells over all but the outermost values (N,)."""
    low, high = np.percentile(x, [_TAIL, 100 - _TAIL])
    room = 0.0 if high > low else 1e-3 * abs(low) + 1e-9
    return np.linspace(float(low) - room, float(high) + room, count + 1)
