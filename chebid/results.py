"""From estimates to what a user keeps: the fitted model, documents, predictions, comparisons."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from chebid.basis import Array
from chebid.dynamics import make_dynamics
from chebid.errors import InputError, Notice, Place
from chebid.estimators import Estimate, JointResidual, Problem, judge, overall
from chebid.estimators.wls import wls_rows
from chebid.log import Log, read_log
from chebid.model import Covariance, FitSection, FittedValue, Model, settings_of
from chebid.motion import Track, make_track
from chebid.projection import Setting

_UNCERTAIN = 10.0  # percent: "not, or hardly, identifiable on this trajectory" (paper, section 3.3)


def fitted_model(model: Model, estimate: Estimate, out: Path | None = None) -> Model:
    """The model with its `fit:` section."""
    values = {
        p.name: FittedValue(value=float(value), sd=float(sd), unit=p.unit, joint=p.joint)
        for p, value, sd in zip(estimate.parameters, estimate.theta, estimate.sd, strict=True)
    }
    covariance = Covariance(parameters=tuple(values), matrix=tuple(map(tuple, estimate.covariance.tolist())))
    record = {key: value for key, value in estimate.record.items() if value is not None}
    fit = FitSection.model_validate(
        {
            "method": estimate.method,
            "parameters": values,
            "hyperparameters": _plain(make_dynamics(model).hyperparameters()),
            "covariance": covariance,
            "record": _plain(record),
        }
    )
    return model.with_fit(fit)


def _plain(value: Any) -> Any:
    """Numpy numbers to Python ones, for YAML."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def estimate_document(estimate: Estimate, out: Path | None) -> dict[str, Any]:
    """The JSON document of `identify`. `sd` and `relative_sd` (percent) are honest, the others those of eq. 25, 26."""
    columns = (
        estimate.theta,
        estimate.sd,
        estimate.relative(estimate.sd),
        estimate.sd_white,
        estimate.relative(estimate.sd_white),
    )
    parameters = [
        {
            "name": p.name,
            "joint": p.joint,
            "value": value,
            "sd": sd,
            "relative_sd": relative,
            "sd_eq25": white,
            "relative_sd_eq26": relative_white,
            "unit": p.unit,
        }
        for p, value, sd, relative, white, relative_white in zip(estimate.parameters, *columns, strict=True)
    ]
    return {
        "model": str(out) if out else None,
        "method": estimate.method,
        "joints": list(estimate.residual),
        "parameters": parameters,
        "condition_number": estimate.condition,
        "bandwidth": estimate.record["bandwidth"],
        "degree": estimate.record["degree"],
        "residual": {joint: residual_document(r) for joint, r in estimate.residual.items()},
        "torque_lag": None if estimate.lag is None else {"value": estimate.lag.value, "sd": estimate.lag.sd},
        "warnings": [str(notice) for notice in estimate.notices],
        "remarks": remarks(estimate),
        **({"consistency": estimate.record["consistency"]} if "consistency" in estimate.record else {}),
        "record": estimate.record,
    }


def residual_document(r: JointResidual) -> dict[str, Any]:
    """One joint's residual, as in the agreement."""
    return {
        "rms": r.rms,
        "relative": r.relative,
        "relative_raw": r.relative_raw,
        "floor": r.floor,
        "ratio": r.ratio,
        "floor_kind": r.floor_kind,
    }


def remarks(estimate: Estimate) -> list[str]:
    """What the data cannot give, in words."""
    out = []
    for p, value, sd in zip(estimate.parameters, estimate.theta, estimate.sd, strict=True):
        share = 100 * sd / abs(value) if value else np.inf
        if 1.96 * sd >= abs(value):
            out.append(f"{p.name}: the data cannot tell it from zero ({value:.3g} +- {1.96 * sd:.2g} {p.unit}, 95 %)")
        elif share >= _UNCERTAIN:
            out.append(f"{p.name}: hardly identifiable on this motion (relative deviation {share:.0f} %)")
    if "consistency" in estimate.record:
        out.append(f"Durbin-Wu-Hausman: {estimate.record['consistency']['message']}")
    return out


def fitted_values(model: Model) -> Array:
    """theta (P,) of a fitted model. Raises InputError when the file has no fit, or one of other parameters."""
    where = Place(file=str(model.path), key="fit")
    if model.fit is None:
        raise InputError("holds no identified parameters", hint="run chebid identify first, with -o", place=where)
    names = [p.name for p in make_dynamics(model).parameters]
    missing = [name for name in names if name not in model.fit.parameters]
    extra = [name for name in model.fit.parameters if name not in names]
    if missing or extra:
        what = (
            f"lacks {', '.join(missing)}"
            if missing
            else f"has {', '.join(extra)}, which the robot and its effects do not"
        )
        raise InputError(what, hint="identify again: robot or effects were changed after the fit", place=where)
    return np.array([model.fit.parameters[name].value for name in names])


def fitted_problem(model: Model, log: Log) -> Problem:
    """A log, treated as those of the model's fit were."""
    return Problem(model, (log,), used=model.fit.treatment if model.fit else None)


def predict_tracks(model: Model, log: Log, theta: Array) -> tuple[list[Track], list[Array]]:
    """The tracks of a log, which needs no torque, and the model's torque (N, J) on each."""
    p, delay = model.processing, model.log.torque_delay
    setting = Setting(fit=p.fit, degree=p.degree, bandwidth=p.bandwidth)
    tracks = [make_track(log, record, setting, delay=delay) for record in log.records]
    dynamics = make_dynamics(model)
    return tracks, [dynamics.torque(track.motion, theta) for track in tracks]


@dataclass(frozen=True)
class Comparison:
    """One model on one log."""

    model: str
    log: str
    problem: Problem
    theta: Array
    residual: dict[str, JointResidual]
    overall: float


@dataclass(frozen=True)
class Comparisons:
    """Every model on every log."""

    entries: tuple[Comparison, ...]
    notices: tuple[Notice, ...]

    def rows(self) -> list[dict[str, Any]]:
        return [
            {"model": entry.model, "log": entry.log, "joint": joint} | residual_document(r)
            for entry in self.entries
            for joint, r in entry.residual.items()
        ]

    def document(self) -> dict[str, Any]:
        """The JSON document of `compare`."""
        return {
            "models": list(dict.fromkeys(entry.model for entry in self.entries)),
            "logs": list(dict.fromkeys(entry.log for entry in self.entries)),
            "results": self.rows(),
            "overall_relative": [{"model": e.model, "log": e.log, "relative": e.overall} for e in self.entries],
            "warnings": [str(notice) for notice in self.notices],
        }


def compare_models(models: list[Model], paths: list[Path]) -> Comparisons:
    """Judge every model on every log, on rows made as those of its fit."""
    entries: list[Comparison] = []
    read = functools.cache(lambda path, spec, joints: read_log(path, spec, joints, need_torque=True))
    for model in models:
        theta = fitted_values(model)
        entries += [_compare(model, read(path, model.log, model.joints), theta) for path in paths]
    notices = dict.fromkeys(notice for entry in entries for notice in entry.problem.notices)
    return Comparisons(tuple(entries), tuple(notices))


def _compare(model: Model, log: Log, theta: Array) -> Comparison:
    problem = fitted_problem(model, log)
    with settings_of(model):
        rows = wls_rows(problem)[0] if model.fit and model.fit.method in ("wls", "huber") else problem.rows
        residual = judge(problem, rows, theta)
    return Comparison(str(model.path), str(log.path), problem, theta, residual, overall(rows, theta))
