"""The verdict: what is missing and how surely, which rivals remain, or that nothing is missing, or nothing known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from chebid.basis import Array
from chebid.critique.depends import Dependence
from chebid.critique.evidence import Evidence
from chebid.critique.found import Found
from chebid.effects.friction import Presliding
from chebid.effects.transmission import Backlash

Status = Literal["missing", "nothing_missing", "unknown", "bad_data"]

MARGIN = 12.0  # score beyond chance from which on an effect is believed
_MATTERS = 0.03  # share of the squared residual from which on an effect is more than the filter's doing
_SIMULATED = 2.0  # times the margin, for what accelerations near the band's edge or jerks at reversals can imitate
_BRISTLES = 4.0  # the same, for what jerks at reversals imitate best; and twice that to be sure
_MOSTLY = 0.75  # stability of what was found by simulating, to be believed at all
_OFTEN = 0.5  # the same where a hold-out agrees
_RIVAL = 8.0  # a rival within this of the best cannot be told from it
_SHARE = 0.03  # of the best score: the same, for errors that are not noise
ALIKE = 24.0  # the same, for effects that are known to look alike
_SAME = 0.5  # of a rival's own gain that the best one takes away from it: they explain the same
_FIRM = 0.9  # stability of a sure verdict
_UNLIKE = 0.35  # of the score by which free functions of one variable outdo the best effect: it is not that effect
_FREE = 15.0  # and at least this
_MOST = 3  # alternatives
_HIGH, _LARGE = 1.5, 2.0  # error over noise floor: from which on silence is not sure; that wants an explanation
_BLATANT = 3.0  # error over noise floor that no coloured noise makes: something is missing
_NEARLY, _MUCH, _GROWN = 0.95, 0.85, 1.3  # of the error before: nearly all of it, much of it, a joint made worse
_HALF = 0.5  # of the error before: what leaves less is not outdone by a function that explains no torque
# just after a reversal the joint jerks as its drive winds up against dry friction, faster than any projection passes:
# that makes up to a quarter of a squared residual with nothing missing
_SERVO, _MOST_OF_IT = frozenset({"distance since reversal"}), 0.4


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
        firm = one.stability > (_MOSTLY if (one.holdout or 0.0) <= 0 else _OFTEN) or (one.holdout or 0.0) > MARGIN
        enough = min(one.score, one.total) > _SIMULATED * MARGIN
        return enough and firm and (gap or one.share > _MATTERS)
    needed = MARGIN * (_BRISTLES if isinstance(one.effect, Presliding) else 1.0)
    return min(one.score, one.total) > needed and one.share > _MATTERS


def outdone(found: Sequence[Found], depends: Sequence[Dependence]) -> bool:
    """Whether free functions of one variable explain the error much better than the best effect."""
    telling, best = is_telling(depends), next(filter(believed, found), None)
    return best is not None and bool(telling) and _short(best.score, telling[0].score)


def is_telling(depends: Sequence[Dependence]) -> list[Dependence]:
    """Dependences that are more than chance, large enough to matter, and not the doing of the drive."""
    return [one for one in depends if one.score > MARGIN and one.share > _least_share(one)]


def _least_share(one: Dependence) -> float:
    return _MOST_OF_IT if one.variable in _SERVO else _MATTERS


def _short(score: float, free: float) -> bool:
    return free - score > max(_FREE, _UNLIKE * free)


def judge_verdict(
    evidence: Evidence,
    found: Sequence[Found],
    depends: Sequence[Dependence],
    threshold: float,
    pair: float,
    before: Mapping[str, float | None],
    bad: bool,
    elsewhere: Mapping[str, float | None] | None = None,
) -> Verdict:
    """The verdict on ranked candidates and dependences.

    `pair`: score of the best candidate with another beside it; `before`: error over the noise floor, by joint. A
    candidate that leaves nearly all of a large error is not what is missing; silence beside one is not sure.
    `elsewhere`: the same on the hold-out; what halves every large error there is not outdone by a free function.
    """
    smallest = detectable(evidence, threshold)
    telling = is_telling(depends)
    on = telling[0] if telling else None
    strong = list(filter(believed, found))
    best = next((one for one in strong if not _idle(one, before)), None)
    if bad:
        return Verdict("bad_data", False, best, (), on, smallest)
    if not strong:
        nearest = [one for one in found if one.score > MARGIN] if on else []
        errors = {joint: ratio for joint, ratio in before.items() if ratio is not None}
        blatant = max(errors.values(), default=0.0) > _BLATANT and _unexcused(evidence, errors) > _BLATANT
        sure = on is not None or all(ratio < _HIGH for ratio in errors.values())
        status: Status = "unknown" if on or blatant else "nothing_missing"
        return Verdict(status, sure, None, tuple(nearest[:_MOST]), on, smallest)
    first = best or strong[0]
    alone = any(
        whole > MARGIN and one.share > _MATTERS and _short(first.score, whole)
        for one in depends
        if (whole := one.score + one.excused)
    )
    predicts = elsewhere is not None and _halves(first.holdout_ratio_after, elsewhere)
    # by none of those believed: two effects hide each other, and the first to be named is not the one that scores most
    short = on is not None and _short(max(pair, *(one.score for one in strong)), on.score)
    if short and not predicts and not _halves(first.ratio_after, before):
        return Verdict("unknown", True, None, tuple(found[:_MOST]), on, smallest)
    rivals = [other for other in found if other is not first and _is_rival(first, other, evidence.residual)]
    if best is None:
        return Verdict("unknown", False, None, (first, *rivals)[:_MOST], on, smallest)
    sure = best is strong[0] and not alone and not rivals and _is_firm(best) and not _doubtful(best, before)
    return Verdict("missing", sure, best, tuple(rivals[:_MOST]), on, smallest)


def _is_firm(one: Found) -> bool:
    """Whether a candidate comes first however the logs are weighted, and the hold-out does not speak against it."""
    enough = 2 * _BRISTLES * MARGIN if isinstance(one.effect, Presliding) else 0.0
    return one.score > enough and one.stability >= _FIRM and (one.holdout or 0.0) > -_RIVAL


def _unexcused(evidence: Evidence, errors: Mapping[str, float]) -> float:
    """The largest error over the noise floor beside what is no fault of the model."""
    left = evidence.left_beside(evidence.nuisance)
    return max(ratio * left[joint] for joint, ratio in errors.items())


def _idle(one: Found, before: Mapping[str, float | None]) -> bool:
    """Whether a candidate leaves nearly all of a large error."""
    pairs = _errors(one, before)
    return any(b > _LARGE for b, _ in pairs) and all(a > _NEARLY * b for b, a in pairs)


def _halves(after: Mapping[str, float | None] | None, before: Mapping[str, float | None]) -> bool:
    """Whether half of every large error is taken away, and there is one."""
    large = [(b, a) for b, a in _pairs(after, before) if b > _LARGE]
    return bool(large) and all(a < _HALF * b for b, a in large)


def _doubtful(one: Found, before: Mapping[str, float | None]) -> bool:
    """Whether a candidate leaves much of a large error, or makes another joint worse."""
    pairs = _errors(one, before)
    worse = any(a > max(_LARGE, _GROWN * b) for b, a in pairs)
    return worse or (all(a > _MUCH * b for b, a in pairs) and any(a > _LARGE for _, a in pairs))


def _errors(one: Found, before: Mapping[str, float | None]) -> list[tuple[float, float]]:
    """Error over the noise floor of every joint, without the candidate and with it, where both are known."""
    return _pairs(one.ratio_after, before)


def _pairs(after: Mapping[str, float | None] | None, before: Mapping[str, float | None]) -> list[tuple[float, float]]:
    after = after or {}
    return [(b, a) for joint, b in before.items() if b is not None and (a := after.get(joint)) is not None]


def _is_rival(best: Found, other: Found, residual: Array) -> bool:
    """Whether the other explains the same part of the error about as well; on the hold-out alone, if so much better."""
    alike = other.effect.name in best.effect.alike or best.effect.name in other.effect.alike
    tolerated = max(_RIVAL, _SHARE * best.total) * (ALIKE / _RIVAL if alike else 1.0)
    behind = min(best.total - other.total, best.whole - other.whole)
    if behind > tolerated or other.score <= 0:
        return False
    a, b = best.candidate.judged.basis, other.candidate.judged.basis
    gain, left = (float(np.sum((b.T @ y) ** 2)) for y in (residual, residual - a @ (a.T @ residual)))
    return left < (1 - _SAME) * gain or other.effect.joint == best.effect.joint


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
