"""On what the error depends, with no physics assumed: hat functions of one variable at a time, judged like effects."""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.critique.evidence import Evidence
from chebid.critique.variables import Variable, hats, variables
from chebid.effects import Motion

_CHANCE = 0.98
_DRAWS = 200
_TAIL = 1.0  # percent at each end of a variable that share the outermost hats
Moving = list[tuple[Motion, Array]]


@dataclass(frozen=True)
class Dependence:
    """The error of a joint depends on a variable; score and share as those of a candidate.

    `excused`: the part of the score that errors of the accelerations can make, and that is taken off.
    """

    joint: int
    variable: str
    score: float
    share: float
    excused: float = 0.0


def dependences(evidence: Evidence, seed: int = 0) -> list[Dependence]:
    """Every variable on every joint, best first; positive scores are more than chance."""
    random, names = np.random.default_rng(seed), evidence.dynamics.joints
    moving = _moving(evidence, evidence.motions)
    judged = [
        (j, variable, evidence.beside(_rows(evidence, moving, variable, j)))
        for j in range(len(names))
        for variable in variables(j, names)
    ]
    judged = [one for one in judged if one[2].shape[1]]
    noise = random.standard_normal((len(evidence.residual), _DRAWS))
    best = np.max([_score(evidence, basis, noise) for _, _, basis in judged], axis=0)
    threshold = max(0.0, float(np.quantile(best, _CHANCE)))
    found = [(j, variable, basis, evidence.worth(basis) - _price(evidence, basis)) for j, variable, basis in judged]
    doubtful = [(j, variable) for j, variable, _, score in found if variable.accelerates and score > threshold]
    shared = _shared(evidence, doubtful, random)
    told = []
    for j, variable, basis, score in found:
        excused = max(shared.get((j, variable.name), 0.0) - threshold, 0.0)
        told.append(Dependence(j, variable.name, score - threshold - excused, evidence.share(basis), excused))
    best_of = {(d.joint, d.variable): d for d in sorted(told, key=lambda d: d.score)}  # of a coarse and a fine one
    return sorted(best_of.values(), key=lambda d: -d.score)


def _shared(
    evidence: Evidence, doubtful: list[tuple[int, Variable]], random: np.random.Generator
) -> dict[tuple[int, str], float]:
    """Scores that variables made of accelerations would get, were the error that of the accelerations; by joint, name.

    On a ramp of constant acceleration its errors (noise, and corners that a projection rounds off) are all that a
    function of it varies with, and the residual is those same errors times the inertia.
    """
    out: dict[tuple[int, str], float] = {}
    for noise in evidence.ground.noises if doubtful else []:
        motions, residual = evidence.shaken(noise, random)
        moving = _moving(evidence, motions)
        for j, variable in doubtful:
            basis = evidence.beside(_rows(evidence, moving, variable, j))
            score = evidence.worth(basis, residual) - _price(evidence, basis)
            out[j, variable.name] = max(out.get((j, variable.name), 0.0), score)
    return out


def _score(evidence: Evidence, basis: Array, residual: Array) -> Array:
    gain = np.sum((basis.T @ residual) ** 2, axis=0)
    return np.asarray(gain / 2 - _price(evidence, basis))


def _price(evidence: Evidence, basis: Array) -> float:
    return basis.shape[1] / 2 * float(np.log(len(evidence.rows.Y)))


def _moving(evidence: Evidence, motions: list[Motion]) -> Moving:
    """Motions with the torque (N, J) of the model along them."""
    return [(motion, evidence.dynamics.torque(motion, evidence.theta)) for motion in motions]


def _rows(evidence: Evidence, moving: Moving, variable: Variable, joint: int) -> Array:
    values = [variable.x(motion, tau) for motion, tau in moving]
    seen = np.concatenate([x[used[:, joint]] for x, used in zip(values, evidence.ground.used, strict=True)])
    low, high = np.percentile(seen, [_TAIL, 100 - _TAIL])
    columns = []
    for x, (motion, tau) in zip(values, moving, strict=True):
        shape = hats(x, low, high, variable.hats)
        if variable.times is not None:
            shape = shape * variable.times(motion, tau)[:, None]
        part = np.zeros((*motion.q.shape, variable.hats))
        part[:, joint] = shape
        columns.append(part)
    return evidence.project(columns)
