"""A model in words: its robot, its effects, and how its fit was made."""

import dataclasses
import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from chebid.critique import Diagnosis, label
from chebid.effects import Effect, Units
from chebid.errors import Notice
from chebid.model import Model
from chebid.report.tables import number

_MECHANISMS = {
    "scara": "A planar arm of two links (SCARA)",
    "axes": "Independent axes, one inertia each",
    "urdf": "A chain of rigid bodies from a URDF file",
    "dh": "A chain of rigid bodies from a table of Denavit and Hartenberg",
}
_METHODS = {
    "poly": "least squares on polynomial projections of both sides of the equations",
    "wls": "weighted least squares on low-pass filtered central differences",
    "huber": "Huber's robust regression on low-pass filtered central differences",
    "iv": "instrumental variables from a simulation of the closed loop",
    "ekf": "an extended Kalman filter",
    "dr": "robust sliding-mode differentiators",
}
_STATUS = {
    "missing": "an effect is missing",
    "nothing_missing": "nothing is missing",
    "unknown": "something unknown is missing",
    "bad_data": "the log cannot be trusted",
}


def pretty(unit: str) -> str:
    """N.m.s/rad as N·m·s/rad, kg.m^2 as kg·m²; of a number without a unit, nothing."""
    dotted = re.sub(r"(?<!\d)\.|\.(?!\d)", "·", unit)
    return "" if unit == "1" else re.sub(r"\^([23])(?![\d.])", lambda power: {"2": "²", "3": "³"}[power[1]], dotted)


def torque_unit(rotary: bool) -> str:
    """N·m or N."""
    return pretty(Units(rotary).torque)


def notice_text(notice: Notice) -> str:
    """A warning, with the name of its file only: a page says the same wherever its log lies."""
    place = notice.place
    if place.file is not None:
        place = dataclasses.replace(place, file=Path(place.file).name)
    return str(dataclasses.replace(notice, place=place))


def robot_words(model: Model, rotary: Sequence[bool]) -> str:
    """The mechanism and its joints."""
    kinds = {True: "turns", False: "slides"}
    joints = ", ".join(f"{name} {kinds[turns]}" for name, turns in zip(model.joints, rotary, strict=True))
    file = f" ({Path(model.robot.file).name})" if model.robot.file else ""
    return f"{_MECHANISMS[model.robot.type]}{file}: {joints}."


def effect_rows(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Every effect of the model once: joints, sentence, formula, hyper-parameters, when it was added."""
    dynamics = diagnosis.evidence.dynamics
    merged: dict[tuple[str, str, str], dict[str, Any]] = {}
    for effect in dynamics.effects:
        row = _effect_row(effect, dynamics.joints)
        first = merged.setdefault((row["name"], row["formula"], row["settings"]), row)
        if first is not row:
            first["where"] += f", {row['where']}"
    return list(merged.values())


def _effect_row(effect: Effect, joints: tuple[str, ...]) -> dict[str, Any]:
    return {
        "name": effect.name,
        "where": "whole arm" if effect.joint is None else joints[effect.joint],
        "sentence": effect.sentence or "an effect of your own",
        "formula": effect.formula or str(effect.settings(joints).get("formula", "")),
        "settings": settings_words(effect.settings(joints)),
    }


def settings_words(settings: Mapping[str, Any]) -> str:
    """Hyper-parameters as name = value."""
    told = {key: value for key, value in settings.items() if key != "formula"}
    return ", ".join(f"{key} = {number(v, 3) if isinstance(v, float) else v}" for key, v in told.items())


def fit_words(model: Model, diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """How the fit was made, and how the logs were treated on this page."""
    assert model.fit is not None, "a fitted model"
    problem, joints = diagnosis.problem, diagnosis.evidence.dynamics.joints
    rotary = diagnosis.evidence.dynamics.robot.rotary
    gates = zip(joints, problem.gate, rotary, strict=True)
    record = model.fit.record.model_dump()
    logs = ", ".join(str(log.get("file")) for log in record.get("logs") or [] if isinstance(log, dict))
    return [
        ("method", f"{model.fit.method}: {_METHODS[model.fit.method]}"),
        ("fitted on", logs or "not recorded"),
        ("chebid", str(record.get("chebid", "not recorded"))),
        ("positions", f"passed up to {problem.bandwidth:.3g} Hz"),
        ("equations", f"up to {problem.band.frequency:.3g} Hz: {problem.band.reason}"),
        ("effects judged", f"up to {diagnosis.evidence.ground.band:.3g} Hz"),
        ("slow samples left out", ", ".join(f"{j} below {g:.2g} {Units(turns).velocity}" for j, g, turns in gates)),
    ]


def status_words(diagnosis: Diagnosis) -> tuple[str, str]:
    """The verdict in four words, and whether it is sure."""
    verdict = diagnosis.verdict
    head = _STATUS[verdict.status]
    if verdict.changed:
        head = "something has changed since the fit"
    return head, ("sure" if verdict.sure else "not sure") if verdict.status == "missing" else ""


def next_commands(
    diagnosis: Diagnosis, model: str, logs: Sequence[str], beside: Sequence[str] = ()
) -> list[tuple[str, str]]:
    """What to type next, each with what it is for."""
    joints, verdict = diagnosis.evidence.dynamics.joints, diagnosis.verdict
    if verdict.status != "missing" or verdict.best is None:
        return []
    name, given = label(verdict.best.effect, joints), shlex.join(logs)
    grown = shlex.quote(f"{Path(model).stem}_{verdict.best.effect.name}.yaml")
    more = "".join(f" --holdout {shlex.quote(log)}" for log in beside)
    out = [("add it", f"chebid add {shlex.quote(model)} {shlex.quote(name)} {given}{more} -o {grown}")]
    rivals = [label(one.effect, joints) for one in verdict.alternatives]
    if rivals:
        asked = shlex.join([name, *rivals])
        out.insert(0, ("tell them apart", f"chebid excite {shlex.quote(model)} --separate {asked} -o separate.csv"))
    return out
