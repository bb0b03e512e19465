"""From a solution to an `Estimate`: what all estimators report alike."""

from typing import Any

from chebid.equations import Rows
from chebid.estimators.judge import judge
from chebid.estimators.plausible import implausible, too_short, unexplained
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.timing import lag_notice, torque_lag
from chebid.estimators.weighted import Solution


def assemble(problem: Problem, method: str, found: Solution, rows: Rows, record: dict[str, Any]) -> Estimate:
    """The estimate of a method on its rows, judged, with the lag of the torque and all warnings."""
    short = too_short(problem, rows)
    lag = torque_lag(problem, found.theta)
    late = lag_notice(lag, problem) if lag and not short else None
    residual = judge(problem, rows, found.theta)
    doubts = [*short, *implausible(problem, found), *unexplained(problem, residual)]
    return Estimate(
        method=method,
        parameters=problem.dynamics.parameters,
        theta=found.theta,
        covariance=found.covariance,
        white=found.white,
        condition=found.condition,
        residual=residual,
        weights=1 / found.sigma,
        lag=lag,
        record=problem.describe() | record,
        notices=(*problem.notices, *doubts, *([late] if late else [])),
    )
