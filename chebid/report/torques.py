"""Measured and predicted torque along the motion, with the residual beneath."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chebid.basis import Array
from chebid.effects import Units
from chebid.estimators import Problem
from chebid.motion import Track
from chebid.report.lines import draw_line
from chebid.report.style import COLOURS, FAINT, INK, MEASURED, new_figure, styled
from chebid.results import Comparisons

_GAP = np.nan  # between records, so that lines do not join them


def torque_figure(problem: Problem, thetas: Mapping[str, Array]) -> Figure:
    """Every joint of a problem: measured torque and that of each named theta (P,)."""
    torques = {
        name: [problem.dynamics.torque(track.motion, theta) for track in problem.tracks]
        for name, theta in thetas.items()
    }
    return prediction_figure(problem.tracks, torques, problem.dynamics.robot.rotary)


@styled
def comparison_figure(results: Comparisons) -> Figure:
    """Every model on every log: a column of panels for each log."""
    logs = list(dict.fromkeys(entry.log for entry in results.entries))
    first = results.entries[0].problem
    figure, columns = _panels(len(first.dynamics.joints), len(logs))
    for log, axes in zip(logs, columns, strict=True):
        mine = [entry for entry in results.entries if entry.log == log]
        torques = {
            Path(entry.model).name: [
                entry.problem.dynamics.torque(track.motion, entry.theta) for track in entry.problem.tracks
            ]
            for entry in mine
        }
        _draw(axes, mine[0].problem.tracks, torques, first.dynamics.robot.rotary)
        if len(logs) > 1:
            axes[0].set_title(Path(log).name, pad=20)
    _finish(figure, columns)
    return figure


@styled
def prediction_figure(
    tracks: Sequence[Track], torques: Mapping[str, Sequence[Array]], rotary: Sequence[bool] | None = None
) -> Figure:
    """Per joint: torques (N, J) of each model against the measured ones, and the residuals where there are such."""
    figure, columns = _panels(tracks[0].motion.q.shape[1], 1, _measured(tracks))
    _draw(columns[0], tracks, torques, rotary)
    _finish(figure, columns)
    return figure


def _panels(joints: int, logs: int, measured: bool = True) -> tuple[Figure, list[list[Axes]]]:
    """A column of panels for each log: per joint one of torques, and one of residuals where torque was measured."""
    ratios = [2, 1] if measured else [2]
    figure, axes = new_figure(
        len(ratios) * joints,
        logs,
        width=2.0 + 5.0 * logs,
        height=1.0 + 2.6 * joints * sum(ratios) / 3,
        sharex="col",
        sharey="row",
        height_ratios=ratios * joints,
    )
    return figure, [axes[i::logs] for i in range(logs)]


def _draw(
    axes: Sequence[Axes], tracks: Sequence[Track], torques: Mapping[str, Sequence[Array]], rotary: Sequence[bool] | None
) -> None:
    t = _join([track.motion.t for track in tracks])
    measured = _join([track.torque for track in tracks]) if _measured(tracks) else None
    for j, name in enumerate(tracks[0].log.names):
        panels = axes[2 * j : 2 * j + 2] if measured is not None else axes[j : j + 1]
        if measured is not None:
            draw_line(panels[0], t, measured[:, j], label="measured", color=MEASURED, linewidth=2.4, alpha=0.5)
        for i, (model, parts) in enumerate(torques.items()):
            style: Any = {"color": COLOURS[1 + i % (len(COLOURS) - 1)], "linestyle": "-" if i == 0 else (0, (5, 2))}
            predicted = _join(parts)[:, j]
            draw_line(panels[0], t, predicted, label=model, linewidth=1.0, **style)
            if measured is not None:
                draw_line(panels[1], t, measured[:, j] - predicted, linewidth=1.0, **style)
        unit = Units(rotary[j] if rotary else True).torque
        what = "force" if unit == "N" else "torque"
        panels[0].set_ylabel(f"{name}: {what} [{unit.replace('.', '·')}]")
        if measured is not None:
            panels[1].set_ylabel(f"residual [{unit.replace('.', '·')}]")
            panels[1].axhline(0, color=INK, linewidth=0.6)
        for panel in panels:
            _shade_ends(panel, tracks)


def _shade_ends(panel: Axes, tracks: Sequence[Track]) -> None:
    """Grey where the ends of a record cannot be trusted: what stands out there is no fault of the model."""
    for track in tracks:
        t, inside = track.motion.t, np.flatnonzero(track.valid)
        if len(inside):
            for begin, end in ((t[0], t[inside[0]]), (t[inside[-1]], t[-1])):
                panel.axvspan(begin, end, color=FAINT, alpha=0.25, linewidth=0)


def _measured(tracks: Sequence[Track]) -> bool:
    return all(track.tau is not None for track in tracks)


def _finish(figure: Figure, columns: Sequence[Sequence[Axes]]) -> None:
    columns[0][0].legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=4, borderaxespad=0.2)
    for axes in columns:
        axes[-1].set_xlabel("time [s]")
        if axes is not columns[0]:
            for panel in axes:
                panel.set_ylabel("")
    figure.align_ylabels()


def _join(parts: Sequence[Array]) -> Array:
    """Records one after the other, a gap between them."""
    gap = np.full((1, *parts[0].shape[1:]), _GAP)
    return np.concatenate([piece for part in parts for piece in (part, gap)][:-1])
