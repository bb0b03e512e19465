"""Pictures of a diagnosis and of a ladder of errors."""

import numpy as np
from matplotlib.figure import Figure

from chebid.critique import Diagnosis, Refinement, label
from chebid.report.style import COLOURS, FAINT, INK, new_figure, styled

_BARS = 6  # candidates drawn


@styled
def ladder_figure(refinement: Refinement) -> Figure:
    """Error over noise floor after every step, joint by joint; dashed on the hold-out."""
    figure, (axis,) = new_figure(1, 1, width=7.0, height=3.6)
    joints = refinement.last.diagnosis.evidence.dynamics.joints
    names = [f"+ {label(step.effect, joints)}" if step.effect else "as given" for step in refinement.steps]
    places = np.arange(len(names))
    for j, joint in enumerate(joints):
        ratio = [step.estimate.residual[joint].ratio or np.nan for step in refinement.steps]
        axis.plot(places, ratio, "o-", color=COLOURS[j], label=joint)
        held = [step.diagnosis.holdout_ratio for step in refinement.steps]
        if all(one is not None for one in held):
            values = [(one or {}).get(joint) or np.nan for one in held]
            axis.plot(places, values, "s--", color=COLOURS[j], label=f"{joint}, hold-out", markerfacecolor="none")
    axis.axhline(1.0, color=INK, linewidth=0.8)
    axis.annotate("noise floor", (0, 1.0), textcoords="offset points", xytext=(0, 3), fontsize=8, color=FAINT)
    axis.set_xticks(places, names, rotation=20 if len(names) > 3 else 0)
    axis.set_ylabel("error / noise floor")
    axis.set_ylim(bottom=0)
    axis.legend(loc="upper right")
    return figure


@styled
def diagnosis_figure(d: Diagnosis) -> Figure:
    """Where the model fails, on what the error depends, and the candidates, as bars."""
    figure, axes = new_figure(1, 3, width=13.0, height=3.8)
    joints = d.evidence.dynamics.joints
    for axis, title, xlabel, bars in (
        (axes[0], "where it fails", "error / noise", [(f"{joints[c.joint]}: {c.variable}", c.ratio) for c in d.cells]),
        (
            axes[1],
            "on what the error depends",
            "score",
            [(f"{joints[on.joint]}: {on.variable}", on.score) for on in d.depends[:_BARS]],
        ),
        (
            axes[2],
            "candidates",
            "score",
            [(label(one.effect, joints), one.score) for one in d.found[:_BARS] if one.score > 0],
        ),
    ):
        axis.set_title(title)
        axis.set_xlabel(xlabel)
        if not bars:
            axis.text(0.5, 0.5, "nothing stands out", ha="center", transform=axis.transAxes, color=FAINT)
            axis.set_yticks([])
            continue
        names, values = zip(*bars, strict=True)
        axis.barh(np.arange(len(names)), values, color=COLOURS[0])
        axis.set_yticks(np.arange(len(names)), names)
        axis.invert_yaxis()
    return figure
