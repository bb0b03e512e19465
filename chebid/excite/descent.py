"""What a search needs of a criterion, and the descent that all families of motions share."""

from collections.abc import Callable
from typing import Protocol

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
    options = {"maxiter": iterations if gradient else -(-iterations // _FEWER), "ftol": _PRECISION}
    if gradient:
        return np.asarray(minimize(target, free, jac=True, method="SLSQP", options=options).x)
    options["eps"] = _STEP
    return np.asarray(minimize(lambda x: target(x)[0], free, method="SLSQP", options=options).x)
