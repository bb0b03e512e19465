"""What comes from outside the arm: a payload, gravity from an unforeseen side, a push.

A payload and a tilt are seen through the links, so that these effects must know the robot (`Effect.bind`). A robot
may offer `load_parameters` with `load_regressor(q, dq, ddq) -> (N, J, k)`, a body fixed to its last link, and
`lean(q, rigid) -> (N, J, 3)`, its torques per m/s^2 of gravity along each axis of the base, with `gravity`; where it
offers none, what shows of them in its own parameters is used.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from chebid.effects.effect import ArmEffect, Derived, Effect, Grid, JointEffect, column
from chebid.effects.hyper import Extent, setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array, Axes, Parameter, Robot, Scara


@runtime_checkable
class Carrier(Protocol):
    """A robot that knows what a body on its last link does."""

    @property
    def load_parameters(self) -> tuple[Parameter, ...]: ...

    def load_regressor(self, q: Array, dq: Array, ddq: Array) -> Array: ...


@runtime_checkable
class Leaner(Protocol):
    """A robot that knows how gravity acts on it from any side."""

    @property
    def gravity(self) -> tuple[float, float, float]: ...

    def lean(self, q: Array, rigid: Array) -> Array: ...


@dataclass(frozen=True)
class Payload(ArmEffect):
    """A mass on the last link, from the instant `t0` on (of the log's clock), or from the start.

    Its parameters are those of the body where the robot is a `Carrier`; else the changes of the robot's own: on a
    SCARA of all four (m L^2, m (x^2 + y^2), m L x, m L y), on separate axes of every inertia.
    """

    t0: float | None = setting("instant from which it is carried; from the start if absent", "s", None)
    robot: Robot | None = field(default=None, compare=False, repr=False, kw_only=True)
    name = "payload"
    formula = "a body on the last link, from t0 on"
    sentence = "the arm carries a load that the model does not know"
    kind = "load"

    def __post_init__(self) -> None:
        if self.robot is not None:
            object.__setattr__(self, "symbols", tuple(name for name, _, _ in self._carried()))

    def bind(self, robot: Robot) -> Self:
        return replace(self, robot=robot)

    @property
    def once(self) -> bool:
        return self.t0 is not None

    @property
    def forward(self) -> str:
        return {Scara: "payload_scara", Axes: "payload_axes"}.get(type(self._robot), "")

    @property
    def _robot(self) -> Robot:
        assert self.robot is not None, "Dynamics binds it"
        return self.robot

    def _own(self) -> list[int]:
        """The robot's parameters that a load changes."""
        parameters = self._robot.parameters
        if isinstance(self._robot, Scara | Axes):
            return list(range(len(parameters)))
        return [i for i, p in enumerate(parameters) if p.joint == self._robot.joints[-1]]

    def _carried(self) -> list[tuple[str, str | None, str]]:
        if isinstance(self._robot, Carrier):
            return [(f"{p.name}_load", None, p.unit) for p in self._robot.load_parameters]
        own = (self._robot.parameters[i] for i in self._own())
        return [(f"d{p.name}", p.joint, p.unit) for p in own]

    def units(self, units: Units) -> tuple[str, ...]:
        return tuple(unit for _, _, unit in self._carried())

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, joint, unit) for name, joint, unit in self._carried())

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        inside = np.linspace(range_.start, range_.end, 12)[1:-1]
        return {"t0": (None, *inside.tolist())}

    def block(self, motion: Motion) -> Array:
        state = (motion.q, motion.dq, motion.ddq)
        if isinstance(self._robot, Carrier):
            carried = self._robot.load_regressor(*state)
        else:
            carried = self._robot.regressor(*state)[:, :, self._own()]
        return carried if self.t0 is None else carried * (motion.t >= self.t0)[:, None, None]


