"""The verdict: what is missing and how surely, which rivals remain, or that nothing is missing, or nothing known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from chebid.critique.depends import Dependence
from chebid.critique.evidence import Evidence
from chebid.critique.found import Found
from chebid.effects.friction import Presliding
from chebid.effects.transmission import Backlash

Status = Literal["missing", "nothing_missing", "unknown", "bad_data"]

MARGIN = 12.0  # score beyond chance from which on an effect is believed
_MATTERS = 0.03  # share of the squared residual from which on an effect is more than the filter's doing
_SIMULATED = 2.0  # times the margin, for what accelerations near the band's edge or jerks at reversals can imitate
_MOSTLY = 0.75  # stability of what was found by simulating, to be believed at all
_RIVAL = 8.0  # a rival within this of the best cannot be told from it
_SHARE = 0.03  # of the best score: the same, for errors that are not noise
ALIKE = 24.0  # the same, for effects that are known to look alike
_SAME = 0.5  # of a rival's own gain that the best one takes away from it: they explain the same
_FIRM = 0.9  # stability of a sure verdict
_UNLIKE = 0.35  # of the score by which free functions of one variable outdo the best effect: it is not that effect
_FREE = 15.0  # and at least this
_MOST = 3  # alternatives
_HIGH, _LARGE = 1.5, 2.0  # error over noise floor: from which on silence is not sure; that wants an explanation
_NEARLY, _MUCH, _GROWN = 0.95, 0.85, 1.3  # of the error before: nearly all of it, much of it, a joint made worse
# just after a reversal the joint jerks as its drive winds up against dry friction, faster than any projection passes
_SERVO = frozenset({"distance since reversal"})


@dataclass(frozen=True)
class Verdict:
    """`best` and its rivals, best first; `changed`: parameters were held, and the effect is new since the fit.

    `smallest`: by joint the rms torque [N.m or N] from which on an effect would have been seen.
    """

    status: Status
    sure: bool
    best: Found | None
    alternatives: tuple[Found, ...]
    depends: Dependence | None
    smallest: dict[str, float]
    changed: bool = False


def believed(one: Found) -> bool:
    """Whether a candidate is more than chance, large enough to matter, and not refuted."""
    if one.refuted:
        return False
    if not one.effect.linear:
        gap = isinstance(one.effect, Backlash)  # its impacts ring beyond what is judged: their share says nothing
        return one.score > _SIMULATED * MARGIN and one.stability > _MOSTLY and (gap or one.share > _MATTERS)
    needed = MARGIN * (_SIMULATED if isinstance(one.effect, Presliding) else 1.0)
    return min(one.score, one.total) > needed and one.share > _MATTERS


def outdone(found: Sequence[Found], depends: Sequence[Dependence]) -> bool:
    """Whether free functions of one variable explain the error much better than the best effect."""
    telling, best = is_telling(depends), next(filter(believed, found), None)
    return best is not None and bool(telling) and _short(best.score, telling[0].score)


def is_telling(depends: Sequence[Dependence]) -> list[Dependence]:
    """Dependences that are more than chance, large enough to matter, and not the doing of the drive."""
    return [one for one in depends if one.variable not in _SERVO and one.score > MARGIN and one.share > _MATTERS]


def _short(score: float, free: float) -> bool:
    return free - score > max(_FREE, _UNLIKE * free)


def judge_verdict(
    evidence: Evidence,
    found: Sequence[Found],
    depends: Sequence[Dependence],
    threshold: float,
    pair: float,
    bad: bool,
) -> Verdict:
    """The verdict on ranked candidates and dependences; `pair`: score of the best candidate with another beside it."""
    smallest = detectable(evidence, threshold)
    telling = is_telling(depends)
    on = telling[0] if telling else None
    best = next(filter(believed, found), None)
    if bad:
        return Verdict("bad_data", False, best, (), on, smallest)
    if best is None:
        nearest = [one for one in found if one.score > MARGIN] if on else []
        return Verdict("unknown" if on else "nothing_missing", True, None, tuple(nearest[:_MOST]), on, smallest)
    if on is not None and _short(max(best.score, pair), on.score):
        return Verdict("unknown", True, None, tuple(found[:_MOST]), on, smallest)
    rivals = [other for other in found if other is not best and _is_rival(best, other)]
    sure = not rivals and best.stability >= _FIRM and (best.holdout or 0.0) > -_RIVAL
    return Verdict("missing", sure, best, tuple(rivals[:_MOST]), on, smallest)


def doubted(verdict: Verdict, before: Mapping[str, float | None]) -> Verdict:
    """The verdict in the light of the errors over the noise floor that there were, by joint.

    A best effect that leaves nearly all of a large error is not what is missing; one that leaves much of it, or makes
    another joint worse, is not sure; nor is silence beside an error well above the floor.
    """
    if verdict.status == "nothing_missing":
        return replace(verdict, sure=all(ratio is None or ratio < _HIGH for ratio in before.values()))
    if verdict.status != "missing" or verdict.best is None or not verdict.best.ratio_after:
        return verdict
    after = verdict.best.ratio_after
    pairs = [(b, a) for joint, b in before.items() if b is not None and (a := after[joint]) is not None]
    if any(b > _LARGE for b, _ in pairs) and all(a > _NEARLY * b for b, a in pairs):
        return replace(
            verdict, status="unknown", sure=False, best=None, alternatives=(verdict.best, *verdict.alternatives)[:_MOST]
        )
    worse = any(a > max(_LARGE, _GROWN * b) for b, a in pairs)
    idle = all(a > _MUCH * b for b, a in pairs) and any(a > _LARGE for _, a in pairs)
    return replace(verdict, sure=verdict.sure and not worse and not idle)


def _is_rival(best: Found, other: Found) -> bool:
    """Whether the other explains the same part of the error about as well."""
    alike = other.effect.name in best.effect.alike or best.effect.name in other.effect.alike
    tolerated = max(_RIVAL, _SHARE * best.total) * (ALIKE / _RIVAL if alike else 1.0)
    if other.total < best.total - tolerated or other.score <= 0:
        return False
    a, b = best.candidate.judged.basis, other.candidate.judged.basis
    shared = a.T @ b
    return float(np.sum(shared**2)) / b.shape[1] > _SAME or other.effect.joint == best.effect.joint


def detectable(evidence: Evidence, threshold: float) -> dict[str, float]:
    """By joint: rms torque [N.m or N] of an effect of one parameter that would have scored beyond the margin."""
    rows = evidence.rows
    needed = 2 * (MARGIN + max(threshold, 0.0) + np.log(len(rows.Y)) / 2)
    out = {}
    for j, name in enumerate(evidence.dynamics.joints):
        mine = rows.joint == j
        level = float(np.sqrt(np.mean(evidence.deviation[mine] ** 2)))
        out[name] = level * float(np.sqrt(needed / max(rows.noise[j].samples, 1)))
    return out
