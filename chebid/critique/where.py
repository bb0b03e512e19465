"""Where the model fails: cells of every variable, and windows of time, in which the error stands out from the noise."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.critique.evidence import Evidence
from chebid.critique.variables import since_reversal
from chebid.effects import Motion
from chebid.motion import Mask

_CELLS = 8
_FEWEST = 12  # independent values in a cell, for its rms to say something
_TOLD = 3  # cells per joint
_STANDS_OUT = 1.3  # error over noise from which on a cell is told
_CHANCE = 3.0  # deviations of the rms of a cell, which noise alone hardly reaches in any


@dataclass(frozen=True)
class Cell:
    """A region of one variable in which the error of a joint stands out.

    `ratio`: rms of the error in the band over that of the noise; `mean`: its mean, N.m or N.
    """

    joint: int
    variable: str
    low: float
    high: float
    ratio: float
    mean: float


def where(evidence: Evidence, theta: Array, ratios: Sequence[float | None]) -> list[Cell]:
    """The worst cells of each joint, under parameters theta (P,); at most one for each variable.

    `ratios`: error over noise of the joints as a whole, which those of the cells make up; None: from the equations.
    """
    out, errors = [], evidence.error(theta)
    for joint, ratio in enumerate(ratios):
        found = _cells(evidence, errors, theta, joint, ratio)
        cells = sorted(found, key=lambda cell: -cell.ratio)
        best = {cell.variable: cell for cell in reversed(cells)}
        out += sorted(best.values(), key=lambda cell: -cell.ratio)[:_TOLD]
    return out


def _cells(evidence: Evidence, errors: list[Array], theta: Array, joint: int, whole: float | None) -> list[Cell]:
    motions, known = evidence.motions, [used[:, joint] for used in evidence.ground.used]
    error = np.concatenate([e[k, joint] for e, k in zip(errors, known, strict=True)])
    noise = float(np.sqrt(np.mean(error**2))) / whole if whole else _noise(evidence, joint)
    independent = 2 * evidence.ground.band / evidence.ground.tracks[0].rate  # values per sample
    out = []
    for name, values in _variables(motions, known, evidence, theta, joint).items():
        edges = np.unique(np.quantile(values, np.linspace(0, 1, _CELLS + 1)))
        for low, high in itertools.pairwise(edges):
            inside = (values >= low) & (values <= high)
            count = independent * int(inside.sum())
            if count < _FEWEST or not noise:
                continue
            part = error[inside]
            ratio = float(np.sqrt(np.mean(part**2))) / noise
            if ratio >= max(_STANDS_OUT, 1 + _CHANCE / np.sqrt(2 * count)):
                out.append(Cell(joint, name, float(low), float(high), ratio, float(part.mean())))
    return out


def _variables(motions: list[Motion], known: list[Mask], evidence: Evidence, theta: Array, j: int) -> dict[str, Array]:
    """Values of each variable at the samples that are used."""
    torques = [evidence.dynamics.torque(motion, theta) for motion in motions]
    each = [
        {
            "q": m.q[:, j],
            "dq": m.dq[:, j],
            "ddq": m.ddq[:, j],
            "t": m.t,
            "abs(tau)": np.abs(tau[:, j]),
            "distance since reversal": since_reversal(m, j),
        }
        for m, tau in zip(motions, torques, strict=True)
    ]
    return {name: np.concatenate([one[name][k] for one, k in zip(each, known, strict=True)]) for name in each[0]}


def _noise(evidence: Evidence, joint: int) -> float:
    """Rms of the noise (N.m or N) of a joint within the band, per sample that is used."""
    mine = evidence.rows.joint == joint
    samples = max(evidence.rows.noise[joint].samples, 1)
    return float(np.sqrt(np.sum(evidence.deviation[mine] ** 2) / samples))
