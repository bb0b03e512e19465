"""The estimators, one per file, on the same problem and with the same result."""

from collections.abc import Callable

from chebid.errors import UsageError
from chebid.estimators.dr import dr
from chebid.estimators.ekf import ekf
from chebid.estimators.huber import huber
from chebid.estimators.iv import iv
from chebid.estimators.judge import judge, overall, relative_raw
from chebid.estimators.poly import poly
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate, JointResidual
from chebid.estimators.wls import wls

__all__ = ["METHODS", "Estimate", "JointResidual", "Problem", "estimate", "judge", "overall", "relative_raw"]

METHODS: dict[str, Callable[[Problem], Estimate]] = {
    "poly": poly,
    "wls": wls,
    "huber": huber,
    "iv": iv,
    "ekf": ekf,
    "dr": dr,
}


def estimate(problem: Problem, method: str) -> Estimate:
    """Run one estimator by name. Raises UsageError for a name that is not in `METHODS`."""
    if method not in METHODS:
        raise UsageError(f"unknown method {method!r}", hint=f"choose one of: {', '.join(METHODS)}, all")
    return METHODS[method](problem)
