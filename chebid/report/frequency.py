"""Figures of frequency responses: one sweep of `chebid freqresp`, and figures 1 to 5 of the paper.

The tables that the paper's figures are drawn from are those written beside them as CSV; their columns are named below.
"""

import itertools
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axes._secondary_axes import SecondaryAxis
from matplotlib.axis import Axis
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import LogLocator, NullLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from chebid.basis import Array
from chebid.report.style import COLOUR_MAP, COLOURS, INK, StyledFigure, new_figure, styled
from chebid.response import Sweep, decibel

_FLOOR = -60.0  # dB: what is smaller is drawn there
_LEVELS = (-60, -40, -30, -20, -15, -10, -6, -3, -1, -0.1, 0.5)  # dB, of maps
_NORM = BoundaryNorm(_LEVELS, 256)
_LAW: Any = {"color": COLOURS[1], "ls": "--", "lw": 2.0, "label": "f T = n / π"}


@styled
def sweep_figure(sweep: Sweep) -> Figure:
    """Gain and phase of one operator against frequency, with its cut-off."""
    figure, (gain, phase) = new_figure(2, sharex=True, height=4.8, height_ratios=(2, 1))
    r = sweep.response
    marker = "." if len(r.frequency) < 25 else ""
    gain.plot(r.frequency, np.maximum(r.gain_db, _FLOOR), marker=marker, label="inner 90 % of the record")
    gain.plot(r.frequency, np.maximum(r.gain_db_whole, _FLOOR), marker=marker, label="whole record")
    passed = r.gain_db > _FLOOR
    phase.plot(r.frequency[passed], r.phase_deg[passed], marker=marker)
    if sweep.cutoff:
        gain.plot([sweep.cutoff], [-3.01], "o", color=INK)
        gain.annotate(f"−3 dB at {sweep.cutoff:.4g} Hz", (sweep.cutoff, -3.01), (6, 4), textcoords="offset points")
    gain.set(ylabel="gain (dB)", title=sweep.sentence().split("\n")[0].rstrip(".").replace(" (", "\n("))
    phase.set(xlabel="frequency (Hz)", ylabel="phase (deg)")
    low, high = phase.get_ylim()
    phase.set_ylim(min(low, -1.0), max(high, 1.0))  # 1e-13 deg is rounding, and no phase
    gain.legend(loc="lower left")
    return figure


@styled
def attenuation_figure(table: pd.DataFrame, points_per_period: float) -> Figure:
    """Figure 1: 20 log10 A(n, f) as a surface and as a map, with the law f T = n / pi.

    `table`: cycles (f T), degree, gain_db (NaN where the fit is refused), closed_form_db, on a full grid.
    """
    cycles, degree, sampled = _grid(table, "gain_db")
    gain = np.where(np.isfinite(sampled), sampled, _grid(table, "closed_form_db")[2])
    figure = StyledFigure(figsize=(9.0, 4.0), layout=ConstrainedLayoutEngine(wspace=0.06))
    surface = figure.add_subplot(1, 2, 1, projection="3d")
    assert isinstance(surface, Axes3D)
    _draw_surface(surface, cycles, degree, gain)
    flat = figure.add_subplot(1, 2, 2)
    _draw_map(figure, flat, cycles, degree, gain)
    law = np.array([cycles[0], cycles[-1]])
    flat.plot(law, np.pi * law, **_LAW)
    flat.plot(cycles, 4 * np.sqrt(points_per_period * cycles + 1), ":", color=INK, label="n = 4 √N: no fit above")
    flat.set(xlabel="cycles in the record, f T", ylabel="degree n", ylim=(degree[0], degree[-1]))
    flat.legend(loc="upper left")
    return figure


def _draw_surface(axes: Axes3D, cycles: Array, degree: Array, gain: Array) -> None:
    mesh = np.meshgrid(cycles, degree)
    high = np.clip(gain, _LEVELS[0], 0)
    axes.plot_surface(
        *mesh, high, cmap=COLOUR_MAP, norm=_NORM, rcount=48, ccount=60, lw=0, antialiased=False, rasterized=True
    )
    law = cycles[np.pi * cycles <= degree[-1]]
    axes.plot(law, np.pi * law, np.full(len(law), 1.0), zorder=10, **_LAW)
    axes.set(xlabel="cycles, f T", ylabel="degree n", zlim=(_LEVELS[0], 3), zticks=(-60, -40, -20, 0))
    axes.locator_params(axis="x", nbins=4)
    axes.locator_params(axis="y", nbins=4)
    axes.set_title("20 log A(n, f), dB", y=1.0)
    axes.view_init(elev=32, azim=-50)
    axes.set_box_aspect(None, zoom=0.98)


