"""On what the error depends, with no physics assumed: hat functions of one variable at a time, judged like effects."""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.critique.evidence import Evidence
from chebid.critique.variables import Variable, hats, variables

_HATS = 8
_CHANCE = 0.98
_DRAWS = 200
_TAIL = 1.0  # percent at each end of a variable that share the outermost hats


@dataclass(frozen=True)
class Dependence:
    """The error of a joint depends on a variable; score and share as those of a candidate."""

    joint: int
    variable: str
    score: float
    share: float


def dependences(evidence: Evidence, seed: int = 0) -> list[Dependence]:
    """Every variable on every joint, best first; positive scores are more than chance."""
    torques = [evidence.dynamics.torque(motion, evidence.theta) for motion in evidence.motions]
    names = evidence.dynamics.joints
    judged = [
        (j, variable.name, evidence.beside(_rows(evidence, torques, variable, j)))
        for j in range(len(names))
        for variable in variables(j, names)
    ]
    judged = [one for one in judged if one[2].shape[1]]
    noise = np.random.default_rng(seed).standard_normal((len(evidence.residual), _DRAWS))
    best = np.max([_score(evidence, basis, noise) for _, _, basis in judged], axis=0)
    threshold = max(0.0, float(np.quantile(best, _CHANCE)))
    found = [
        Dependence(j, name, evidence.worth(basis) - _price(evidence, basis) - threshold, evidence.share(basis))
        for j, name, basis in judged
    ]
    return sorted(found, key=lambda d: -d.score)


def _score(evidence: Evidence, basis: Array, residual: Array) -> Array:
    gain = np.sum((basis.T @ residual) ** 2, axis=0)
    return np.asarray(gain / 2 - _price(evidence, basis))


def _price(evidence: Evidence, basis: Array) -> float:
    return basis.shape[1] / 2 * float(np.log(len(evidence.rows.Y)))


def _rows(evidence: Evidence, torques: list[Array], variable: Variable, joint: int) -> Array:
    values = [variable.x(motion, tau) for motion, tau in zip(evidence.motions, torques, strict=True)]
    seen = np.concatenate([x[used[:, joint]] for x, used in zip(values, evidence.ground.used, strict=True)])
    low, high = np.percentile(seen, [_TAIL, 100 - _TAIL])
    columns = []
    for x, motion, tau in zip(values, evidence.motions, torques, strict=True):
        shape = hats(x, low, high, _HATS)
        if variable.times is not None:
            shape = shape * variable.times(motion, tau)[:, None]
        part = np.zeros((*motion.q.shape, _HATS))
        part[:, joint] = shape
        columns.append(part)
    return evidence.project(columns)
