"""Hyper-parameters moved between the values of a grid."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from chebid.effects import Effect, Motion
from chebid.robots import Array

_EVALUATIONS = 40
_STEP = 0.05  # of the range, to start with


def refine(effect: Effect, loss: Callable[[Effect], float], motion: Motion, gate: float) -> Effect:
    """The effect with its continuous hyper-parameters where a loss is smallest, from where they are (Nelder-Mead).

    `motion`, `gate` (rad/s or m/s): what bounds the hyper-parameters.
    """
    bounds = type(effect).refinable(motion, effect.joint, gate)
    bounds = {name: limits for name, limits in bounds.items() if effect.hyper.get(name) is not None}
    if not bounds:
        return effect
    low, high = np.array(list(bounds.values())).T
    start = np.clip([effect.hyper[name] for name in bounds], low, high)
    tried = [(loss(effect), effect)]

    def at(unit: Array) -> float:
        values = np.clip(low + unit * (high - low), low, high)
        moved: dict[str, Any] = dict(zip(bounds, map(float, values), strict=True))
        tried.append((loss(replace(effect, **moved)), replace(effect, **moved)))
        return tried[-1][0]

    unit = (start - low) / (high - low)
    away = np.where(unit > 0.5, unit - _STEP, unit + _STEP)
    simplex = np.vstack([unit, *(np.where(np.arange(len(unit)) == i, away, unit) for i in range(len(unit)))])
    options: Any = {"initial_simplex": simplex, "maxfev": _EVALUATIONS, "xatol": 1e-3}
    minimize(at, unit, method="Nelder-Mead", options=options)
    return min(tried, key=lambda pair: pair[0])[1]
