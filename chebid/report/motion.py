"""Motions: what a simulated arm did, and what an exciting trajectory asks for."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chebid.effects import Units
from chebid.excite import Excitation
from chebid.report.style import COLOURS, FAINT, INK, new_figure, styled
from chebid.robots import Array
from chebid.simulate import Simulated

_REFERENCE: dict[str, Any] = {"color": INK, "ls": "--", "lw": 1.2}
_DONE: dict[str, Any] = {"color": COLOURS[0], "ls": "-"}


@styled
def simulation_figure(log: Simulated, joints: Sequence[str], rotary: Sequence[bool]) -> Figure:
    """Each joint a row: position and reference, tracking error with the time spent sticking, torque as logged."""
    figure, axes = new_figure(len(joints), 3, width=12.0, height=0.8 + 2.1 * len(joints), sharex=True)
    for j, name in enumerate(joints):
        position, error, torque = axes[3 * j : 3 * j + 3]
        units = Units(rotary[j])
        position.plot(log.t, log.q[:, j], label="encoder", **_DONE)
        position.plot(log.t, log.reference[:, j], label="reference", **_REFERENCE)
        error.plot(log.t, log.reference[:, j] - log.q_true[:, j], **_DONE)
        _shade(error, log.t, log.sticks[:, j])
        torque.plot(log.t, log.tau[:, j], lw=0.8, **_DONE)
        for axis, what, unit in (
            (position, name, units.position),
            (error, f"{name}: error", units.position),
            (torque, f"{name}: torque", units.torque.replace(".", "·")),
        ):
            axis.set_ylabel(f"{what} ({unit})")
    for axis in axes[-3:]:
        axis.set_xlabel("time (s)")
    axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    if log.sticks.any():
        axes[1].set_title("shaded: held by dry friction")
    axes[2].set_title("torque as logged")
    return figure


def _shade(axis: Axes, t: Array, where: Array) -> None:
    low, high = axis.get_ylim()
    axis.fill_between(t, low, high, where=where, step="post", color=FAINT, alpha=0.35, lw=0)
    axis.set_ylim(low, high)


@styled
def excitation_figure(found: Excitation, joints: Sequence[str], rotary: Sequence[bool]) -> Figure:
    """Each joint a row: position, velocity, acceleration, the limits dashed, the points of rest dotted."""
    figure, axes = new_figure(len(joints), 3, width=12.0, height=0.8 + 2.1 * len(joints), sharex=True)
    score, limits = found.score, found.limits.stacked()
    for j, name in enumerate(joints):
        unit = Units(rotary[j]).position
        for order, (values, per) in enumerate(((found.q, ""), (found.dq, "/s"), (found.ddq, "/s²"))):
            axis = axes[3 * j + order]
            axis.plot(found.t, values[:, j], **_DONE)
            low, high = axis.get_ylim()
            for way in (-1, 1):
                axis.axhline(way * limits[order, j], **_REFERENCE)
            if found.used[order, j] < 0.6:  # a limit far away would flatten the curve
                axis.set_ylim(low, high)
            for rest in [] if found.durations is None else found.durations.cumsum()[:-1]:
                axis.axvline(rest, color=FAINT, lw=0.6, ls=":")
            axis.set_ylabel(f"{name} ({unit}{per})")
            axis.text(0.99, 1.0, f"{found.used[order, j]:.0%} of the limit", ha="right", transform=axis.transAxes)
    for axis, what in zip(axes, ("position", "velocity", "acceleration"), strict=False):
        axis.set_title(what)
    for axis in axes[-3:]:
        axis.set_xlabel("time (s)")
    figure.suptitle(f"criterion {score.value:.3g}, condition number {score.condition:.3g}", x=0.01, ha="left", size=10)
    return figure
