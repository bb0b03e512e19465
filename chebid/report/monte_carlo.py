"""The Monte-Carlo page: rmse and coverage of every method, parameter by parameter."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chebid.report.style import COLOURS, FAINT, INK, new_figure, styled

NOMINAL = 0.95
_MARKERS = ("o", "s", "^", "v", "D", "P")
_SPREAD = 0.7  # of the distance between parameters, taken by the methods


@styled
def monte_carlo_figure(table: pd.DataFrame) -> Figure:
    """`table` columns: record, method, parameter, bias, rmse (% of the truth), coverage, coverage_eq26, seeds."""
    studies = list(dict.fromkeys(table.record))
    figure, axes = new_figure(3, len(studies), width=2.0 + 4.5 * len(studies), height=8.5, sharex="col", sharey="row")
    for k, study in enumerate(studies):
        mine = table[table.record == study]
        column = axes[k :: len(studies)]
        column[0].set_title(f"{study}, {mine.seeds.max()} noise seeds", pad=24 if k == 0 else 6)
        for upper, what in zip(column, ("rmse", "coverage", "coverage_eq26"), strict=True):
            _points(upper, mine, what)
        column[0].set_yscale("log")
        for lower in column[1:]:
            _band(lower, int(mine.seeds.max()))
        names = list(dict.fromkeys(mine.parameter))
        column[-1].set_xticks(range(len(names)), names)
    axes[0].set_ylabel("rmse [% of the true value]")
    axes[len(studies)].set_ylabel("coverage of the 95 % interval,\nhonest deviation")
    axes[2 * len(studies)].set_ylabel("coverage of the 95 % interval,\neq. 26")
    axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=6, borderaxespad=0.2, handletextpad=0.2)
    return figure


def _points(axes: Axes, table: pd.DataFrame, what: str) -> None:
    methods, names = list(dict.fromkeys(table.method)), list(dict.fromkeys(table.parameter))
    for i, method in enumerate(methods):
        mine = table[table.method == method].set_index("parameter")[what].reindex(names)
        shift = _SPREAD * (i / max(len(methods) - 1, 1) - 0.5)
        axes.plot(
            np.arange(len(names)) + shift,
            mine.to_numpy(float),
            color=COLOURS[i % len(COLOURS)],
            marker=_MARKERS[i % len(_MARKERS)],
            linestyle="none",
            markersize=4.5,
            label=method,
        )


def _band(axes: Axes, seeds: int) -> None:
    """The nominal coverage, and what chance does to it in 95 of 100 cases."""
    chance = 1.96 * np.sqrt(NOMINAL * (1 - NOMINAL) / seeds)
    axes.axhline(NOMINAL, color=INK, linewidth=0.8)
    axes.axhspan(NOMINAL - chance, min(NOMINAL + chance, 1.0), color=FAINT, alpha=0.2, linewidth=0)
