"""From model files and logs to a diagnosis, an addition, a refinement, and to what a user keeps of them."""

import difflib
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from chebid.basis import Array
from chebid.critique import (
    Case,
    Held,
    Refinement,
    addable_kinds,
    held_covariance,
    label,
    message,
    on_floor,
    settle_hyper,
)
from chebid.critique.document import effect_document
from chebid.dynamics import make_dynamics
from chebid.effects import Effect
from chebid.effects.coupling import MotorCoupling
from chebid.errors import Notice, Place, UsageError
from chebid.estimators import Estimate, Problem, estimate
from chebid.log import Log, read_logs
from chebid.model import Model
from chebid.results import estimate_document, fitted_model, fitted_values, residual_document

_ALLOWANCE = 4.0  # times the covariance of a fit: what another motion may move beyond it without a change of the arm


def make_case(model: Model, paths: Sequence[Path], holdout: Sequence[Path]) -> Case:
    """A model on logs: on those of its fit its structure is in question, on others what has changed.

    A model without a fit is fitted on the logs first. Raises InputError for a fit of other parameters, UsageError for
    a hold-out that the model was fitted on.
    """
    logs, beside = _read(model, paths), _read(model, holdout)
    fitted_on = model.fit.seen if model.fit else frozenset()
    _refuse_seen(beside, fitted_on | {log.sha256 for log in logs})
    if model.fit is None:
        problem = Problem(model, tuple(logs))
        theta = estimate(problem, "poly").theta
        return Case(problem, theta, holdout=_beside(problem, beside))
    theta = fitted_values(model)
    own = all(log.sha256 in fitted_on for log in logs)
    problem = Problem(model, tuple(logs), used=model.fit.treatment)
    names = [p.name for p in make_dynamics(model).parameters]
    held = None if own else Held(theta, _ALLOWANCE * held_covariance(model, names))
    return Case(problem, theta, held=held, holdout=_beside(problem, beside))


def _beside(problem: Problem, logs: list[Log]) -> Problem | None:
    """The hold-out logs, treated like the others."""
    if not logs:
        return None
    return Problem(problem.model, tuple(logs), used=problem.treatment)


def _read(model: Model, paths: Sequence[Path]) -> list[Log]:
    return read_logs(paths, model.log, model.joints)


def _refuse_seen(logs: list[Log], seen: Set[str]) -> None:
    for log in logs:
        if log.sha256 in seen:
            hint = "hold out a log of another motion"
            raise UsageError("is fitted on, and cannot be held out", hint=hint, place=Place(str(log.path)))


@dataclass(frozen=True)
class Addition:
    """A model before and after effects were added: both fits on the logs, and both errors on the hold-out.

    All ratios are over the noise floor of the model after: what the effects explain was no noise.
    """

    model: Model
    problem: Problem
    effects: tuple[str, ...]
    before: Estimate
    after: Estimate
    holdout: dict[str, dict[str, Any]] | None
    notices: tuple[Notice, ...]

    def document(self, out: Path | None) -> dict[str, Any]:
        """The JSON document of `add`: that of `identify`, with the error before and on the hold-out."""
        before = {joint: residual_document(r) for joint, r in self.before.residual.items()}
        return estimate_document(self.after, out) | {
            "added": list(self.effects),
            "before": before,
            "holdout": self.holdout,
            "hyperparameters": self.problem.dynamics.hyperparameters(),
        }


def add_effects(model: Model, asked: Sequence[str], paths: Sequence[Path], holdout: Sequence[Path]) -> Addition:
    """Add effects (`name` or `name:joint`) to a model and fit it on logs, by the method of its fit or `poly`."""
    twice = next((name for i, name in enumerate(asked) if name in asked[:i]), None)
    if twice:
        raise UsageError(f"{twice} is given twice", hint="once is enough")
    kinds = [_asked(name, model) for name in asked]
    logs, beside = _read(model, paths), _read(model, holdout)
    _refuse_seen(beside, {log.sha256 for log in logs})
    start = Problem(model.model_copy(update={"fit": None}), tuple(logs))
    method = model.fit.method if model.fit else "poly"
    before = estimate(start, method)
    specs = settle_hyper(start, [pair for pairs in kinds for pair in pairs])
    grown = start.model.model_copy(update={"effects": (*start.model.effects, *specs)})
    problem = start.under(grown)
    after = estimate(problem, method)
    names = tuple(spec.effect if spec.joint is None else f"{spec.effect}:{spec.joint}" for spec in specs)
    before = replace(before, residual=on_floor(before.residual, after.residual))
    told = _held_out(start, problem, before.theta, after.theta, beside)
    notices = tuple(dict.fromkeys(after.notices))
    return Addition(grown, problem, names, before, after, told, notices)


