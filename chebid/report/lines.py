"""Long lines: as many points as can be seen, and every peak among them."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chebid.basis import Array

_MOST = 2000  # intervals of a line, of each of which the least and the largest value are drawn


def draw_line(axes: Axes, t: Array, y: Array, **style: Any) -> None:
    """Draw y (N,) over t (N,); a NaN is a gap."""
    if len(t) <= 2 * _MOST:
        axes.plot(t, y, **style)
        return
    axes.plot(*envelope(t, y, _MOST), **style)


def envelope(t: Array, y: Array, most: int) -> tuple[Array, Array]:
    """At most 2 `most` points of a line: of equal runs of samples the least and the largest, in their order."""
    length = -(-len(t) // most)
    runs = np.concatenate([y, np.full(-len(y) % length, y[-1])]).reshape(-1, length)
    gaps = np.isnan(runs)
    low, high = np.where(gaps, np.inf, runs).argmin(axis=1), np.where(gaps, -np.inf, runs).argmax(axis=1)
    index = np.sort(np.column_stack([low, high]), axis=1) + length * np.arange(len(runs))[:, None]
    index = np.minimum(index, len(t) - 1)
    values = y[index]
    values[gaps.any(axis=1), 1] = np.nan
    return t[index].ravel(), values.ravel()
