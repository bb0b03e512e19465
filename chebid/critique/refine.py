"""`refine`: diagnose and add, until nothing is missing or nothing known explains what is left.

After every addition the hyper-parameters of all added effects are moved again, an earlier effect that another explains
better is replaced, and one that is no longer needed is dropped - unless the error grows by it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chebid.basis import Array
from chebid.critique.candidates import Candidate, best_setting, penalty, rank, refined_candidate
from chebid.critique.diagnosis import Case, Diagnosis, examine
from chebid.critique.evidence import Evidence, Ground
from chebid.critique.kinds import Clipped
from chebid.critique.verdict import MARGIN, Verdict
from chebid.effects import Effect, specify
from chebid.errors import InputError, NoAnswerError
from chebid.estimators import Estimate, JointResidual, estimate
from chebid.estimators.problem import Problem
from chebid.model import EffectSpec, Model

_MOST = 6  # effects added
_BETTER = 8.0  # score by which another effect must be better, to take the place of one that was added
_GROWS = 1.05  # times the errors of all joints, multiplied: an exchange that raises them further is none
Kinds = Mapping[str, type[Effect]]


@dataclass(frozen=True)
class Added:
    """An effect that was added, and the verdict that called for it."""

    effect: Effect
    verdict: Verdict


@dataclass(frozen=True)
class Step:
    """One model of the ladder: `effect` was added last (None: the first model); its fit and its diagnosis."""

    effect: Effect | None
    estimate: Estimate
    diagnosis: Diagnosis


@dataclass(frozen=True)
class Refinement:
    """The ladder from the first model to the last, what stands in the last, and what was dropped again."""

    model: Model
    steps: tuple[Step, ...]
    added: tuple[Added, ...]
    dropped: tuple[Effect, ...]

    @property
    def last(self) -> Step:
        return self.steps[-1]


class _Ladder:
    """The logs, and the models tried on them."""

    def __init__(self, problem: Problem, holdout: Problem | None, kinds: Kinds, method: str, seed: int) -> None:
        self.start, self.holdout, self.kinds, self.method, self.seed = problem, holdout, kinds, method, seed
        self.ground = Ground(problem)
        self.beside = Ground(holdout) if holdout else None

    def model(self, effects: list[Effect]) -> Model:
        first = self.start.model
        specs = [*first.effects, *(specify(effect, first.joints) for effect in effects)]
        return first.model_copy(update={"effects": tuple(specs), "fit": None})

    def step(self, effects: list[Effect], last: Effect | None) -> Step:
        """Fit the model with these effects, and diagnose it."""
        problem = self.start.under(self.model(effects))
        holdout = self.holdout.under(problem.model, problem.dynamics) if self.holdout else None
        found = estimate(problem, self.method)
        case = Case(problem, found.theta, holdout=holdout)
        ground = self._ground(problem, effects)
        return Step(last, found, examine(case, ground, self.beside, self.kinds, self.seed))

    def evidence(self, effects: list[Effect]) -> Evidence:
        """The logs under the model with these effects."""
        problem = self.start.under(self.model(effects))
        return Evidence(self._ground(problem, effects), problem.dynamics)

    def _ground(self, problem: Problem, effects: list[Effect]) -> Ground:
        """That of the first model, unless the effects leave samples out."""
        return Ground(problem) if any(isinstance(effect, Clipped) for effect in effects) else self.ground

    def revise(self, before: list[Effect], new: Effect) -> tuple[list[Effect], list[Effect]]:
        """Effects moved, replaced or dropped until each is the best in its place; and those dropped.

        The new one stays: the verdict, which knows the hold-out, too, has called for it.
        """
        effects, dropped = [*before, new], list[Effect]()
        if not before:
            return effects, dropped
        for effect in list(effects):
            place = effects.index(effect)
            others = [other for other in effects if other is not effect]
            evidence = self.evidence(others)
            best = self._best(evidence, effect, stays=effect is new)
            effects = others if best is None else [*others[:place], best, *others[place:]]
            if best is None or (best.name, best.joint) != (effect.name, effect.joint):
                dropped.append(effect)
        if dropped and self._error(effects) > _GROWS * self._error([*before, new]):
            return [*before, new], []
        return effects, dropped

    def _error(self, effects: list[Effect]) -> float:
        """Product of the joints' rms; infinite where the logs cannot give the parameters."""
        try:
            found = estimate(self.start.under(self.model(effects)), self.method)
        except (NoAnswerError, InputError):
            return np.inf
        return float(np.prod([r.rms for r in found.residual.values()]))

    def _best(self, evidence: Evidence, effect: Effect, stays: bool) -> Effect | None:
        """What should stand in the place of an effect, given the others: itself, a better one, or nothing."""
        judged = evidence.judge(effect)
        if stays:
            return refined_candidate(evidence, Candidate(judged, 1, 0.0)).effect
        ranking = rank(evidence, self.kinds, seed=self.seed)
        start = evidence.worth(judged.basis) - penalty(evidence, judged) - ranking.threshold
        own = refined_candidate(evidence, Candidate(judged, 1, start))
        best = ranking.candidates[0]
        if best.key != own.key and best.score > own.score + _BETTER:
            return best.effect
        return own.effect if own.score > MARGIN else None