def _held_out(
    start: Problem, problem: Problem, before: Array, after: Array, logs: list[Log]
) -> dict[str, dict[str, Any]] | None:
    """Error on the hold-out, by joint, under the first model and under the last."""
    from chebid.estimators import judge

    other = _beside(start, logs)
    if other is None:
        return None
    first = judge(other, other.rows, start.dynamics.elsewhere(before))
    more = other.under(problem.model, problem.dynamics)
    last = judge(more, more.rows, problem.dynamics.elsewhere(after))
    first = on_floor(first, last)
    return {
        joint: {"before": residual_document(first[joint]), "after": residual_document(last[joint])} for joint in first
    }


def _asked(name: str, model: Model) -> list[tuple[type[Effect], int | None]]:
    """Kind and joint of `name` or `name:joint`; without a joint, every joint. Raises UsageError."""
    word, _, joint = name.partition(":")
    kinds, _ = addable_kinds()
    if word not in kinds:
        near = difflib.get_close_matches(word.lower(), kinds, 1)
        hint = f"did you mean {near[0]}?" if near else f"choose one of: {', '.join(sorted(kinds))}"
        raise UsageError(f"unknown effect {word!r}", hint=hint)
    kind = kinds[word]
    if kind.whole_arm:
        if joint:
            raise UsageError(f"{word} concerns the whole arm, not one joint", hint=f"write {word}")
        return [(kind, None)]
    if joint and joint not in model.joints:
        raise UsageError(f"{name!r}: there is no joint {joint!r}", hint=f"choose one of: {', '.join(model.joints)}")
    if issubclass(kind, MotorCoupling) and not joint:
        raise UsageError(
            f"{word} is of one pair of joints", hint=f"name one of them, such as {word}:{model.joints[-1]}"
        )
    joints = [model.joints.index(joint)] if joint else range(len(model.joints))
    present = {(spec.effect, j) for spec in model.effects for j in ([spec.joint] if spec.joint else model.joints)}
    for j in joints:
        if (word, model.joints[j]) in present:
            raise UsageError(f"the model has {word} on {model.joints[j]} already", hint="nothing to add there")
    return [(kind, j) for j in joints]


def refinement_problems(
    model: Model, paths: Sequence[Path], holdout: Sequence[Path]
) -> tuple[Problem, Problem | None, str]:
    """Logs and hold-out of a refinement, and its method: that of the model's fit, or `poly`."""
    logs, beside = _read(model, paths), _read(model, holdout)
    _refuse_seen(beside, {log.sha256 for log in logs})
    method = model.fit.method if model.fit else "poly"
    problem = Problem(model.model_copy(update={"fit": None}), tuple(logs))
    return problem, _beside(problem, beside), method


def refined_model(refinement: Refinement, out: Path) -> Model:
    """The last model with its fit; every step and every rejected hypothesis stands in `fit.record`."""
    made = fitted_model(refinement.model, refinement.last.estimate, out)
    assert made.fit is not None, "it was just fitted"
    joints = made.joints
    steps = [
        {
            "added": label(step.effect, joints) if step.effect else None,
            "ratio": {joint: r.ratio for joint, r in step.estimate.residual.items()},
            "holdout_ratio": step.diagnosis.holdout_ratio,
            "verdict": message(step.diagnosis),
            "rejected": [
                {**effect_document(one.effect, joints), "score": round(one.score, 1)}
                for one in step.diagnosis.found[1:6]
            ],
        }
        for step in refinement.steps
    ]
    dropped = [label(effect, joints) for effect in refinement.dropped]
    record = type(made.fit.record).model_validate(
        made.fit.record.model_dump(exclude_none=True) | {"refinement": {"steps": steps, "dropped": dropped}}
    )
    return made.with_fit(made.fit.model_copy(update={"record": record}))
