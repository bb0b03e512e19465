"""Figures of projected signals: what was kept, what was left out, and the derivatives."""

from collections.abc import Sequence

import numpy as np
import scipy.signal
from matplotlib.figure import Figure

from chebid.projection import Projection
from chebid.report.lines import draw_line
from chebid.report.style import COLOURS, FAINT, INK, new_figure, styled

_NAMES = ("{}", "velocity of {}", "acceleration of {}", "jerk of {}")

Projected = Sequence[tuple[int, Projection]]


@styled
def projection_figure(projected: Projected) -> Figure:
    """Per signal: spectrum of the signal's acceleration, kept and left out, with the bandwidth; residual in time."""
    figure, axes = new_figure(len(projected), 2, width=7.5, height=1.0 + 2.2 * len(projected))
    for i, (_, p) in enumerate(projected):
        left, right = axes[2 * i], axes[2 * i + 1]
        rate = (len(p.t) - 1) / float(p.t[-1] - p.t[0])
        inner = p.valid(0)
        kept, left_out = p.at(p.t, 2)[inner], p.residual[inner]
        for values, order, label, colour in ((kept, 0, "kept", COLOURS[0]), (left_out, 2, "left out", COLOURS[1])):
            f, power = scipy.signal.welch(values, rate, window="blackmanharris", nperseg=min(len(values), 4096))
            density = (2 * np.pi * f[1:]) ** order * np.sqrt(power[1:])
            left.loglog(f[1:], density, color=colour, label=label, linestyle="-", linewidth=1.2)
        left.set_ylim(bottom=left.get_ylim()[1] * 1e-6)
        left.axvline(p.plan.bandwidth, color=INK, linewidth=0.8, linestyle=":")
        left.set_ylabel(f"{p.name}: acceleration\nspectrum [s$^{{-2}}$/√Hz]")
        draw_line(right, p.t, p.residual, color=COLOURS[1], linestyle="-", linewidth=0.8)
        right.set_ylabel("left out")
        right.ticklabel_format(axis="y", scilimits=(-2, 3))
    axes[0].legend(loc="lower left")
    axes[0].set_title("dotted: bandwidth", color=FAINT)
    axes[-2].set_xlabel("frequency [Hz]")
    axes[-1].set_xlabel("time [s]")
    return figure


@styled
def derivative_figure(projected: Projected, order: int) -> Figure:
    """Per signal a row, per derivative a column; grey where the ends cannot be trusted."""
    figure, axes = new_figure(
        len(projected), order + 1, width=3.0 * (order + 1), height=1.0 + 2.0 * len(projected), sharex="row"
    )
    for i, (_, p) in enumerate(projected):
        cut = p.end_length(order)
        for k in range(order + 1):
            panel = axes[i * (order + 1) + k]
            draw_line(panel, p.t, p.at(p.t, k), color=COLOURS[0], linestyle="-", linewidth=1.0)
            panel.axvspan(p.t[0], p.t[0] + cut, color=FAINT, alpha=0.25, linewidth=0)
            panel.axvspan(p.t[-1] - cut, p.t[-1], color=FAINT, alpha=0.25, linewidth=0)
            name = _NAMES[k].format(p.name) if k < len(_NAMES) else f"derivative {k} of {p.name}"
            panel.set_title(name)
    for panel in axes[-(order + 1) :]:
        panel.set_xlabel("time [s]")
    return figure
