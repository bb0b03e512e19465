"""The JSON documents of `diagnose` and `refine`, as in the agreement."""

from typing import Any

from chebid.critique.diagnosis import Diagnosis
from chebid.critique.found import Found
from chebid.critique.refine import Refinement
from chebid.critique.words import message
from chebid.effects import Effect

_TOLD = 10  # candidates, dependences


def diagnosis_document(d: Diagnosis) -> dict[str, Any]:
    """The document of `diagnose`."""
    joints = d.evidence.dynamics.joints
    verdict = d.verdict
    named = [verdict.best] if verdict.best is not None and verdict.status == "missing" else []
    return {
        "joints": [_joint(d, joint) for joint in joints],
        "where": [
            {
                "joint": joints[c.joint],
                "variable": c.variable,
                "low": c.low,
                "high": c.high,
                "ratio": c.ratio,
                "mean": c.mean,
            }
            for c in d.cells
        ],
        "depends_on": [
            {"joint": joints[on.joint], "variable": on.variable, "score": on.score} for on in d.depends[:_TOLD]
        ],
        "candidates": [_candidate(d, one) for one in d.found[:_TOLD]],
        "verdict": {
            "status": verdict.status,
            "sure": verdict.sure,
            "effects": [effect_document(one.effect, joints) for one in named],
            "alternatives": [effect_document(one.effect, joints) for one in verdict.alternatives],
            "changed": verdict.changed,
            "smallest": verdict.smallest,
            "message": message(d),
        },
        "data": {"warnings": [str(notice) for notice in d.notices]},
    }


def _joint(d: Diagnosis, joint: str) -> dict[str, Any]:
    r = d.residual[joint]
    ratio = r.ratio
    return {
        "joint": joint,
        "rms": r.rms,
        "relative": r.relative,
        "floor": r.floor,
        "floor_kind": r.floor_kind,
        "ratio": ratio,
        "holdout_ratio": d.holdout_ratio[joint] if d.holdout_ratio else None,
        "explainable": None if not ratio else max(0.0, 1 - 1 / ratio**2),
    }


def _candidate(d: Diagnosis, one: Found) -> dict[str, Any]:
    joints = d.evidence.dynamics.joints
    return {
        **effect_document(one.effect, joints),
        "score": one.score,
        "holdout_score": one.holdout,
        "parameters": {
            p.parameter.name: {"value": p.value, "sd": p.sd, "unit": p.parameter.unit} for p in one.parameters
        },
        "hyperparameters": one.effect.settings(joints),
        "ratio_after": one.ratio_after,
        "holdout_ratio_after": one.holdout_ratio_after,
        "stability": one.stability,
    }


def effect_document(effect: Effect, joints: tuple[str, ...]) -> dict[str, Any]:
    """Name and joint of an effect; joint None for the whole arm."""
    return {"effect": effect.name, "joint": None if effect.joint is None else joints[effect.joint]}


def refinement_document(refinement: Refinement) -> dict[str, Any]:
    """The document of `refine`: the last diagnosis, the steps, and what was added."""
    joints = refinement.last.diagnosis.evidence.dynamics.joints
    steps = [
        {
            **(effect_document(step.effect, joints) if step.effect else {"effect": None, "joint": None}),
            "ratio": {joint: r.ratio for joint, r in step.estimate.residual.items()},
            "relative": {joint: r.relative for joint, r in step.estimate.residual.items()},
            "holdout_ratio": step.diagnosis.holdout_ratio,
        }
        for step in refinement.steps
    ]
    values = {p.name: p for p in refinement.last.estimate.parameters}
    theta = dict(zip(values, refinement.last.estimate.theta, strict=True))
    sd = dict(zip(values, refinement.last.estimate.sd, strict=True))
    dynamics = refinement.last.diagnosis.problem.dynamics
    added = []
    for one in refinement.added:
        names = dynamics.names(one.effect) if one.effect in dynamics.effects else ()
        added.append(
            {
                **effect_document(one.effect, joints),
                "parameters": {n: {"value": theta[n], "sd": sd[n], "unit": values[n].unit} for n in names},
                "hyperparameters": one.effect.settings(joints),
                "sure": one.verdict.sure,
                "alternatives": [effect_document(other.effect, joints) for other in one.verdict.alternatives],
            }
        )
    dropped = [effect_document(effect, joints) for effect in refinement.dropped]
    return diagnosis_document(refinement.last.diagnosis) | {"steps": steps, "added": added, "dropped": dropped}
