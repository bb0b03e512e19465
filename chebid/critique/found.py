"""A candidate with all its evidence: score, hold-out, stability, parameters, and the error that it leaves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chebid.basis import Array
from chebid.critique.candidates import Candidate
from chebid.critique.evidence import Evidence
from chebid.critique.holdout import Holdout
from chebid.critique.stability import stability
from chebid.critique.transmission import simulated_block, simulated_rows, simulated_size
from chebid.effects import Effect
from chebid.effects.load import Payload
from chebid.effects.transmission import Backlash
from chebid.equations import Rows, project_columns
from chebid.estimators.problem import Problem
from chebid.robots import Parameter

_COMPARED = 10  # candidates of which more than the score is computed
_GAINS = ("dZZ", "dJ", "dM")  # what a load adds to
_SURE = 2.0  # deviations below zero
_TRUST = 2.0  # times the score: more than that a hold-out does not count for an effect
_WORSE = 1.05  # times the error of a joint on the hold-out: one that raises it further needs its likelihood to stay
_RUINED = 1.2  # times the errors of all joints on the hold-out, multiplied: one that raises it further is refuted
_DENIED = (8.0, 0.05)  # score and share of its score by which the hold-out must speak against a candidate, to refute it
_ASTRAY = 0.25  # the share for a gap: its impacts ring at other instants on another motion


@dataclass(frozen=True)
class Fitted:
    """Value of one parameter of a candidate, with its deviation; sd None where the data cannot give one."""

    parameter: Parameter
    value: float
    sd: float | None


@dataclass(frozen=True)
class Found:
    """`score`: evidence of the fitted logs, more than chance where positive; `holdout`: what the hold-out adds to it.

    `stability`: share of the re-weighted rows in which it comes first; `share`: of the squared residual of a joint that
    it takes away. Ratios after: rms / floor by joint. `refuted`: the hold-out is predicted worse with it, or friction
    that the model has becomes negative.
    """

    candidate: Candidate
    score: float
    holdout: float | None
    stability: float
    share: float = 0.0
    parameters: tuple[Fitted, ...] = ()
    ratio_after: dict[str, float | None] | None = None
    holdout_ratio_after: dict[str, float | None] | None = None
    refuted: bool = False

    @property
    def effect(self) -> Effect:
        """The effect, its hyper-parameters at their best."""
        return self.candidate.effect

    @property
    def total(self) -> float:
        """Evidence of the fitted logs and of the hold-out, which counts for at most twice as much as they do."""
        return self.score + min(self.holdout or 0.0, _TRUST * max(self.score, 0.0))

    @property
    def whole(self) -> float:
        """The same, with all that the hold-out says."""
        return self.score + (self.holdout or 0.0)


class Side:
    """Logs on which ratios are told: their problem, and the noise floor (J,) of its rows, if known."""

    def __init__(self, problem: Problem, floor: Array | None) -> None:
        self.problem, self.floor = problem, floor

    def columns(self, effect: Effect, theta: Array) -> Array:
        """Rows (R, k) of an effect beside those of the problem; the model's own torque is that of theta (P,)."""
        problem, dynamics = self.problem, self.problem.dynamics
        parts = []
        for track in problem.tracks:
            block = simulated_block(dynamics, effect, track.motion, theta)
            parts.append(project_columns(track, problem.gate, problem.band.frequency, block))
        return np.concatenate(parts)

    def ratios(self, residual: Array) -> dict[str, float | None]:
        """rms / noise floor by joint of a residual (R,)."""
        rows = self.problem.rows
        out: dict[str, float | None] = {}
        for j, name in enumerate(self.problem.dynamics.joints):
            rms = float(np.linalg.norm(residual[rows.joint == j])) * rows.rms_scale(j)
            out[name] = rms / float(self.floor[j]) if self.floor is not None else None
        return out


@dataclass(frozen=True)
class Sides:
    """The fitted logs and the hold-out, under the model's parameters theta (P,); `held`: not to be fitted again."""

    theta: Array
    fitted: Side
    held_out: Side | None
    held: bool


def compare(
    evidence: Evidence, candidates: Sequence[Candidate], held_out: Evidence | None, sides: Sides, seed: int
) -> list[Found]:
    """The best candidates by all the evidence, best first; what the hold-out refutes comes after what it does not."""
    top = list(candidates[:_COMPARED])
    firm: dict[tuple[str, int | None], float] = {}
    for candidate, first in zip(top, stability(evidence, top, seed) if top else [], strict=True):
        firm[candidate.key] = firm.get(candidate.key, 0.0) + first
    beside = Holdout(evidence, held_out) if held_out is not None else None
    found = [
        _detail(
            Found(c, c.score, _beside(beside, c.effect), firm[c.key], evidence.share(c.judged.basis)),
            evidence,
            sides,
        )
        for c in top
    ]
    rest = [Found(c, c.score, None, 0.0) for c in candidates[_COMPARED:]]
    ranked = [*sorted(found, key=lambda f: (f.refuted, -f.total)), *rest]
    best = {one.candidate.key: one for one in reversed(ranked)}  # of two forms that which the hold-out prefers
    return [one for one in ranked if best[one.candidate.key] is one]


def _beside(holdout: Holdout | None, effect: Effect) -> float | None:
    """What the hold-out says, if there is one."""
    return holdout.score(effect) if holdout is not None else None


