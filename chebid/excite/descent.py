"""What a search needs of a criterion, and the descent that all families of motions share."""

from collections.abc import Callable
from typing import Any, Protocol, cast

import numpy as np
from scipy.optimize import minimize

from chebid.robots import Array

_PRECISION = 1e-6  # of the objective: less is no progress
_STEP = 1e-5  # of differences where the gradient is not known
_FEWER = 8  # times: such steps cost one evaluation for every free number


class Objective(Protocol):
    """A function of a motion sampled at `t` (N,) s.

    `pointwise`: its gradient is right; it cannot be where an effect remembers the past.
    """

    @property
    def t(self) -> Array: ...

    @property
    def pointwise(self) -> bool: ...

    def value(self, state: Array) -> float:
        """What is reported of a motion (3, N, J): the smaller, the better; infinite where it is of no use."""
        ...

    def objective(self, state: Array) -> tuple[float, Array]:
        """What the search makes small, and its gradient (3, N, J) with respect to the motion."""
        ...


def descend(target: Callable[[Array], tuple[float, Array]], free: Array, iterations: int, gradient: bool) -> Array:
    """The nearest best free numbers by SLSQP; `target` gives value and gradient, of which the latter may be ignored."""
    if gradient:
        exact = minimize(target, free, jac=True, method="SLSQP", options={"maxiter": iterations, "ftol": _PRECISION})
        return np.asarray(exact.x)

    def value(x: Array) -> float:
        return target(x)[0]

    steps = {"maxiter": -(-iterations // _FEWER), "ftol": _PRECISION, "eps": _STEP}
    return np.asarray(minimize(value, free, method="SLSQP", options=cast(Any, steps)).x)
