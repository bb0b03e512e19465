"""A model as the simulator needs it: mass matrix and bias at a state, and effects in forward form.

A robot may bring its own compiled function: a method `plant(values) -> (function, data)`, with `function` of the
signature `compiling.PLANT`, data (D,) handed to it, and `values` in the order of its parameters. Without one, mass
and bias come from the columns of its regressor: right for any robot, and some 50 times slower.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from chebid.dynamics import Dynamics
from chebid.effects import Effect
from chebid.effects.forward import BRISTLES, CHANNELS, FORWARDS, TWO_MASSES, forward_form
from chebid.errors import UsageError
from chebid.robots import Array, Axes, Chain, Robot, Scara
from chebid.simulate import kernel, plants

Numbers = NDArray[np.int64]


class Plant(Protocol):
    """Rigid mechanism: torque = mass ddq + bias."""

    def __call__(self, q: Array, dq: Array, mass: Array, bias: Array) -> None:
        """Fill mass (J, J) and bias (J,) at the state q, dq (J,)."""
        ...


@dataclass(frozen=True)
class RegressorPlant:
    """Mass and bias from the regressor: torque is affine in ddq."""

    robot: Robot
    values: Array

    def __call__(self, q: Array, dq: Array, mass: Array, bias: Array) -> None:
        n = len(q)
        units = np.vstack([np.zeros(n), np.eye(n)])
        torque = self.robot.regressor(np.tile(q, (n + 1, 1)), np.tile(dq, (n + 1, 1)), units) @ self.values
        bias[:] = torque[0]
        mass[:] = (torque[1:] - torque[0]).T


@contextmanager
def compiled_plant(robot: Robot, values: Array, generic: bool = False) -> Iterator[tuple[Any, Array]]:
    """The robot's compiled function and its data; `generic`: from the regressor even if there is a faster one."""
    own = getattr(robot, "plant", None)
    if own is not None and not generic:
        yield own(values)
    elif isinstance(robot, Scara) and not generic:
        yield plants.scara, values
    elif isinstance(robot, Axes) and not generic:
        yield plants.axes, values
    elif isinstance(robot, Chain) and not generic:
        from chebid.simulate.tree import tree, tree_data

        yield tree, tree_data(robot, values)
    else:
        number = plants.register(RegressorPlant(robot, values))
        try:
            yield plants.python, np.array([float(number)])
        finally:
            plants.release(number)


@contextmanager
def compiled_effects(dynamics: Dynamics, theta: Array) -> Iterator[tuple[tuple[Any, ...], Numbers, Array, Numbers]]:
    """The effects for the kernel: functions (SLOTS), table (3, E), values (2, E, P), modes (J,) to start with.

    Springs and gaps between motor and link are not among them: they are in `chebid.simulate.transmission`.
    """
    count = len(dynamics.joints)
    with ExitStack() as stack:
        functions: list[Any] = []
        rows, inputs, mode = [], [], np.full(count, kernel.FREE)
        for effect, p in dynamics.terms(theta):
            if effect.name in CHANNELS or effect.name in TWO_MASSES:
                continue
            for acting in _acting(effect, p, dynamics, theta, stack):
                if acting.function not in functions:
                    functions.append(acting.function)
                for joint in effect.rows(count):
                    rows.append((functions.index(acting.function), joint, acting.flags(joint, count)))
                    inputs.append((acting.p, acting.h))
                    mode[joint] = 0 if acting.dry else mode[joint]
        if len(functions) > kernel.SLOTS:
            raise UsageError(f"has {len(functions)} different effects", hint=f"simulate at most {kernel.SLOTS}")
        table = np.array(rows, dtype=np.int64).reshape(-1, 3).T.copy()
        yield (*functions, *(plants.nothing,) * (kernel.SLOTS - len(functions))), table, _padded(inputs), mode


def _padded(inputs: list[tuple[Array, Array]]) -> Array:
    """(2, E, P) with zeros after the values of each."""
    out = np.zeros((2, len(inputs), max([1, *(len(part) for pair in inputs for part in pair)])))
    for e, pair in enumerate(inputs):
        for kind, part in enumerate(pair):
            out[kind, e, : len(part)] = part
    return out


@dataclass(frozen=True)
class _Acting:
    """An effect in a simulation: its compiled function, whether it is dry friction or remembers, its values."""

    function: Any
    dry: bool
    p: Array
    h: Array
    remembers: bool = False

    def flags(self, joint: int, count: int) -> int:
        """Bits for the kernel; whether it depends on the model's torque and on the acceleration is found by trying."""
        random, flags = np.random.default_rng(0), kernel.DRY if self.dry else 0
        flags |= kernel.REMEMBERS if self.remembers else 0
        rest = (joint, np.append(self.p, 0.0), np.append(self.h, 0.0))
        for t in (0.5, 1e3):
            q, dq, ddq, tau, other = random.uniform(0.5, 1.5, (5, count))
            base = self.function(t, q, dq, ddq, tau, *rest)
            flags |= kernel.LOADED if self.function(t, q, dq, ddq, other, *rest) != base else 0
            flags |= kernel.INERTIAL if self.function(t, q, dq, other, tau, *rest) != base else 0
        return flags


def _acting(effect: Effect, p: Array, dynamics: Dynamics, theta: Array, stack: ExitStack) -> list[_Acting]:
    """An effect as one function, or, in Python, as two: what turns with the direction of motion, and the rest."""
    if effect.name in BRISTLES:
        bristle = _Acting(BRISTLES[effect.name], False, p, np.append(effect.vector(), [0.0, 0.0]), remembers=True)
        return [_Acting(FORWARDS["coulomb"].function, True, -p, np.zeros(0)), bristle]
    function, dry = forward_form(effect, dynamics.rigid(theta))
    count = len(dynamics.joints)
    if effect.forward in FORWARDS:
        return [_Acting(function, dry, p, effect.vector())]

    def torque(t: float, q: Array, dq: Array, ddq: Array, tau: Array, joint: int) -> float:
        return function(t, q[:count], dq[:count], ddq[:count], tau[:count], joint, p, None)

    if effect.joint is None or effect.joint not in effect.signs:
        return [_in_python(torque, False, stack)]
    return [_in_python(_half(torque, -1), True, stack), _in_python(_half(torque, 1), False, stack)]


def _in_python(torque: plants.PythonEffect, dry: bool, stack: ExitStack) -> _Acting:
    number = plants.register_effect(torque)
    stack.callback(plants.release_effect, number)
    return _Acting(plants.python_effect, dry, np.array([float(number)]), np.zeros(0))


def _half(torque: plants.PythonEffect, parity: int) -> plants.PythonEffect:
    """Half the torque moving forward and half that moving backward, added (parity 1) or subtracted (-1)."""

    def half(t: float, q: Array, dq: Array, ddq: Array, tau: Array, joint: int) -> float:
        ends = []
        for way in (1, -1):
            moving = dq.copy()
            moving[joint] = way * max(abs(dq[joint]), 1e-300)
            ends.append(torque(t, q, moving, ddq, tau, joint))
        return (ends[0] + parity * ends[1]) / 2

    return half
