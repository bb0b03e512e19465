"""What the template is given: plain values, in the order in which a reader asks."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from chebid.critique import Diagnosis, Found, diagnosis_document, label
from chebid.effects import Units
from chebid.equations import moving
from chebid.estimators import Problem
from chebid.report.page.collect import Report, Sheet
from chebid.report.page.curves import curve, most_samples
from chebid.report.page.marks import ladder_marks, map_marks, profile_marks
from chebid.report.page.words import (
    effect_rows,
    fit_words,
    next_commands,
    notice_text,
    pretty,
    robot_words,
    settings_words,
    status_words,
    torque_unit,
)
from chebid.report.residuals import Errors
from chebid.report.tables import short_names

_TOLD = 8  # candidates, dependences
_DRAWN = 3  # dependences of which the error is drawn
_REASONS = 3  # of a log, why its signals were projected so
_SIGNALS = 60  # rows of signals of a log
_UNCERTAIN = 10.0  # percent


def page_content(report: Report) -> dict[str, Any]:
    """Everything that the template needs."""
    entries = report.comparisons.entries
    models = short_names(list(dict.fromkeys(entry.model for entry in entries)))
    logs = short_names(list(dict.fromkeys(entry.log for entry in entries)))
    curves = sum(len(entry.residual) for entry in entries)
    return {
        "models": list(models.values()),
        "logs": [_log(entry.problem, logs[entry.log]) for entry in report.sheets[0].entries],
        "comparison": _comparison(report, models, logs),
        "sheets": [_sheet(sheet, models, logs, most_samples(curves), i) for i, sheet in enumerate(report.sheets)],
    }


# logs -----------------------------------------------------------------------------------------------------------------


def _log(problem: Problem, name: str) -> dict[str, Any]:
    """A log, what is odd about it, and what the projection of its signals costs."""
    log, rotary = problem.logs[0], problem.dynamics.robot.rotary
    samples = sum(len(record.t) for record in log.records)
    missing = sum(
        int((~np.isfinite(np.column_stack([r.q, r.tau if r.tau is not None else r.q]))).sum()) for r in log.records
    )
    rows = [
        {
            "record": i,
            "signal": p.name,
            "unit": Units(turns).position,
            "fit": p.plan.fit,
            "degree": p.plan.degree,
            "windows": p.operator.layout.count,
            "bandwidth": p.plan.bandwidth,
            "noise": p.noise,
            "left_out": p.energy_left_out,
            "end": p.end_length(),
            "lag1": p.lag1_autocorrelation,
            "reason": p.plan.reason,
        }
        for i, track in enumerate(problem.tracks, 1)
        for p, turns in zip(track.projections, rotary, strict=True)
    ]
    return {
        "name": name,
        "sha256": log.sha256,
        "facts": [
            ("records", str(len(log.records))),
            ("duration", f"{sum(record.duration for record in log.records):.4g} s"),
            ("samples", str(samples)),
            ("rate", ", ".join(dict.fromkeys(f"{record.rate:.4g} Hz" for record in log.records))),
            ("clock", "even steps" if all(record.uniform for record in log.records) else "uneven steps"),
            ("values missing or left out", str(missing)),
        ],
        "warnings": list(dict.fromkeys(notice_text(notice) for notice in problem.notices)),
        "signals": rows[:_SIGNALS],
        "more": max(0, len(rows) - _SIGNALS),
        "several": len(log.records) > 1,
        "reasons": _few(list(dict.fromkeys(str(row["reason"]) for row in rows))),
    }


def _few(reasons: list[str]) -> list[str]:
    return (
        reasons if len(reasons) <= _REASONS else [*reasons[:_REASONS], f"and {len(reasons) - _REASONS} more like these"]
    )


# comparison -----------------------------------------------------------------------------------------------------------


def _comparison(report: Report, models: Mapping[str, str], logs: Mapping[str, str]) -> dict[str, Any]:
    """Every model on every log; of several models the least error of each joint on each log is marked."""
    rows, floors = [], set()
    for sheet in report.sheets:
        rotary = dict(zip(sheet.model.joints, sheet.diagnosis.evidence.dynamics.robot.rotary, strict=True))
        for entry in sheet.entries:
            for joint, r in entry.residual.items():
                rows.append(
                    {
                        "model": models[entry.model],
                        "log": logs[entry.log],
                        "fitted": entry.log in sheet.fitted,
                        "joint": joint,
                        "unit": torque_unit(rotary[joint]),
                        **{key: getattr(r, key) for key in ("rms", "relative", "relative_raw", "floor", "ratio")},
                    }
                )
                floors.add(r.floor_kind)
    for row in rows:
        rivals = [other["rms"] for other in rows if (other["log"], other["joint"]) == (row["log"], row["joint"])]
        row["best"] = len(rivals) > 1 and row["rms"] == min(rivals) < max(rivals)
        _on_one_floor(row, [other for other in rows if (other["log"], other["joint"]) == (row["log"], row["joint"])])
    order = {key: i for i, key in enumerate(dict.fromkeys((row["log"], row["joint"]) for row in rows))}
    return {
        "rows": sorted(rows, key=lambda row: order[row["log"], row["joint"]]),  # models side by side
        "overall": _overall(report, models, logs),
        "floors": sorted(floors),
        "most": _most(row["ratio"] for row in rows),
    }


def _on_one_floor(row: dict[str, Any], rivals: list[dict[str, Any]]) -> None:
    """Measure the error of a row against the least noise floor of all models: what one explains is no noise."""
    floors = [other["floor"] for other in rivals if other["floor"]]
    if floors:
        row["floor"] = min(floors)
        row["ratio"] = row["rms"] / row["floor"]


def _overall(report: Report, models: Mapping[str, str], logs: Mapping[str, str]) -> list[dict[str, Any]]:
    """Relative error of all joints together: a row for each log, a column for each model."""
    values = {(e.log, e.model): e.overall for e in report.comparisons.entries}
    rows = []
    for log, name in logs.items():
        mine = [values[log, model] for model in models]
        least = min(mine) if min(mine) < max(mine) else None
        rows.append({"log": name, "cells": [(value, value == least) for value in mine]})
    return rows


def _most(values: Any) -> float:
    return max((value for value in values if value is not None), default=1.0)


# one model ------------------------------------------------------------------------------------------------------------


def _sheet(sheet: Sheet, models: Mapping[str, str], logs: Mapping[str, str], most: int, index: int) -> dict[str, Any]:
    d, model = sheet.diagnosis, sheet.model
    rotary, name = d.evidence.dynamics.robot.rotary, models[str(model.path)]
    document = diagnosis_document(d)
    head, surety = status_words(d)
    judged = [logs[str(log.path)] for log in d.problem.logs]
    beside = [logs[entry.log] for entry in sheet.entries if logs[entry.log] not in judged]
    units = dict(zip(model.joints, map(torque_unit, rotary), strict=True))
    turns = dict(zip(model.joints, rotary, strict=True))
    errors = Errors(d)
    return {
        "id": f"m{index}",
        "name": name,
        "status": d.verdict.status,
        "head": head,
        "surety": surety,
        "message": document["verdict"]["message"].replace("->", "→"),
        "commands": next_commands(d, name, judged, beside),
        "judged": judged,
        "holdout": beside,
        "own": bool(sheet.fitted),
        "robot": robot_words(model, rotary),
        "effects": effect_rows(d),
        "fit": fit_words(model, d),
        "curves": [curves for entry in sheet.entries for curves in _curves(entry, logs, units, most)],
        "maps": [_map(errors, j, rotary[j]) for j in range(len(model.joints))],
        "cells": [_cell(row, units, turns, d) for row in document["where"]],
        "depends": _depends(errors, units, turns),
        "candidates": _candidates(d),
        "ladder": _ladder(sheet, units),
        "parameters": _parameters(sheet),
    }


def _curves(entry: Any, logs: Mapping[str, str], units: Mapping[str, str], most: int) -> list[dict[str, Any]]:
    problem = entry.problem
    torques = [problem.dynamics.torque(track.motion, entry.theta) for track in problem.tracks]
    used = [moving(track, problem.gate) for track in problem.tracks]
    return [
        {
            "log": logs[entry.log],
            "group": problem.logs[0].sha256[:16],
            "joint": joint,
            "unit": units[joint],
            "what": "force" if units[joint] == "N" else "torque",
            "relative": entry.residual[joint].relative_raw,
            "data": curve(problem.tracks, torques, used, j, most),
        }
        for j, joint in enumerate(problem.dynamics.joints)
    ]


def _map(errors: Errors, joint: int, rotary: bool) -> dict[str, Any]:
    d, units = errors.diagnosis, Units(rotary)
    name = d.evidence.dynamics.joints[joint]
    found = errors.map(joint)
    worst = np.unravel_index(int(np.nanargmax(np.abs(np.nan_to_num(found.mean)))), found.mean.shape)
    centre = [(x[1:] + x[:-1]) / 2 for x in (found.q, found.dq)]
    return {
        "joint": name,
        "unit": torque_unit(rotary),
        "position": units.position,
        "velocity": units.velocity,
        "scale": found.scale,
        "worst": {
            "mean": float(np.nan_to_num(found.mean)[worst]),
            "q": float(centre[0][worst[1]]),
            "dq": float(centre[1][::-1][worst[0]]),
        },
        "marks": map_marks(found),
        "data": {
            "q": [float(f"{v:.4g}") for v in centre[0]],
            "dq": [float(f"{v:.4g}") for v in centre[1][::-1]],
            "mean": [[None if np.isnan(v) else float(f"{v:.3g}") for v in row] for row in found.mean],
        },
    }


def _cell(row: dict[str, Any], units: Mapping[str, str], turns: Mapping[str, bool], d: Diagnosis) -> dict[str, Any]:
    """A region where the error stands out; a window of time can be shown if there is one log to show it in."""
    logs = d.problem.logs
    group = logs[0].sha256[:16] if row["variable"] == "t" and len(logs) == 1 and len(logs[0].records) == 1 else None
    return row | {"torque": units[row["joint"]], "unit": _unit_of(row["variable"], row["joint"], turns), "group": group}


def _unit_of(variable: str, joint: str, turns: Mapping[str, bool]) -> str:
    """Unit of a variable of a joint; of another joint whose name stands in brackets."""
    found = re.fullmatch(r"(abs\()?(q|dq|ddq|tau|t|distance since reversal)(?:\[(.+)\])?\)?", variable)
    if found is None:
        return ""
    own = Units(turns[found[3] or joint])
    units = {"q": own.position, "dq": own.velocity, "ddq": own.velocity + "²", "tau": pretty(own.torque), "t": "s"}
    return units.get(found[2], own.position)


def _depends(errors: Errors, units: Mapping[str, str], turns: Mapping[str, bool]) -> dict[str, Any]:
    """On what the error depends: every variable with its score, and the error over the best of them."""
    d = errors.diagnosis
    joints = d.evidence.dynamics.joints
    told = d.depends[:_TOLD]
    rows = [{"joint": joints[one.joint], "variable": one.variable, "score": one.score} for one in told]
    pictures: dict[tuple[int, str, bool], dict[str, Any]] = {}
    for one in told:
        base, _, times = one.variable.partition("*")
        key = one.joint, base, bool(times)  # times sign(dq), or times dq: the same picture
        if key not in pictures and len(pictures) < _DRAWN and (found := errors.profile(one.joint, one.variable)):
            unit = _unit_of(base, joints[one.joint], turns)
            pictures[key] = {
                "joint": joints[one.joint],
                "variable": one.variable,
                "across": f"{base} ({unit})" if unit else base,
                "times": "error · direction" if times else "error",
                "unit": units[joints[one.joint]],
                "marks": profile_marks(found),
                "low": float(found.mean.min()),
                "high": float(found.mean.max()),
            }
    return {"rows": rows, "pictures": list(pictures.values()), "most": _most(row["score"] for row in rows)}


def _candidates(d: Diagnosis) -> dict[str, Any]:
    told = [one for one in d.found if one.score > 0][:_TOLD]
    rows = [_candidate(one, d) for one in told]
    return {"rows": rows, "most": _most(row["score"] for row in rows), "holdout": d.holdout is not None}


def _candidate(one: Found, d: Diagnosis) -> dict[str, Any]:
    joints = d.evidence.dynamics.joints
    return {
        "name": label(one.effect, joints),
        "sentence": one.effect.sentence,
        "formula": one.effect.formula,
        "settings": settings_words(one.effect.settings(joints)),
        "score": one.score,
        "holdout": one.holdout,
        "stability": one.stability,
        "refuted": one.refuted,
        "parameters": [
            {"name": p.parameter.name, "value": p.value, "sd": p.sd, "unit": pretty(p.parameter.unit)}
            for p in one.parameters
        ],
        "after": one.ratio_after or {},
        "holdout_after": one.holdout_ratio_after or {},
        "before": {joint: r.ratio for joint, r in d.residual.items()},
    }


def _ladder(sheet: Sheet, units: Mapping[str, str]) -> dict[str, Any] | None:
    """The steps of a refinement, as the model file records them; None for a model that was not refined."""
    assert sheet.model.fit is not None, "a fitted model"
    kept = sheet.model.fit.record.model_dump().get("refinement")
    steps = kept.get("steps") if isinstance(kept, dict) else None
    if not isinstance(steps, list) or not all(isinstance(step, dict) for step in steps) or not steps:
        return None
    joints = list(units)
    ratios = [(joint, False, [_ratio(step, "ratio", joint) for step in steps]) for joint in joints]
    held = [(joint, True, [_ratio(step, "holdout_ratio", joint) for step in steps]) for joint in joints]
    series = [one for one in (*ratios, *held) if any(value is not None for value in one[2])]
    rows = [
        {
            "number": i,
            "name": f"+ {step['added']}" if step.get("added") else "model as given",
            "values": [values[i] for _, _, values in series],
            "verdict": str(step.get("verdict") or "").replace("->", "→"),
            "rejected": _rejected(step),
        }
        for i, step in enumerate(steps)
    ]
    heads = [f"{joint}, hold-out" if held else joint for joint, held, _ in series]
    dropped = [str(name) for name in (kept or {}).get("dropped") or []]
    return {"heads": heads, "rows": rows, "dropped": dropped, "marks": ladder_marks(series, len(steps))}


def _ratio(step: Mapping[str, Any], key: str, joint: str) -> float | None:
    values = step.get(key)
    value = values.get(joint) if isinstance(values, dict) else None
    return float(value) if isinstance(value, int | float) else None


def _rejected(step: Mapping[str, Any]) -> str:
    rows = [one for one in step.get("rejected") or [] if isinstance(one, dict)]
    return ", ".join(f"{one.get('effect')}{':' + str(one['joint']) if one.get('joint') else ''}" for one in rows)


def _parameters(sheet: Sheet) -> list[dict[str, Any]]:
    """Every parameter; `share` of its relative deviation that fills a bar, at 10 % full."""
    fit = sheet.model.fit
    assert fit is not None, "a fitted model"
    rows = []
    for name, p in fit.parameters.items():
        relative = None if p.sd is None or p.value == 0 else 100 * p.sd / abs(p.value)
        rows.append(
            {
                "name": name,
                "joint": p.joint or "whole arm",
                "value": p.value,
                "sd": p.sd,
                "relative": relative,
                "share": 0.0 if relative is None else min(1.0, relative / _UNCERTAIN),
                "unit": pretty(p.unit),
                "remark": _remark(p.value, p.sd, relative),
            }
        )
    return rows


def _remark(value: float, sd: float | None, relative: float | None) -> str:
    if sd is not None and 1.96 * sd >= abs(value):
        return "cannot be told from zero"
    return "hardly identifiable" if relative is not None and relative >= _UNCERTAIN else ""
