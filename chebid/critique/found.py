"""A candidate with all its evidence: score, hold-out, stability, parameters, and the error that it leaves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chebid.basis import Array
from chebid.critique.candidates import Candidate
from chebid.critique.evidence import Evidence, Held
from chebid.critique.holdout import Holdout
from chebid.critique.stability import stability
from chebid.dynamics import Dynamics
from chebid.effects import Effect
from chebid.equations import measured_rows
from chebid.estimators.problem import Problem
from chebid.robots import Parameter

_COMPARED = 8  # candidates whose hold-out and stability are computed
_TOLD = 5  # candidates whose parameters and errors are computed


@dataclass(frozen=True)
class Fitted:
    """Value of one parameter of a candidate, with its deviation; sd None where the data cannot give one."""

    parameter: Parameter
    value: float
    sd: float | None


@dataclass(frozen=True)
class Found:
    """`score`: evidence of the fitted logs, more than chance where positive; `holdout`: what the hold-out adds to it.

    `stability`: share of the re-weighted rows in which it comes first. Ratios after: rms / floor by joint.
    """

    candidate: Candidate
    score: float
    holdout: float | None
    stability: float
    parameters: tuple[Fitted, ...] = ()
    ratio_after: dict[str, float | None] | None = None
    holdout_ratio_after: dict[str, float | None] | None = None

    @property
    def effect(self) -> Effect:
        return self.candidate.effect

    @property
    def total(self) -> float:
        """Evidence of the fitted logs and of the hold-out."""
        return self.score + (self.holdout or 0.0)


@dataclass(frozen=True)
class Side:
    """Logs on which ratios are told: their problem, and the noise floor (J,) of its rows, if known."""

    problem: Problem
    floor: Array | None


def compare(evidence: Evidence, candidates: Sequence[Candidate], held_out: Evidence | None, seed: int) -> list[Found]:
    """The best candidates by all the evidence, best first."""
    top = list(candidates[:_COMPARED])
    firm = stability(evidence, top, seed) if top else []
    beside = Holdout(evidence, held_out) if held_out is not None else None
    found = [
        Found(c, c.score, beside.score(c.effect) if beside else None, share) for c, share in zip(top, firm, strict=True)
    ]
    rest = [Found(c, c.score, None, 0.0) for c in candidates[_COMPARED:]]
    return [*sorted(found, key=lambda f: -f.total), *rest]


def detailed(
    found: Sequence[Found], evidence: Evidence, held: Held | None, fitted: Side, held_out: Side | None
) -> list[Found]:
    """The same, the first few with their parameters and the ratios that they leave."""
    return [_detail(one, evidence, held, fitted, held_out) if i < _TOLD else one for i, one in enumerate(found)]


def _detail(one: Found, evidence: Evidence, held: Held | None, fitted: Side, held_out: Side | None) -> Found:
    dynamics, theta, parameters = fit_with(evidence, one.effect)
    more = replace(fitted.problem.dynamics, effects=dynamics.effects, reference=dynamics.reference)
    if held is None:
        theta = _refit(fitted, more, theta)
    return replace(
        one,
        parameters=parameters,
        ratio_after=ratios(fitted, more, theta),
        holdout_ratio_after=ratios(held_out, more, theta) if held_out else None,
    )


def fit_with(evidence: Evidence, effect: Effect) -> tuple[Dynamics, Array, tuple[Fitted, ...]]:
    """Model and effect fitted together: their dynamics, theta, and the parameters of the effect."""
    W, Y = evidence.system
    dynamics = replace(
        evidence.dynamics,
        effects=(*evidence.dynamics.effects, effect),
        reference=evidence.dynamics.named(evidence.theta),
    )
    X = np.hstack([W, evidence.columns(effect)])
    scale = np.linalg.norm(X, axis=0)
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(X / scale, rcond=1e-9)
    values = (inverse @ Y) / scale
    sd = np.sqrt(np.sum(inverse**2, axis=1)) / scale
    own = effect.bind(dynamics.robot).parameters(dynamics.joints, dynamics.robot.rotary)
    known = W.shape[1]
    told = tuple(Fitted(p, float(v), float(s)) for p, v, s in zip(own, values[known:], sd[known:], strict=True))
    named = evidence.dynamics.named(values[:known]) | {
        name: one.value for name, one in zip(dynamics.names(dynamics.effects[-1]), told, strict=True)
    }
    return dynamics, np.array([named[p.name] for p in dynamics.parameters]), told


def _refit(side: Side, dynamics: Dynamics, theta: Array) -> Array:
    """theta (P,) on the equations of the side, one weight per joint."""
    problem = side.problem
    rows = measured_rows(problem.tracks, dynamics, problem.gate, problem.band.frequency)
    residual = rows.Y - rows.W @ theta
    spread = [np.std(residual[rows.joint == j]) + 1e-300 for j in range(rows.joints)]
    weight = (1 / np.array(spread))[rows.joint]
    return np.asarray(np.linalg.lstsq(rows.W * weight[:, None], rows.Y * weight)[0])


def ratios(side: Side, dynamics: Dynamics, theta: Array) -> dict[str, float | None]:
    """rms / noise floor by joint, theta (P,) on the equations of the side."""
    problem = side.problem
    rows = measured_rows(problem.tracks, dynamics, problem.gate, problem.band.frequency)
    residual = rows.Y - rows.W @ theta
    out: dict[str, float | None] = {}
    for j, name in enumerate(dynamics.joints):
        rms = float(np.linalg.norm(residual[rows.joint == j])) * rows.rms_scale(j)
        out[name] = rms / float(side.floor[j]) if side.floor is not None else None
    return out
