"""Pictures of the hidden-effect study: how often the effect is named first, and what is named in its place."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from chebid.basis import Array
from chebid.report.style import COLOURS, FAINT, INK, StyledFigure, styled

_SHARES = LinearSegmentedColormap.from_list("share", ["#FFFFFF", COLOURS[0]])
_LAST = ("nothing", "unknown", "other joint")  # at the end of the axes
_ABSENT = "#F0F0F0"


@styled
def accuracy_figure(table: pd.DataFrame) -> Figure:
    """`table`: effect, strength, right, logs; one row per effect and strength."""
    right, logs = (table.pivot(index="effect", columns="strength", values=name) for name in ("right", "logs"))
    both = [pd.concat([one, one.sum(axis=1).rename("all")], axis=1) for one in (right, logs)]
    order = (both[0]["all"] / both[1]["all"]).sort_values(kind="stable", ascending=False).index
    hits, tried = (
        pd.concat([one.loc[order], one.sum().rename("every effect").to_frame().T]).to_numpy(float) for one in both
    )
    figure = StyledFigure(figsize=(2.6 + 0.95 * hits.shape[1], 1.2 + 0.3 * len(hits)))
    axis = figure.add_subplot()
    words = [
        [f"{h:.0f}/{n:.0f}" if n > 0 else "" for h, n in zip(*rows, strict=True)]
        for rows in zip(hits, tried, strict=True)
    ]
    with np.errstate(invalid="ignore"):
        _cells(axis, hits / tried, words)
    axis.set_xticks(range(hits.shape[1]), [f"{size:g}" for size in right.columns] + ["all"])
    axis.set_yticks(range(len(hits)), [*order, "every effect"])
    axis.axhline(len(hits) - 1.5, color=INK, lw=1.2)
    axis.axvline(hits.shape[1] - 1.5, color=INK, lw=1.2)
    axis.set_xlabel("strength: unexplained torque / torque noise")
    axis.set_title("hidden effect named first, on its joint")
    return figure


@styled
def confusion_figure(table: pd.DataFrame) -> Figure:
    """`table`: effect (hidden), named, logs; shading is the share of the row, a number the logs."""
    hidden, named = set(table.effect), set(table.named)
    rows = _ordered(hidden)
    columns = [*_ordered(hidden - set(_LAST)), *_ordered(named - hidden - set(_LAST)), *_LAST[:2]]
    columns += [name for name in _LAST[2:] if name in named]
    counts = table.pivot(index="effect", columns="named", values="logs").reindex(index=rows, columns=columns)
    values = counts.fillna(0).to_numpy(float)
    figure = StyledFigure(figsize=(2.6 + 0.34 * len(columns), 2.4 + 0.3 * len(rows)))
    axis = figure.add_subplot()
    _cells(axis, values / values.sum(axis=1, keepdims=True), [[f"{n:.0f}" if n else "" for n in row] for row in values])
    for i, name in enumerate(rows):
        axis.add_patch(_frame(columns.index(name), i))
    axis.set_xticks(range(len(columns)), columns, rotation=55, ha="right", rotation_mode="anchor")
    axis.set_yticks(range(len(rows)), rows)
    axis.set_xlabel("named first")
    axis.set_ylabel("hidden")
    axis.set_title("what was named (number of logs; framed: right)")
    return figure


def _ordered(names: set[str]) -> list[str]:
    return [*sorted(names - set(_LAST)), *(name for name in _LAST if name in names)]


def _frame(x: int, y: int) -> Rectangle:
    return Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, edgecolor=FAINT, linewidth=1.0)


def _cells(axis: Axes, shares: Array, words: list[list[str]]) -> None:
    """A table of shares 0 to 1, light to dark, with words in it; cells without a share are grey."""
    axis.set_facecolor(_ABSENT)
    axis.imshow(np.ma.masked_invalid(shares), cmap=_SHARES, vmin=0, vmax=1, aspect="auto")
    for i, row in enumerate(words):
        for k, word in enumerate(row):
            colour = "#FFFFFF" if shares[i, k] > 0.6 else INK
            axis.text(k, i, word, ha="center", va="center", fontsize=9, color=colour)
    axis.grid(False)
    axis.tick_params(length=0)
    for side in axis.spines.values():
        side.set_visible(False)
