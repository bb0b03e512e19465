"""Could these parameters be those of a real robot? A model that explains little says so before anyone uses it."""

import numpy as np

from chebid.equations import Rows
from chebid.errors import Notice, Place
from chebid.estimators.problem import Problem
from chebid.estimators.result import JointResidual
from chebid.estimators.weighted import Solution

_SHORT = 5.0  # independent equations for each parameter, below which a record is too short
_SURE = 3.0  # deviations below zero
_LITTLE = 0.3  # relative error beyond which a model explains little


def implausible(problem: Problem, found: Solution) -> list[Notice]:
    """Warnings for parameters that are surely negative where nature has none: inertias, friction."""
    dynamics = problem.dynamics
    positive = set(dynamics.robot.positive)
    for effect in dynamics.bound:
        names = zip(effect.symbols, dynamics.names(effect), strict=False)
        positive |= {name for symbol, name in names if symbol in effect.positive}
    out = []
    for i, p in enumerate(dynamics.parameters):
        value, sd = float(found.theta[i]), float(found.covariance[i, i]) ** 0.5
        if p.name in positive and value < -_SURE * sd:
            text = (
                f"{p.name} is {value:.3g} {p.unit}; no real robot has it below zero: "
                "columns exchanged, a wrong sign, or an effect that is not there?"
            )
            out.append(Notice("implausible", text, Place(file=str(problem.logs[0].path))))
    return out


def too_short(problem: Problem, rows: Rows) -> list[Notice]:
    """Warnings for joints with too few independent equations for the parameters that act on them."""
    out, seconds = [], sum(record.duration for log in problem.logs for record in log.records)
    for j, joint in enumerate(problem.dynamics.joints):
        count = rows.noise[j].equations
        parameters = int(np.count_nonzero(rows.W[rows.joint == j].any(axis=0)))
        if count < _SHORT * parameters:
            text = (
                f"{seconds:.3g} s are too short: they give joint {joint} {count:.0f} independent equations for "
                f"{parameters} parameters, too few to find them and to judge them; record 20 s or more of varied motion"
            )
            out.append(Notice("short", text, Place(file=str(problem.logs[0].path))))
    return out


def unexplained(problem: Problem, residual: dict[str, JointResidual]) -> list[Notice]:
    """Warnings for joints whose torque the model hardly explains."""
    return [
        Notice(
            "poor_fit",
            f"the model leaves {100 * r.relative:.0f} % of the torque of joint {joint} unexplained: check which column "
            "is which, units and gains, and the order of the joints",
            Place(file=str(problem.logs[0].path)),
        )
        for joint, r in residual.items()
        if r.relative > _LITTLE
    ]
