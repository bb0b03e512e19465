"""The error of a model within the band in which it is judged: over (q, dq) as a map, over one variable as a profile."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.critique import Diagnosis
from chebid.critique.variables import variables

_COLUMNS, _ROWS = 24, 14  # cells of a map
_FEWEST = 3  # samples in a cell
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
        self.values = [self._banded(i) for i in range(len(self.motions))]

    def _banded(self, i: int) -> Array:
        """The part of the error of a track that lies within the band, joint by joint."""
        ground = self.diagnosis.evidence.ground
        raw = ground.tracks[i].torque - self.torques[i]
        out = np.zeros_like(raw)
        for f in ground.functions[i]:
            rows = f.rows(raw[f.piece][:, :, None])
            for j, mix in enumerate(f.mix):
                out[f.piece, j] = f.basis @ (mix.T @ rows[j][:, 0])
        return out

    def over(self, values: list[Array], joint: int) -> Array:
        """Values (N,) of every track where the joint is used, joined."""
        return np.concatenate([x[used[:, joint]] for x, used in zip(values, self.used, strict=True)])

    def of(self, joint: int) -> Array:
        return self.over([value[:, joint] for value in self.values], joint)

    def map(self, joint: int, floor: float | None) -> Map:
        """The map of a joint; colours begin to be strong at the noise floor, so that noise stays pale."""
        q = self.over([m.q[:, joint] for m in self.motions], joint)
        dq = self.over([m.dq[:, joint] for m in self.motions], joint)
        edges = [_even_edges(x, count) for x, count in ((q, _COLUMNS), (dq, _ROWS))]
        count, _, _ = np.histogram2d(q, dq, edges)
        total, _, _ = np.histogram2d(q, dq, edges, weights=self.of(joint))
        seen = count >= _FEWEST
        mean = np.where(seen, total / np.maximum(count, 1), np.nan)
        strong = float(np.percentile(np.abs(mean[seen]), 98)) if seen.any() else 0.0
        scale = max(strong, 2 * (floor or 0.0), np.finfo(float).tiny)
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


def _even_edges(x: Array, count: int) -> Array:
    """Edges (count + 1,) of equal cells over all but the outermost values (N,)."""
    low, high = np.percentile(x, [_TAIL, 100 - _TAIL])
    return np.linspace(float(low), float(high), count + 1)