def _detail(one: Found, evidence: Evidence, sides: Sides) -> Found:
    """A candidate with its parameters and the ratios that it leaves."""
    theta, sd, parameters = fit_with(evidence, one.effect)
    if not sides.held:
        one = replace(one, refuted=_turns_negative(evidence, one.effect, theta + _SURE * sd))
    if isinstance(one.effect, Payload):
        one = replace(one, refuted=one.refuted or _weighs_less(parameters))
    rows = sides.fitted.problem.rows
    X = np.hstack([rows.W, sides.fitted.columns(one.effect, sides.theta)])
    if not sides.held:
        theta = _refit(rows, X, theta)
    more = one
    if sides.held_out is not None:
        before, after = (
            sides.held_out.ratios(left) for left in _held_out(sides.held_out, one.effect, sides.theta, theta)
        )
        # simulated impacts ring at the wrong instants: likelier where the noise is small, yet no smaller an error
        worse = one.effect.linear and _worse(one, before, after)
        denied = _denied(one) and not _better(before, after)
        refuted = one.refuted or (not one.effect.once and (denied or worse))
        more = replace(one, holdout_ratio_after=after, refuted=refuted)
    return replace(more, parameters=parameters, ratio_after=sides.fitted.ratios(rows.Y - X @ theta))


def _held_out(side: Side, effect: Effect, theta: Array, after: Array) -> tuple[Array, Array]:
    """Residuals (R,) of the hold-out under theta (P,), and with an effect under `after` (P + k,)."""
    rows, known = side.problem.rows, len(theta)
    elsewhere = side.problem.dynamics.elsewhere
    left = rows.Y - rows.W @ elsewhere(after[:known])
    if not effect.once:
        left = left - side.columns(effect, theta) @ after[known:]
    return rows.Y - rows.W @ elsewhere(theta), left


def _denied(one: Found) -> bool:
    """Whether the hold-out is clearly less likely with the candidate."""
    least, share = _DENIED
    share = _ASTRAY if isinstance(one.effect, Backlash) else share
    return (one.holdout or 0.0) < -max(least, share * one.score)


def _better(before: dict[str, float | None], after: dict[str, float | None]) -> bool:
    """Whether the errors of all joints on the hold-out, multiplied, became clearly smaller."""
    return float(np.prod(_growths(before, after))) < 1 / _RUINED


def _growths(before: dict[str, float | None], after: dict[str, float | None]) -> list[float]:
    """Error after by error before, of every joint where both are known."""
    pairs = ((value, after[joint]) for joint, value in before.items())
    return [a / b for b, a in pairs if b and a is not None]


def _worse(one: Found, before: dict[str, float | None], after: dict[str, float | None]) -> bool:
    """Whether the error on the hold-out grew: of any joint; of all together, where the hold-out is likelier with it.

    (What is missing on one joint is made up for by parameters that others share: put right, these may lose a little.)
    """
    grown = _growths(before, after)
    if (one.holdout or 0.0) <= 0:
        return max(grown, default=0.0) > _WORSE
    return float(np.prod(grown)) > _RUINED


def _weighs_less(parameters: Sequence[Fitted]) -> bool:
    """Whether a load would take inertia or mass away (a load that was taken off is a change of the robot's own)."""
    return any(p.parameter.name.startswith(_GAINS) and p.sd is not None and p.value < -_SURE * p.sd for p in parameters)


def _turns_negative(evidence: Evidence, candidate: Effect, theta: Array) -> bool:
    """Whether a candidate makes a parameter negative that cannot be so in nature, theta (P + k,) at its highest.

    Not one of an effect that it is known to look like: together they give a shape that neither has.
    """
    before = evidence.dynamics.terms(evidence.theta)
    after = evidence.dynamics.terms(theta[: len(evidence.theta)])
    return any(
        symbol in effect.positive and value < 0 < was and effect.name not in candidate.alike
        for (effect, values), (_, old) in zip(after, before, strict=True)
        for symbol, value, was in zip(effect.symbols, values, old, strict=True)
    )


def fit_with(evidence: Evidence, effect: Effect) -> tuple[Array, Array, tuple[Fitted, ...]]:
    """Model and effect fitted together on whitened rows: theta (P + k,), its deviations, the effect's parameters."""
    W, Y = evidence.system
    X = np.hstack([W, simulated_rows(evidence, effect)])
    scale = np.linalg.norm(X, axis=0)
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(X / scale, rcond=1e-9)
    values = (inverse @ Y) / scale
    sd = np.sqrt(np.sum(inverse**2, axis=1)) / scale
    dynamics, known = evidence.dynamics, W.shape[1]
    own = effect.bind(dynamics.robot).parameters(dynamics.joints, dynamics.robot.rotary)
    size = simulated_size(evidence, effect)
    if size is not None:
        return values, sd, (Fitted(own[0], size, None),)
    told = zip(own, values[known:], sd[known:], strict=True)
    return values, sd, tuple(Fitted(p, float(v), float(s)) for p, v, s in told)


def _refit(rows: Rows, X: Array, theta: Array) -> Array:
    """theta (P + k,) on rows with columns X (R, P + k), one weight per joint."""
    residual = rows.Y - X @ theta
    spread = [np.std(residual[rows.joint == j]) + 1e-300 for j in range(rows.joints)]
    weight = (1 / np.array(spread))[rows.joint]
    return np.asarray(np.linalg.lstsq(X * weight[:, None], rows.Y * weight)[0])