def refine(
    problem: Problem,
    kinds: Kinds,
    *,
    holdout: Problem | None = None,
    method: str = "poly",
    seed: int = 0,
    progress: Callable[[Step], None] = lambda _: None,
) -> Refinement:
    """Add effects to the model of a problem for as long as one is missing."""
    ladder = _Ladder(problem, holdout, kinds, method, seed)
    effects: list[Effect] = []
    verdicts: dict[tuple[str, int | None], Verdict] = {}
    dropped: list[Effect] = []
    steps = [ladder.step(effects, None)]
    progress(steps[-1])
    while len(effects) < _MOST:
        verdict = steps[-1].diagnosis.verdict
        if verdict.status != "missing" or verdict.best is None:
            break
        new = verdict.best.effect
        if any((gone.name, gone.joint) == (new.name, new.joint) for gone in dropped):
            break
        verdicts[new.name, new.joint] = verdict
        try:
            revised, gone = ladder.revise(effects, new)
            step = ladder.step(revised, revised[-1])
        except (NoAnswerError, InputError):
            break  # it explains the logs, but they cannot give its parameters beside all others
        effects, dropped = revised, dropped + gone
        steps.append(step)
        progress(steps[-1])
    first = steps[0].diagnosis.verdict
    added = tuple(Added(effect, verdicts.get((effect.name, effect.joint), first)) for effect in effects)
    return Refinement(ladder.model(effects), tuple(_one_floor(steps)), added, tuple(dropped))


def _one_floor(steps: list[Step]) -> list[Step]:
    """The steps, all measured against the noise floor of the last: what an effect leaves is no noise."""
    last = steps[-1]
    floors = last.estimate.residual, last.diagnosis.holdout
    out = []
    for step in steps:
        fitted = replace(step.estimate, residual=on_floor(step.estimate.residual, floors[0]))
        beside = step.diagnosis.holdout
        told = beside if beside is None or floors[1] is None else on_floor(beside, floors[1])
        diagnosis = replace(step.diagnosis, residual=on_floor(step.diagnosis.residual, floors[0]), holdout=told)
        out.append(Step(step.effect, fitted, diagnosis))
    return out


def on_floor(residual: Mapping[str, JointResidual], last: Mapping[str, JointResidual]) -> dict[str, JointResidual]:
    """Errors against the noise floor of another model of the same logs."""
    return {
        joint: replace(r, floor=last[joint].floor, floor_kind=last[joint].floor_kind) for joint, r in residual.items()
    }


def settle_hyper(problem: Problem, asked: list[tuple[type[Effect], int | None]]) -> list[EffectSpec]:
    """Entries for effects of given kinds and joints, their hyper-parameters found on the logs, one after the other."""
    ground = Ground(problem)
    specs: list[EffectSpec] = []
    for kind, joint in asked:
        model = problem.model.model_copy(update={"effects": (*problem.model.effects, *specs), "fit": None})
        evidence = Evidence(ground, problem.under(model).dynamics)
        specs.append(specify(best_setting(evidence, kind, joint), problem.model.joints))
    return specs


def held_covariance(model: Model, names: list[str]) -> Array:
    """Covariance (P, P) of a fitted model in the order of names."""
    assert model.fit is not None, "a fitted model"
    kept = model.fit.covariance
    if kept is not None:
        at = [kept.parameters.index(name) for name in names]
        return np.array(kept.matrix)[np.ix_(at, at)]
    return np.diag([max(model.fit.parameters[name].sd or 0.0, 1e-12) ** 2 for name in names])
