"""`poly`: least squares on polynomial projections, the method of the paper (section 3.2, abstract).

Positions are projected (eq. 11) and differentiated (eq. 13, 14); the equations that follow (eq. 20) are projected as
a whole, so that the rows are as many as there are independent equations.
"""

from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.weighted import solve


def poly(problem: Problem) -> Estimate:
    """Estimate by projection. Raises NoAnswerError on rank loss or when nothing is left to use."""
    rows, dynamics = problem.rows, problem.dynamics
    found = solve(rows, dynamics.parameters)
    record = {
        "equation_bandwidth": problem.band.frequency,
        "equation_bandwidth_reason": problem.band.reason,
        "equations": {joint: n.equations for joint, n in zip(dynamics.joints, rows.noise, strict=True)},
    }
    return assemble(problem, "poly", found, rows, record)