@dataclass(frozen=True)
class BaseTilt(ArmEffect):
    """Gravity from an unforeseen side.

    The missing part of the gravity vector where the robot is a `Leaner` (m/s^2). On a SCARA the moments of its two
    weights, G1c cos q1 + G1s sin q1 on joint 1 and G2c cos(q1 + q2) + G2s sin(q1 + q2) on both; on separate axes the
    moment of each, or its constant weight on one that slides.
    """

    robot: Robot | None = field(default=None, compare=False, repr=False, kw_only=True)
    name = "base_tilt"
    formula = "gravity leaking in"
    sentence = "gravity acts from another side than the model says: the arm is mounted out of level"
    kind = "load"
    alike = ("spring", "cubic_spring", "hard_stop")

    def __post_init__(self) -> None:
        if self.robot is not None:
            object.__setattr__(self, "symbols", tuple(name for name, _, _ in self._weights()))

    def bind(self, robot: Robot) -> Self:
        return replace(self, robot=robot)

    @property
    def needs_model(self) -> bool:
        return _leaner(self.robot) is not None

    @property
    def forward(self) -> str:
        return "base_tilt_scara" if isinstance(self.robot, Scara) else ""

    @property
    def _robot(self) -> Robot:
        assert self.robot is not None, "Dynamics binds it"
        return self.robot

    def _weights(self) -> list[tuple[str, str | None, str]]:
        if _leaner(self._robot) is not None:
            return [(f"dg{axis}", None, "m/s^2") for axis in "xyz"]
        out: list[tuple[str, str | None, str]] = []
        for number, (joint, rotary) in enumerate(zip(self._robot.joints, self._robot.rotary, strict=True), start=1):
            names = (f"G{number}c", f"G{number}s") if rotary else (f"G{number}",)
            out += [(name, joint, Units(rotary).torque) for name in names]
        return out

    def units(self, units: Units) -> tuple[str, ...]:
        return tuple(unit for _, _, unit in self._weights())

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, joint, unit) for name, joint, unit in self._weights())

    def block(self, motion: Motion) -> Array:
        robot = self._robot
        leaner = _leaner(robot)
        if leaner is not None:
            assert motion.rigid is not None, "Dynamics completes the motion"
            return leaner.lean(motion.q, motion.rigid)
        if isinstance(robot, Scara):
            return scara_weights(motion.q)
        return _axis_weights(motion.q, robot.rotary)

    def derived(self, values: Sequence[float], rotary: tuple[bool, ...]) -> tuple[Derived, ...]:
        """Tilt from the vertical of the model, and azimuth in the base, where the gravity vector is known."""
        leaner = _leaner(self.robot)
        if leaner is None or not any(leaner.gravity):
            return ()
        nominal = np.array(leaner.gravity)
        actual = nominal + np.asarray(values)
        tilt = math.atan2(float(np.linalg.norm(np.cross(nominal, actual))), float(nominal @ actual))
        azimuth = math.atan2(values[1], values[0])
        return (Derived("tilt", tilt, "rad"), Derived("azimuth", azimuth, "rad"))


def _leaner(robot: object) -> Leaner | None:
    return robot if isinstance(robot, Leaner) else None


def scara_weights(q: Array) -> Array:
    """(N, 2, 4): per unit of G1c, G1s, G2c, G2s."""
    out = np.zeros((len(q), 2, 4))
    both = q[:, 0] + q[:, 1]
    out[:, 0, 0], out[:, 0, 1] = np.cos(q[:, 0]), np.sin(q[:, 0])
    out[:, :, 2], out[:, :, 3] = np.cos(both)[:, None], np.sin(both)[:, None]
    return out


def _axis_weights(q: Array, rotary: tuple[bool, ...]) -> Array:
    columns = []
    for j, turns in enumerate(rotary):
        for values in (np.cos(q[:, j]), np.sin(q[:, j])) if turns else (np.ones(len(q)),):
            part = np.zeros(q.shape)
            part[:, j] = values
            columns.append(part)
    return np.stack(columns, axis=2)


@dataclass(frozen=True)
class ExternalPush(JointEffect):
    """P (1 + cos(pi (t - t0)/width))/2 for abs(t - t0) < width: a smooth bump."""

    t0: float = setting("instant of its middle, on the log's clock", "s")
    width: float = setting("its width at half height", "s", above=0)
    name = "external_push"
    formula = "P (1 + cos(pi (t - t0)/width))/2 where abs(t - t0) < width"
    sentence = "something pushed the arm once, for a moment"
    kind = "load"
    symbols = ("P",)

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Bumps of three widths, side by side along the record."""
        start, duration = float(motion.t[0]), float(motion.t[-1] - motion.t[0])
        counts = (8, 24, 72)
        return [
            {"t0": start + (i + 0.5) * duration / count, "width": duration / count}
            for count in counts
            for i in range(count)
        ]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        start, end = float(motion.t[0]), float(motion.t[-1])
        return {"t0": (start, end), "width": ((end - start) / 200, (end - start) / 4)}

    @property
    def once(self) -> bool:
        return True

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,)

    def columns(self, motion: Motion) -> Array:
        x = np.clip((motion.t - self.t0) / self.width, -1.0, 1.0)
        return column(0.5 * (1 + np.cos(np.pi * x)))


EFFECTS: tuple[type[Effect], ...] = (Payload, BaseTilt, ExternalPush)
