"""Pictures of a diagnosis, of a ladder of errors, and both in a strip: compare, where, candidates, error falling."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from chebid.basis import Array
from chebid.critique import Diagnosis, Refinement, label
from chebid.effects import Units
from chebid.report.lines import draw_line
from chebid.report.residuals import Errors, Profile
from chebid.report.style import COLOURS, FAINT, INK, MEASURED, PREDICTED, StyledFigure, new_figure, styled

_BARS = 6  # candidates, cells and dependences drawn
_MAPS = 3  # in a row
_ROW = 3.4  # inches
_WINDOW = 10.0  # s of torque in a strip
_UNVISITED = "#E6E8EB"
_DIVERGING = LinearSegmentedColormap.from_list("residual", [COLOURS[0], "#FFFFFF", COLOURS[1]])


@styled
def ladder_figure(refinement: Refinement) -> Figure:
    """Error over noise floor after every step, joint by joint; dashed on the hold-out."""
    figure, (axis,) = new_figure(1, 1, width=2.5 + 1.6 * max(3, len(refinement.steps)), height=3.8)
    _draw_ladder(axis, refinement)
    return figure


@styled
def diagnosis_figure(d: Diagnosis) -> Figure:
    """Where the model fails, as maps; the worst regions, on what the error depends, and the candidates."""
    joints = d.evidence.dynamics.joints
    rows = -(-len(joints) // _MAPS)
    figure = StyledFigure(figsize=(13.0, _ROW * (rows + 1)))
    grid = figure.add_gridspec(rows + 1, 1)
    errors = Errors(d)
    panels = _row(figure, grid[:rows, 0], rows, min(len(joints), _MAPS))
    for j, axis in zip(range(len(joints)), panels, strict=False):
        _draw_map(axis, errors, j)
    for axis in panels[len(joints) :]:
        axis.set_axis_off()
    cells, depends, candidates = _row(figure, grid[rows, 0], 1, 3)
    named = [
        (f"{joints[c.joint]}: {c.variable}\n{c.low:.3g} to {c.high:.3g}".replace("-", "−"), c.ratio)
        for c in d.cells[:_BARS]
    ]
    _bars(cells, "worst regions", "error / noise", named)
    _draw_dependence(depends, errors)
    _draw_candidates(candidates, d)
    return figure


@styled
def strip_figure(before: Diagnosis, refinement: Refinement) -> Figure:
    """Four pictures of one search: compare, where, candidates, the error falling.

    `before`: diagnosis of the first model, whose torque is drawn beside that of the last on the joint in question.
    """
    figure = StyledFigure(figsize=(17.0, 4.2))
    grid = figure.add_gridspec(2, 4, height_ratios=[2, 1], width_ratios=[1.25, 1, 1.05, 1])
    joint = _joint_in_question(before)
    errors = Errors(before)
    torque = figure.add_subplot(grid[0, 0])
    beneath = figure.add_subplot(grid[1, 0], sharex=torque)
    _draw_torque(torque, beneath, errors, refinement, joint)
    torque.set_title("1  compare")
    where, candidates, ladder = (figure.add_subplot(grid[:, column]) for column in (1, 2, 3))
    _draw_map(where, errors, joint)
    where.set_title(f"2  where {before.evidence.dynamics.joints[joint]} fails")
    _draw_candidates(candidates, before)
    candidates.set_title("3  candidates")
    _draw_ladder(ladder, refinement)
    ladder.set_title("4  the error falls")
    return figure


def _row(figure: Figure, place: Any, rows: int, columns: int) -> list[Axes]:
    inner = place.subgridspec(rows, columns)
    return [figure.add_subplot(inner[i, k]) for i in range(rows) for k in range(columns)]


def _unit(d: Diagnosis, joint: int) -> str:
    return Units(d.evidence.dynamics.robot.rotary[joint]).torque.replace(".", "·")


def _joint_in_question(d: Diagnosis) -> int:
    """That of the verdict; of an effect of the whole arm, or without one, that which has most left to explain."""
    best = d.verdict.best
    if best is not None and best.effect.joint is not None:
        return best.effect.joint
    return int(np.argmax([r.ratio or r.relative for r in d.residual.values()]))


def _draw_map(axis: Axes, errors: Errors, joint: int) -> None:
    d = errors.diagnosis
    name, units = d.evidence.dynamics.joints[joint], Units(d.evidence.dynamics.robot.rotary[joint])
    found = errors.map(joint)
    axis.set_facecolor(_UNVISITED)
    axis.grid(False)
    drawn = axis.pcolormesh(
        found.q, found.dq, found.mean[::-1], cmap=_DIVERGING, vmin=-found.scale, vmax=found.scale, rasterized=True
    )
    bar = axis.figure.colorbar(drawn, ax=axis, pad=0.02, aspect=30)
    bar.set_label(f"mean error ({_unit(d, joint)})")
    bar.outline.set_visible(False)
    axis.set_title(f"where {name} fails")
    axis.set_xlabel(f"{name} ({units.position})")
    axis.set_ylabel(f"velocity ({units.velocity})")


def _draw_dependence(axis: Axes, errors: Errors) -> None:
    """The error over the variable that it depends on most, and the next ones by name."""
    d = errors.diagnosis
    found = next((p for one in d.depends if (p := errors.profile(one.joint, one.variable)) is not None), None)
    axis.set_title("on what the error depends")
    if found is None:
        _nothing(axis)
        return
    _draw_profile(axis, found, d)
    joints = d.evidence.dynamics.joints
    others = [f"{joints[one.joint]}: {one.variable} ({one.score:.0f})" for one in d.depends[:4]]
    axis.annotate(
        "\n".join(["scores:", *others]), (0.02, 0.98), xycoords="axes fraction", va="top", fontsize=7.5, color=FAINT
    )
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.45 * (high - low))  # room for the scores


def _draw_profile(axis: Axes, found: Profile, d: Diagnosis) -> None:
    base, _, times = found.variable.partition("*")
    axis.errorbar(found.x, found.mean, found.spread, fmt="o-", ms=4, lw=1.4, elinewidth=1, color=COLOURS[0])
    axis.axhline(0, color=INK, lw=0.8)
    axis.set_xlabel(f"{d.evidence.dynamics.joints[found.joint]}: {base}")
    what = "error · direction" if times else "error"
    axis.set_ylabel(f"{what} ({_unit(d, found.joint)})")


def _draw_candidates(axis: Axes, d: Diagnosis) -> None:
    """Scores; what was named is full, what was refuted is grey."""
    joints, best = d.evidence.dynamics.joints, d.verdict.best
    told = [one for one in d.found if one.score > 0][:_BARS]
    colours = [FAINT if one.refuted else COLOURS[1] if one is best else COLOURS[4] for one in told]
    _bars(axis, "candidates", "score", [(label(one.effect, joints), one.score) for one in told], colours)
    for i, one in enumerate(told):
        said = "named" if one is best else "refuted" if one.refuted else ""
        axis.annotate(said, (one.score, i), (4, 0), textcoords="offset points", va="center", fontsize=8, color=INK)
    if told:
        axis.set_xlim(right=1.22 * max(one.score for one in told))


def _bars(
    axis: Axes, title: str, xlabel: str, bars: Sequence[tuple[str, float]], colours: Sequence[str] | None = None
) -> None:
    axis.set_title(title)
    axis.set_xlabel(xlabel)
    if not bars:
        _nothing(axis)
        return
    names, values = zip(*bars, strict=True)
    places = np.arange(len(names))
    axis.barh(places, values, height=0.62, color=colours or COLOURS[0])
    axis.set_yticks(places, names)
    axis.set_ylim(max(len(names), 4) - 0.4, -0.6)  # a single bar is not a wall
    axis.grid(False, axis="y")
    axis.tick_params(axis="y", length=0)


def _nothing(axis: Axes) -> None:
    axis.text(0.5, 0.5, "nothing stands out", ha="center", transform=axis.transAxes, color=FAINT)
    axis.set_xticks([])
    axis.set_yticks([])
    axis.set_xlabel("")


def _draw_ladder(axis: Axes, refinement: Refinement) -> None:
    joints = refinement.last.diagnosis.evidence.dynamics.joints
    names = [_step_name(label(step.effect, joints)) if step.effect else "as given" for step in refinement.steps]
    places = np.arange(float(len(names)))
    held = [step.diagnosis.holdout_ratio for step in refinement.steps]
    firsts = [refinement.steps[0].estimate.residual[joint].ratio or 0.0 for joint in joints]
    for j, joint in enumerate(joints):
        style: dict[str, Any] = {"color": COLOURS[j % len(COLOURS)]}
        ratio = [step.estimate.residual[joint].ratio or np.nan for step in refinement.steps]
        axis.plot(places, ratio, "o-", label=joint, **style)
        if j == int(np.argmax(firsts)):
            _annotate(axis, places, ratio, style["color"])
        if all(one is not None for one in held):
            values = [(one or {}).get(joint) or np.nan for one in held]
            axis.plot(places, values, "s--", label=f"{joint}, hold-out", markerfacecolor="white", **style)
    axis.axhline(1.0, color=INK, linewidth=0.8)
    axis.annotate(
        "noise floor", (1, 1.0), (-2, -3), ("axes fraction", "data"), "offset points", ha="right", va="top", fontsize=8
    )
    axis.set_xticks(places, names, fontsize=8 if len(names) < 5 else 6.5)
    axis.set_xlim(-0.45, max(len(names) - 1, 1) + 0.45)
    axis.set_ylim(bottom=0, top=1.12 * axis.get_ylim()[1])
    axis.set_ylabel("error / noise floor")
    axis.legend(loc="upper right")


def _annotate(axis: Axes, places: Array, values: Sequence[float], colour: str) -> None:
    """The first and the last value in figures."""
    for i in {0, len(values) - 1}:
        if np.isfinite(values[i]):
            axis.annotate(
                f"{values[i]:.3g}",
                (places[i], values[i]),
                (7, 5),
                textcoords="offset points",
                fontsize=8,
                color=colour,
            )


def _step_name(name: str) -> str:
    """On lines of its own, where it is long."""
    effect, _, joint = name.partition(":")
    effect = effect.replace("_", "_\n", 1) if len(effect) > 10 else effect
    return f"+ {effect}\n{joint}" if joint else f"+ {effect}"


def _draw_torque(above: Axes, beneath: Axes, errors: Errors, refinement: Refinement, joint: int) -> None:
    """Measured torque, that of the first and of the last model, where the first fails most; residuals beneath."""
    first, last = errors.diagnosis, refinement.last
    i = int(np.argmax([np.abs(value[:, joint]).max() for value in errors.values]))
    track = first.problem.tracks[i]
    later = last.diagnosis.problem
    predicted = {
        "first model": (first.problem.dynamics.torque(track.motion, first.theta), PREDICTED, "-"),
        "last model": (later.dynamics.torque(later.tracks[i].motion, last.estimate.theta), COLOURS[2], (0, (5, 2))),
    }
    t, measured = track.motion.t, track.torque[:, joint]
    inside = _worst_window(t, errors.values[i][:, joint])
    draw_line(above, t[inside], measured[inside], label="measured", color=MEASURED, lw=2.4, alpha=0.5)
    for name, (torque, colour, dashes) in predicted.items():
        if name == "last model" and len(refinement.steps) == 1:
            continue
        style: Any = {"color": colour, "linestyle": dashes, "lw": 1.0}
        draw_line(above, t[inside], torque[inside, joint], label=name, **style)
        draw_line(beneath, t[inside], (measured - torque[:, joint])[inside], **style)
    beneath.axhline(0, color=INK, lw=0.6)
    unit = _unit(first, joint)
    above.set_ylabel(f"{first.evidence.dynamics.joints[joint]}: {'force' if unit == 'N' else 'torque'} ({unit})")
    beneath.set_ylabel(f"residual ({unit})")
    beneath.set_xlabel("time (s)")
    above.tick_params(labelbottom=False)
    above.legend(
        loc="lower left",
        bbox_to_anchor=(0.2, 0.99),
        ncols=3,
        fontsize=8,
        handlelength=1.4,
        columnspacing=1.0,
        borderaxespad=0.2,
    )


def _worst_window(t: Array, error: Array) -> Array:
    """Samples (N,) of the stretch of `_WINDOW` s with the largest error."""
    count = int(np.searchsorted(t, t[0] + _WINDOW))
    if count >= len(t):
        return np.ones(len(t), dtype=bool)
    power = np.concatenate([[0.0], np.cumsum(np.nan_to_num(error) ** 2)])
    start = int(np.argmax(power[count:] - power[:-count]))
    inside = np.zeros(len(t), dtype=bool)
    inside[start : start + count] = True
    return inside
