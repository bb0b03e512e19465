"""Rigid robots in a simulation: mass matrix and bias torques at a state, compiled (torque = mass ddq + bias)."""

from collections.abc import Callable
from itertools import count

import numpy as np
from numba import njit, objmode

from chebid.robots import Array
from chebid.simulate.compiling import FORWARD, PLANT

PythonPlant = Callable[[Array, Array, Array, Array], None]
PythonEffect = Callable[[float, Array, Array, Array, Array, int], float]
_PYTHON: dict[int, PythonPlant] = {}
_EFFECTS: dict[int, PythonEffect] = {}
_NUMBERS = count(1)


@njit(PLANT, cache=True)
def scara(q, dq, p, mass, bias):  # type: ignore[no-untyped-def]
    """Eq. 18; p = ZZR1, ZZ2, LMX2, LMY2."""
    cosine, sine = np.cos(q[1]), np.sin(q[1])
    coupling = p[2] * cosine - p[3] * sine
    slope = p[2] * sine + p[3] * cosine
    mass[0, 0] = p[0] + p[1] + 2 * coupling
    mass[0, 1] = mass[1, 0] = p[1] + coupling
    mass[1, 1] = p[1]
    bias[0] = -slope * dq[1] * (2 * dq[0] + dq[1])
    bias[1] = slope * dq[0] ** 2


@njit(PLANT, cache=True)
def axes(q, dq, p, mass, bias):  # type: ignore[no-untyped-def]
    """Uncoupled joints; p = their inertias."""
    mass[:] = 0.0
    bias[:] = 0.0
    for j in range(len(p)):
        mass[j, j] = p[j]


@njit(PLANT, cache=True)
def python(q, dq, p, mass, bias):  # type: ignore[no-untyped-def]
    """A plant written in Python: p = its number."""
    with objmode():
        _call(q, dq, p, mass, bias)


@njit(FORWARD, cache=True)
def nothing(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fills the places that no effect needs."""
    return 0.0


@njit(FORWARD, cache=True)
def python_effect(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """An effect written in Python: p = its number. Dry friction is asked for its level, moving forward."""
    with objmode(torque="float64"):
        torque = _call_effect(t, q, dq, ddq, tau, joint, p)
    return torque


def _call_effect(t: float, q: Array, dq: Array, ddq: Array, tau: Array, joint: int, p: Array) -> float:
    return _EFFECTS[int(p[0])](t, q, dq, ddq, tau, joint)


def register_effect(effect: PythonEffect) -> int:
    """Number of an effect in Python, for `python_effect`; give it back with `release_effect`."""
    number = next(_NUMBERS)
    _EFFECTS[number] = effect
    return number


def release_effect(number: int) -> None:
    """Forget an effect in Python."""
    _EFFECTS.pop(number, None)


def _call(q: Array, dq: Array, p: Array, mass: Array, bias: Array) -> None:
    _PYTHON[int(p[0])](q, dq, mass, bias)


def register(plant: PythonPlant) -> int:
    """Number of a plant in Python, for `python`; give it back with `release`."""
    number = next(_NUMBERS)
    _PYTHON[number] = plant
    return number


def release(number: int) -> None:
    """Forget a plant in Python."""
    _PYTHON.pop(number, None)
