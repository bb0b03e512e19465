"""`diagnose`: from a fitted model and logs to a verdict, with everything that led to it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chebid.basis import Array
from chebid.critique.calm import without_jerk, withstood
from chebid.critique.candidates import penalty, rank
from chebid.critique.depends import Dependence, dependences
from chebid.critique.evidence import Evidence, Ground, Held
from chebid.critique.found import Found, Side, Sides, compare
from chebid.critique.verdict import MARGIN, Verdict, believed, is_telling, judge_verdict, outdone
from chebid.critique.where import Cell, where
from chebid.effects import Effect
from chebid.errors import Notice, Place
from chebid.estimators.judge import judge, noise_floor
from chebid.estimators.problem import Problem
from chebid.estimators.result import JointResidual

_TOLD, _LESS = 1.5, 0.8  # error over noise floor, and share of it that a short lag leaves: then the lag is told
_FAILS = 3.0  # error over noise floor on a hold-out, and times that on the fitted logs: these cannot show why
_ELSEWHERE = 0.4, 4.0  # relative error on a hold-out, and times that of the fit: it is not of this robot
_BAD = frozenset({"swapped", "degrees", "duplicate"})  # notices about a log that cannot be trusted at all
_WRONG = 0.8  # relative error of every joint from which on the model is not that of this log at all


@dataclass(frozen=True)
class Diagnosis:
    """What `diagnose` found. `changed`: the parameters were held, the logs being others than those of the fit."""

    problem: Problem
    theta: Array
    evidence: Evidence
    residual: dict[str, JointResidual]
    holdout: dict[str, JointResidual] | None
    cells: tuple[Cell, ...]
    depends: tuple[Dependence, ...]
    found: tuple[Found, ...]
    verdict: Verdict
    notices: tuple[Notice, ...]

    @property
    def holdout_ratio(self) -> dict[str, float | None] | None:
        """rms / noise floor of the model as it is on the hold-out."""
        return None if self.holdout is None else _ratios(self.holdout)


@dataclass(frozen=True)
class Case:
    """A fitted model on logs: theta (P,) its parameters, `held` what is known of them if the logs are others."""

    problem: Problem
    theta: Array
    held: Held | None = None
    holdout: Problem | None = None
    floor: Array | None = None


def diagnose(case: Case, kinds: Mapping[str, type[Effect]], seed: int = 0) -> Diagnosis:
    """Where the model fails, on what the error depends, and which effect explains it."""
    ground = Ground(case.problem)
    held_out = Ground(case.holdout) if case.holdout else None
    return examine(case, ground, held_out, kinds, seed)


def examine(
    case: Case, ground: Ground, held_out: Ground | None, kinds: Mapping[str, type[Effect]], seed: int = 0
) -> Diagnosis:
    """`diagnose`, with the tracks and test functions of the logs made already."""
    problem = case.problem
    evidence = Evidence(ground, problem.dynamics, case.held)
    beside = Evidence(held_out, problem.dynamics, elsewhere=True) if held_out else None
    ranking = rank(evidence, kinds, present=case.held is not None, seed=seed)
    residual = judge(problem, problem.rows, case.theta)
    elsewhere = problem.dynamics.elsewhere(case.theta)
    beside_error = judge(case.holdout, case.holdout.rows, elsewhere) if case.holdout else None
    sides = Sides(case.theta, Side(problem, _floor(residual)), _holdout_side(case), case.held is not None)
    found = compare(evidence, ranking.candidates, beside, sides, seed)
    depends = dependences(evidence, seed)
    if any(map(believed, found)) or is_telling(depends):
        calm = Evidence(ground, problem.dynamics, case.held, calm=True)
        found = [withstood(one, evidence, calm, ranking.threshold) for one in found]
        found = [*filter(lambda f: not f.refuted, found), *filter(lambda f: f.refuted, found)]
        depends = without_jerk(depends, dependences(calm, seed)) if is_telling(depends) else depends
    bad = _is_bad(problem, residual)
    pair = _with_another(evidence, found, kinds, seed) if outdone(found, depends) and case.held is None else 0.0
    before = _ratios(residual)
    there = None if beside_error is None else _ratios(beside_error)
    verdict = judge_verdict(evidence, found, depends, ranking.threshold, pair, before, bad, there)
    # what a person reads from the top: what was named, other evidence, what was refuted, what chance explains
    found = sorted(found, key=lambda f: (f is not verdict.best, f.score <= 0, f.refuted))
    if verdict.status == "nothing_missing" and beside_error is not None and failing(residual, beside_error):
        verdict = replace(verdict, sure=False)
    lag = _brief_lag(evidence, before)
    if lag and verdict.status == "missing":
        verdict = replace(verdict, sure=False)  # the lag first: what it leaves may be nothing
    if case.held is not None and verdict.best is not None:
        verdict = replace(verdict, changed=not _structural(verdict.best.effect, evidence, ranking.threshold))
    return Diagnosis(
        problem=problem,
        theta=case.theta,
        evidence=evidence,
        residual=residual,
        holdout=beside_error,
        cells=tuple(where(evidence, case.theta, list(before.values()))),
        depends=tuple(d for d in depends if d.score > 0),
        found=tuple(found),
        verdict=verdict,
        notices=(*problem.notices, *lag, *_strange(case.holdout, residual, beside_error)),
    )


def _ratios(residual: Mapping[str, JointResidual]) -> dict[str, float | None]:
    return {joint: r.ratio for joint, r in residual.items()}


def _with_another(evidence: Evidence, found: list[Found], kinds: Mapping[str, type[Effect]], seed: int) -> float:
    """Score of the best candidate together with the best one beside it."""
    best = next(filter(believed, found))
    effect = best.effect
    dynamics = evidence.dynamics
    more = replace(dynamics, effects=(*dynamics.effects, effect), reference=dynamics.named(evidence.theta))
    second = rank(Evidence(evidence.ground, more), kinds, seed=seed).candidates[0]
    return best.score + max(second.score, 0.0)


def _structural(effect: Effect, held: Evidence, threshold: float) -> bool:
    """Whether an effect is missing whatever the parameters are, and not only new since they were fitted."""
    if (effect.name, effect.joint) in held.present:
        return False
    free = Evidence(held.ground, held.dynamics)
    judged = free.judge(effect)
    return free.worth(judged.basis) - penalty(free, judged) - threshold > MARGIN


def _brief_lag(evidence: Evidence, before: Mapping[str, float | None]) -> list[Notice]:
    """A lag of the torque that is too short to be called an effect, where it makes much of an error."""
    high = {joint: ratio for joint, ratio in before.items() if ratio is not None and ratio > _TOLD}
    lag = evidence.lag
    if not high or lag is None or not evidence.brief:
        return []
    left = evidence.left_beside(evidence.late)
    parts = [
        f"{joint} {ratio:.2f} to {ratio * left[joint]:.2f}" for joint, ratio in high.items() if left[joint] < _LESS
    ]
    if not parts:
        return []
    problem = evidence.ground.problem
    message = (
        f"the torque {'lags' if lag > 0 else 'leads'} the positions by {1e3 * abs(lag):.2g} ms, no longer than "
        f"logging can make it; log: torque_delay: {problem.model.log.torque_delay + lag:.2g} in the model file "
        f"brings error / noise floor from {', '.join(parts)}"
    )
    return [Notice("torque_lag", message, Place(file=str(problem.logs[0].path)))]


def _strange(
    holdout: Problem | None, fitted: Mapping[str, JointResidual], beside: Mapping[str, JointResidual] | None
) -> list[Notice]:
    """What the hold-out says: the warnings of its logs, that it looks like another robot's, or that the model fails."""
    if holdout is None or beside is None:
        return []
    far = [j for j, r in beside.items() if r.relative > max(_ELSEWHERE[0], _ELSEWHERE[1] * fitted[j].relative)]
    parts = ", ".join(f"{joint} {100 * beside[joint].relative:.0f} %" for joint in far)
    message = f"the model explains little of this hold-out (relative error {parts}): of another robot, or another unit?"
    place = Place(file=", ".join(str(log.path) for log in holdout.logs))
    if far:
        return [*holdout.notices, Notice("holdout", message, place)]
    fails = [f"{j} {beside[j].ratio:.2f}, {fitted[j].ratio:.2f} on the fitted logs" for j in failing(fitted, beside)]
    message = (
        f"the model fails on this hold-out (error / noise floor {'; '.join(fails)}), whose motion shows what that of "
        "the fitted logs does not: diagnose the hold-out itself, or identify from both"
    )
    return [*holdout.notices, *([Notice("holdout", message, place)] if fails else [])]


def failing(fitted: Mapping[str, JointResidual], beside: Mapping[str, JointResidual]) -> list[str]:
    """Joints whose error stands far above the noise on a hold-out, and not on the fitted logs."""
    return [
        joint
        for joint, r in beside.items()
        if r.ratio is not None and r.ratio > _FAILS * max(1.0, fitted[joint].ratio or 1.0)
    ]


def _floor(residual: Mapping[str, JointResidual]) -> Array | None:
    floors = [r.floor for r in residual.values()]
    return None if any(f is None for f in floors) else np.array(floors, dtype=float)


def _holdout_side(case: Case) -> Side | None:
    if case.holdout is None:
        return None
    theta = case.problem.dynamics.elsewhere(case.theta)
    _, floor = noise_floor(case.holdout, theta, float(case.holdout.rows.frequency.max()))
    return Side(case.holdout, floor)


def _is_bad(problem: Problem, residual: Mapping[str, JointResidual]) -> bool:
    """Whether the log cannot be what the model is about."""
    kinds = {notice.kind for log in problem.logs for notice in log.notices}
    return bool(kinds & _BAD) or all(r.relative > _WRONG for r in residual.values())