def _grid(table: pd.DataFrame, value: str) -> tuple[Array, Array, Array]:
    """First and second column as axes, and the values (second, first)."""
    first, second = table.columns[:2]
    wide = table.pivot(index=second, columns=first, values=value)
    return wide.columns.to_numpy(float), wide.index.to_numpy(float), wide.to_numpy(float)


def _draw_map(figure: Figure, axes: Axes, x: Array, degree: Array, gain: Array) -> None:
    shown = np.clip(gain, _LEVELS[0] + 1e-6, 0)
    image = axes.pcolormesh(x, degree, shown, norm=_NORM, shading="nearest", rasterized=True)
    axes.contour(x, degree, gain, levels=[-3.01], colors=INK, linestyles="-", linewidths=1.2)
    axes.plot([], [], "-", color=INK, lw=1.2, label="−3 dB")
    bar = figure.colorbar(image, ax=axes, label="attenuation (dB)")
    bar.ax.set_yticks(_LEVELS[:-1], [f"{level:g}".replace("-", "−") for level in _LEVELS[:-1]])
    axes.grid(False)


@styled
def derivative_figure(table: pd.DataFrame, order: int, rate: float, duration: float) -> Figure:
    """Figures 2 and 4: the exact derivative of a sine and the rebuilt ones, relative to the sine itself.

    `table`: degree, frequency (Hz), exact_db, rebuilt_db; both in dB of amplitude, (rad/s)^order.
    """
    figure, (axes,) = new_figure(width=6.5, height=4.2)
    exact = table.drop_duplicates("frequency")
    axes.semilogx(exact["frequency"], exact["exact_db"], "-", color=INK, lw=1.0, label="exact", zorder=9)
    lowest = float(exact["exact_db"].min())
    for colour, (degree, part) in zip(itertools.cycle(COLOURS), table.groupby("degree"), strict=False):
        shown = part["rebuilt_db"].where(part["rebuilt_db"] > lowest)
        axes.semilogx(part["frequency"], shown, "-", color=colour, lw=2.0, label=f"rebuilt, n = {degree}")
    cut = table["degree"].unique() / (np.pi * duration)
    axes.plot(cut, order * decibel(2 * np.pi * cut), "o", ms=5, mfc="white", mec=INK, label="f = n / (π T)", zorder=10)
    unit = "rad/s" if order == 1 else "(rad/s)²"
    axes.set(xlabel="frequency f (Hz)", ylabel=f"{_ORDINAL[order]} derivative over signal, dB re 1 {unit}")
    axes.set(xlim=(table["frequency"].min(), table["frequency"].max()), ylim=(lowest, None))
    _round_ticks(axes.xaxis)
    _round_ticks(_normalised_axis(axes, rate).xaxis)
    axes.legend(loc="upper left", title=f"fs = {rate:g} Hz, T = {duration:g} s", alignment="left")
    return figure


@styled
def distortion_figure(table: pd.DataFrame, order: int, rate: float, duration: float) -> Figure:
    """Figures 3 and 5: amplitude of the rebuilt derivative over that of the exact one.

    `table`: frequency (Hz), degree, ratio, on a full grid.
    """
    frequency, degree, ratio = _grid(table, "ratio")
    figure, (axes,) = new_figure(width=6.5, height=4.2)
    image = axes.pcolormesh(frequency, degree, ratio.clip(0, 1), vmin=0, vmax=1, shading="nearest", rasterized=True)
    lines = axes.contour(frequency, degree, ratio, levels=[0.1, 0.5], colors="white", linewidths=1.0)
    axes.clabel(lines, fmt="%g", fontsize=9)
    axes.plot(degree / (np.pi * duration), degree, **_LAW)
    axes.set(xlabel="frequency f (Hz)", ylabel="degree n", xlim=(frequency[0], frequency[-1]))
    axes.set(ylim=(degree[0], degree[-1]))
    axes.grid(False)
    figure.colorbar(image, ax=axes, label=f"rebuilt over exact {_ORDINAL[order]} derivative")
    _normalised_axis(axes, rate)
    axes.legend(loc="upper left", title=f"fs = {rate:g} Hz, T = {duration:g} s", alignment="left")
    return figure


_ORDINAL = {1: "first", 2: "second"}


def _normalised_axis(axes: Axes, rate: float) -> SecondaryAxis:
    def normalise(f: Any) -> Any:
        return f / rate

    def scale(f: Any) -> Any:
        return f * rate

    top = axes.secondary_xaxis("top", functions=(normalise, scale))
    top.set_xlabel("normalised frequency f / fs (eq. 15)")
    return top


def _round_ticks(axis: Axis) -> None:
    """0.1, 0.2, 0.5, 1, 2 ... on a logarithmic axis, written out."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())
