"""Drawings without a browser's help: ticks, places in percent, paths. Sizes are left to the page."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from chebid.report.residuals import Map, Profile

Ticks = list[tuple[str, str]]  # place in percent, label


@dataclass(frozen=True)
class Axis:
    """Values from low to high, drawn from one end of a picture to the other."""

    low: float
    high: float

    @classmethod
    def over(cls, values: Sequence[float], margin: float = 0.05) -> "Axis":
        """An axis that holds all values, with some room at the ends."""
        known = [value for value in values if np.isfinite(value)] or [0.0]
        low, high = min(known), max(known)
        room = margin * (high - low) or 0.1 * abs(high) or 1.0
        return cls(low - room, high + room)

    def place(self, value: float) -> str:
        """Percent from the start."""
        return f"{100 * (value - self.low) / (self.high - self.low):.2f}%"

    def down(self, value: float) -> str:
        """Percent from the top."""
        return f"{100 * (self.high - value) / (self.high - self.low):.2f}%"

    @property
    def values(self) -> list[float]:
        found = MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3).tick_values(self.low, self.high)
        return [float(v) for v in found if self.low <= v <= self.high]

    def ticks(self, *, down: bool = False) -> Ticks:
        return [(self.down(v) if down else self.place(v), f"{v:.4g}".replace("-", "−")) for v in self.values]


def map_marks(found: Map) -> dict[str, Any]:
    """A path for each level of colour in a box of columns by rows, one of all cells, and ticks."""
    levels, seen = found.levels, np.isfinite(found.mean)
    paths = {int(level): _cells((levels == level) & seen) for level in np.unique(levels[seen]) if level}
    return {
        "columns": found.mean.shape[1],
        "rows": found.mean.shape[0],
        "seen": _cells(seen),
        "paths": sorted(paths.items()),
        "xticks": Axis(found.q[0], found.q[-1]).ticks(),
        "yticks": Axis(found.dq[0], found.dq[-1]).ticks(down=True),
    }


def _cells(which: np.ndarray) -> str:
    """A path over cells (rows, columns), neighbours in a row joined."""
    parts = []
    for row, line in enumerate(which):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
        parts += [f"M{a} {row}h{b - a}v1h{a - b}z" for a, b in edges.reshape(-1, 2)]
    return "".join(parts)


def profile_marks(found: Profile) -> dict[str, Any]:
    """Points with whiskers, the lines between them, the zero line, and ticks; all in percent."""
    x = Axis.over(found.x.tolist())
    y = Axis.over([0.0, *(found.mean - found.spread), *(found.mean + found.spread)])
    low, high = found.mean - found.spread, found.mean + found.spread
    points = [(x.place(a), y.down(b)) for a, b in zip(found.x, found.mean, strict=True)]
    return {
        "points": points,
        "whiskers": [(x.place(a), y.down(b), y.down(c)) for a, b, c in zip(found.x, low, high, strict=True)],
        "lines": list(itertools.pairwise(points)),
        "zero": y.down(0.0),
        "xticks": x.ticks(),
        "yticks": y.ticks(down=True),
    }


def ladder_marks(series: Sequence[tuple[str, bool, Sequence[float | None]]], count: int) -> dict[str, Any]:
    """Ratios over steps: for each series (name, hold-out or not, values) its points and the lines between them."""
    told = [value for _, _, values in series for value in values if value is not None]
    y = Axis(0.0, 1.08 * max([1.0, *told]))
    x = Axis(-0.4, max(count - 1, 1) + 0.4)
    names = list(dict.fromkeys(name for name, _, _ in series))
    lines = []
    for name, held, values in series:
        points = [(x.place(i), y.down(v)) for i, v in enumerate(values) if v is not None]
        pairs = list(itertools.pairwise(points))
        lines.append({"index": names.index(name) % 6, "held": held, "points": points, "lines": pairs})
    return {
        "series": lines,
        "floor": y.down(1.0),
        "xticks": [(x.place(i), str(i)) for i in range(count)],
        "yticks": y.ticks(down=True),
    }
