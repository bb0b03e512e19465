"""One look for all figures, legible to the colour-blind and in print, and the same bytes from the same numbers.

    @styled
    def some_figure(...) -> Figure:
        fig, axes = new_figure(rows=2)
        ...
        return fig

No pyplot: figures need no screen, are freed like any object, and the user's matplotlib settings are left alone.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Okabe and Ito, "Color Universal Design" (2008), without its yellow, which is too light for lines
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
INK, FAINT = "#000000", "#767676"
MEASURED, PREDICTED = COLOURS[0], COLOURS[1]
COLOUR_MAP = "viridis"  # even in lightness: reads without colour vision, and in grey
_DASHES = ("-", (0, (6, 2)), (0, (4, 1.5, 1, 1.5)), (0, (2, 1.2)), (0, (8, 2, 1, 2, 1, 2)), (0, (1, 1)))

STYLE: Any = {
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.grid": True,
    "axes.labelsize": 10,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": cycler(color=COLOURS, linestyle=_DASHES),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "figure.dpi": 100,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same on every machine
    "font.size": 10,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "image.cmap": COLOUR_MAP,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "lines.linewidth": 1.6,
    "mathtext.fontset": "dejavusans",
    "pdf.fonttype": 42,
    "savefig.dpi": 160,
    "svg.fonttype": "path",
    "svg.hashsalt": "chebid",  # ids of clip paths and markers do not change from run to run
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
}
_UNDATED: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Producer": None, "Creator": None},
}

P = ParamSpec("P")


class StyledFigure(Figure):
    """A figure that is saved in the house style, undated, whatever the settings at that moment."""

    def savefig(self, fname: Any, **kwargs: Any) -> None:
        suffix = Path(fname).suffix if isinstance(fname, str | Path) else f".{kwargs.get('format', '')}"
        kwargs.setdefault("metadata", _UNDATED.get(suffix.lower()))
        with matplotlib.rc_context(STYLE):
            super().savefig(fname, **kwargs)


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorator of a function that draws a figure: everything in it has the house style."""

    @functools.wraps(draw)
    def inner(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context(STYLE):
            return draw(*args, **kwargs)

    return inner


def new_figure(
    rows: int = 1, columns: int = 1, *, width: float = 6.5, height: float = 4.0, **kwargs: Any
) -> tuple[StyledFigure, list[Axes]]:
    """A figure of `width` by `height` inches and its axes, row by row; further options are those of `subplots`."""
    figure = StyledFigure(figsize=(width, height))
    axes = figure.subplots(rows, columns, squeeze=False, **kwargs)
    return figure, list(np.ravel(axes))
