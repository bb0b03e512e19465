"""Measured and predicted torque along the motion, with the residual beneath."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chebid.basis import Array
from chebid.effects import Units
from chebid.equations import moving
from chebid.estimators import Problem
from chebid.motion import Mask, Track
from chebid.report.lines import draw_line
from chebid.report.style import COLOURS, FAINT, INK, MEASURED, new_figure, styled
from chebid.report.tables import short_names
from chebid.results import Comparison, Comparisons

_NARROWEST = 2000  # of the width of a record: thinner greys would not be seen
_TOLD = 3  # models whose errors are told in figures
_GAP = np.nan  # between records, so that lines do not join them


def torque_figure(problem: Problem, thetas: Mapping[str, Array]) -> Figure:
    """Every joint of a problem: measured torque and that of each named theta (P,)."""
    torques = {
        name: [problem.dynamics.torque(track.motion, theta) for track in problem.tracks]
        for name, theta in thetas.items()
    }
    return prediction_figure(problem.tracks, torques, problem.dynamics.robot.rotary, _used(problem))


@styled
def comparison_figure(results: Comparisons) -> Figure:
    """Every model on every log: a column of panels for each log."""
    logs = list(dict.fromkeys(entry.log for entry in results.entries))
    names = short_names(dict.fromkeys(entry.model for entry in results.entries))
    first = results.entries[0].problem
    figure, columns = _panels(len(first.dynamics.joints), len(logs))
    for log, axes in zip(logs, columns, strict=True):
        mine = [entry for entry in results.entries if entry.log == log]
        torques = {
            names[entry.model]: [
                entry.problem.dynamics.torque(track.motion, entry.theta) for track in entry.problem.tracks
            ]
            for entry in mine
        }
        problem = mine[0].problem
        _draw(axes, problem.tracks, torques, first.dynamics.robot.rotary, _used(problem))
        _tell_errors(axes[1::2], mine)
        if len(logs) > 1:
            axes[0].set_title(Path(log).name, pad=20)
    _finish(figure, columns)
    return figure


@styled
def prediction_figure(
    tracks: Sequence[Track],
    torques: Mapping[str, Sequence[Array]],
    rotary: Sequence[bool] | None = None,
    used: Sequence[Mask] | None = None,
) -> Figure:
    """Per joint: torques (N, J) of each model against the measured ones, and the residuals where there are such.

    `used`: the samples (N, J) that are used on each joint; None: all but the ends.
    """
    figure, columns = _panels(tracks[0].motion.q.shape[1], 1, _measured(tracks))
    _draw(columns[0], tracks, torques, rotary, used)
    _finish(figure, columns)
    return figure


def _tell_errors(panels: Sequence[Axes], entries: Sequence[Comparison]) -> None:
    """Rms of the residual of every model, in its colour, in the panel of each joint; of a few models."""
    for i, entry in enumerate(entries[:_TOLD]):
        place = 1.0 - 0.26 * (min(len(entries), _TOLD) - 1 - i)
        for panel, r in zip(panels, entry.residual.values(), strict=True):
            panel.annotate(
                f"rms {r.rms:.3g} in band",
                (place, 1.0),
                xycoords="axes fraction",
                ha="right",
                va="bottom",
                fontsize=8,
                color=_colour(i),
            )


def _colour(model: int) -> str:
    return COLOURS[1 + model % (len(COLOURS) - 1)]


def _used(problem: Problem) -> list[Mask]:
    return [moving(track, problem.gate) for track in problem.tracks]


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
    axes: Sequence[Axes],
    tracks: Sequence[Track],
    torques: Mapping[str, Sequence[Array]],
    rotary: Sequence[bool] | None,
    used: Sequence[Mask] | None,
) -> None:
    kept = used or [np.repeat(track.valid[:, None], track.motion.q.shape[1], axis=1) for track in tracks]
    t = _join([track.motion.t for track in tracks])
    measured = _join([track.torque for track in tracks]) if _measured(tracks) else None
    for j, name in enumerate(tracks[0].log.names):
        panels = axes[2 * j : 2 * j + 2] if measured is not None else axes[j : j + 1]
        if measured is not None:
            draw_line(panels[0], t, measured[:, j], label="measured", color=MEASURED, linewidth=2.4, alpha=0.5)
        for i, (model, parts) in enumerate(torques.items()):
            style: Any = {"color": _colour(i), "linestyle": "-" if i == 0 else (0, (5, 2))}
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
            for track, mask in zip(tracks, kept, strict=True):
                first = panel is axes[0] and track is tracks[0]
                _shade(panel, track.motion.t, ~mask[:, j], "not used" if first else None)


def _shade(panel: Axes, t: Array, left_out: Mask, label: str | None) -> None:
    """Grey where samples (N,) are left out, ends and slow motion: what stands out there is no fault of the model."""
    edges = np.flatnonzero(np.diff(left_out, prepend=False, append=False))
    begin, end = t[edges[::2]], t[np.minimum(edges[1::2], len(t) - 1)]
    seen = end - begin > (t[-1] - t[0]) / _NARROWEST
    spans = list(zip(begin[seen], (end - begin)[seen], strict=True))
    panel.broken_barh(
        spans, (0, 1), transform=panel.get_xaxis_transform(), color=FAINT, alpha=0.25, linewidth=0, label=label
    )


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
