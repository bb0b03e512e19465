"""Candidates: every effect of the library on every joint, scored against chance.

    score = sum over joints of (R_j / 2) ln(RSS before / RSS after) - ((m + h) / 2) ln R - threshold

m columns, h hyper-parameters, R rows, R_j of joint j: half the Bayesian information criterion (Schwarz, Ann. Stat. 6,
1978). The threshold is what the best of all candidates reaches on white noise in `_CHANCE` of the cases, drawn on these
very rows: a positive score is more than the luckiest of so many candidates.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.optimize

from chebid.basis import Array
from chebid.critique import transmission
from chebid.critique.evidence import Evidence, Judged
from chebid.effects import Effect
from chebid.effects.channel import TorqueDelay
from chebid.errors import UsageError

_CHANCE = 0.98
_DRAWS = 200
_REFINED = 10  # candidates whose hyper-parameters are refined between the values of the grid
_EVALUATIONS = 40


@dataclass(frozen=True)
class Candidate:
    """One effect on one joint, at its best setting. `settings`: how many were tried."""

    judged: Judged
    settings: int
    score: float

    @property
    def effect(self) -> Effect:
        return self.judged.effect

    @property
    def key(self) -> tuple[str, int | None]:
        """Name and joint."""
        return self.effect.name, self.effect.joint


@dataclass(frozen=True)
class Ranking:
    """All candidates, best first. `threshold`: what the luckiest of them reaches on noise, taken off every score."""

    candidates: tuple[Candidate, ...]
    threshold: float


def rank(evidence: Evidence, kinds: Mapping[str, type[Effect]], *, present: bool = False, seed: int = 0) -> Ranking:
    """Every effect of `kinds` on every joint; those that the model has only if `present` ones can have changed."""
    families = [[evidence.judge(effect) for effect in settings] for settings in _families(evidence, kinds, present)]
    families += transmission.families(evidence, kinds, range(len(evidence.dynamics.joints)))
    families = [family for family in families if any(j.basis.shape[1] for j in family)]
    threshold = _threshold(evidence, families, seed)
    found = sorted((_best(evidence, family, threshold) for family in families), key=lambda c: -c.score)
    refined = [refined_candidate(evidence, candidate) for candidate in found[:_REFINED]]
    ranked = sorted([*refined, *found[_REFINED:]], key=lambda c: -c.score)
    best = {_form(candidate): candidate for candidate in reversed(ranked)}
    return Ranking(tuple(c for c in ranked if best[_form(c)] is c), threshold)


def _form(candidate: Candidate) -> tuple[str, int | None, bool]:
    """Of each effect its best form is kept; of what was simulated those on all equations and on the slow ones."""
    effect = candidate.effect
    return *candidate.key, isinstance(effect, transmission.Hanging) and effect.slow


def _families(evidence: Evidence, kinds: Mapping[str, type[Effect]], present: bool) -> Iterator[list[Effect]]:
    """Settings worth trying of every effect on every joint; forms with other hyper-parameters apart."""
    joints = range(len(evidence.dynamics.joints))
    for name, kind in kinds.items():
        if not kind.linear or (evidence.brief and kind is TorqueDelay):
            continue  # simulated; or a delay of logging, which is allowed for
        for joint in [None] if kind.whole_arm else joints:
            if present or (name, joint) not in evidence.present:
                settings = kind.candidates(evidence.trusted, joint, float(evidence.ground.gate[joint or 0]))
                yield from _forms(settings)


def _forms(settings: Iterable[Effect]) -> Iterable[list[Effect]]:
    """Settings of an effect by the hyper-parameters that they give: a linear spring, and springs that soften."""
    forms: dict[tuple[str, ...], list[Effect]] = {}
    for effect in settings:
        given = tuple(name for name, value in effect.hyper.items() if value is not None)
        forms.setdefault(given, []).append(effect)
    return forms.values()


def best_setting(evidence: Evidence, kind: type[Effect], joint: int | None) -> Effect:
    """The effect of one kind on one joint, its form and hyper-parameters those that explain the logs best.

    Raises UsageError for an effect that has nothing to act on.
    """
    families = [] if joint is None else list(transmission.families(evidence, {kind.name}, [joint]))
    if not families:
        settings = kind.candidates(evidence.trusted, joint, float(evidence.ground.gate[joint or 0]))
        families = [[evidence.judge(effect) for effect in form] for form in _forms(settings)]
    found = [refined_candidate(evidence, _best(evidence, family, 0.0)) for family in families]
    if not found:
        on = "" if joint is None else f" of {evidence.dynamics.joints[joint]}"
        raise UsageError(
            f"{kind.name}{on} has nothing to act on", hint="a coupling needs a second joint; saturation, a torque"
        )
    return max(found, key=lambda c: c.score).effect


def penalty(evidence: Evidence, judged: Judged, settings: int = 1) -> float:
    """What a candidate has to gain before it is worth its columns and its hyper-parameters."""
    price = np.log(len(evidence.rows.Y)) / 2
    effect = judged.effect
    moved = sum(kind.continuous and effect.hyper[name] is not None for name, kind in effect.hypers().items())
    return float(judged.basis.shape[1] * price + max(moved * price, np.log(settings)))


def _best(evidence: Evidence, family: list[Judged], threshold: float) -> Candidate:
    best = max(family, key=lambda j: j.gain - 2 * penalty(evidence, j))
    score = evidence.worth(best.basis) - penalty(evidence, best, len(family)) - threshold
    return Candidate(best, len(family), score)


def _threshold(evidence: Evidence, families: list[list[Judged]], seed: int) -> float:
    """Score (before threshold) that the best candidate exceeds on white noise in one of 1 / (1 - chance) draws."""
    noise = np.random.default_rng(seed).standard_normal((len(evidence.residual), _DRAWS))
    best = np.zeros(_DRAWS)
    for family in families:
        for judged in family:
            gain = np.sum((judged.basis.T @ noise) ** 2, axis=0)
            best = np.maximum(best, gain / 2 - penalty(evidence, judged, len(family)))
    return float(np.quantile(best, _CHANCE))


def refined_candidate(evidence: Evidence, candidate: Candidate) -> Candidate:
    """The candidate with its continuous hyper-parameters moved to where the gain is largest."""
    effect = candidate.effect
    if isinstance(effect, transmission.Hanging):
        best = transmission.refined_hang(evidence, candidate.judged)
        more = evidence.worth(best.basis) - evidence.worth(candidate.judged.basis)
        return replace(candidate, judged=best, score=candidate.score + more)
    bounds = type(effect).refinable(evidence.trusted, effect.joint, float(evidence.ground.gate[effect.joint or 0]))
    bounds = {name: limits for name, limits in bounds.items() if effect.hyper.get(name) is not None}
    if not bounds:
        return candidate
    names, low, high = list(bounds), *np.array(list(bounds.values())).T
    start = np.clip([effect.hyper[name] for name in names], low, high)
    best = candidate.judged

    def loss(unit: Array) -> float:
        nonlocal best
        values = np.clip(low + unit * (high - low), low, high)
        moved: dict[str, Any] = dict(zip(names, map(float, values), strict=True))
        judged = evidence.judge(replace(effect, **moved))
        best = max(best, judged, key=lambda j: j.gain)
        return -judged.gain

    unit = (start - low) / (high - low)
    simplex = np.vstack([unit, *(np.where(np.arange(len(unit)) == i, _away(unit), unit) for i in range(len(unit)))])
    scipy.optimize.minimize(
        loss, unit, method="Nelder-Mead", options={"initial_simplex": simplex, "maxfev": _EVALUATIONS, "xatol": 1e-3}
    )
    return replace(
        candidate,
        judged=best,
        score=candidate.score + evidence.worth(best.basis) - evidence.worth(candidate.judged.basis),
    )


def _away(unit: Array) -> Array:
    """A step of a twentieth of the range, inward."""
    return np.where(unit > 0.5, unit - 0.05, unit + 0.05)
