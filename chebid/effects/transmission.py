"""What lies between motor and link: the rotor's inertia, a spring, a gap.

A spring or a gap moves the link away from where the encoder on the motor sees it, by delta(t). To first order the
torque changes by the derivative of the rigid model along (delta, d delta/dt, d2 delta/dt2), on every joint: that
column is the signature by which they are screened. It cannot decide between them, nor replace a simulation with two
masses (`linear` is False). Source: Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control
109 (1987), for the two-mass model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from chebid.effects.effect import Derived, Grid, JointEffect
from chebid.effects.hyper import setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array, Robot

_CHUNK = 32768  # samples whose rigid regressor is held at a time
_SMALL = 1e-4  # rad or m by which the link is moved to take the derivative: its square is rounding


class RotorInertia(JointEffect):
    """Ia ddq."""

    name = "rotor_inertia"
    formula = "Ia ddq"
    sentence = "the rotor of the motor and its gear turn with the joint and add inertia to it alone"
    kind = "transmission"
    symbols = positive = ("Ia",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.inertia,)

    def columns(self, motion: Motion) -> Array:
        return motion.ddq[:, [self.joint]]


@dataclass(frozen=True)
class Yielding(JointEffect):
    """Base: the link of this joint lies `slack` ahead of its motor, per unit of the parameter."""

    robot: Robot | None = field(default=None, compare=False, repr=False, kw_only=True)
    kind = "transmission"
    linear = False
    memory = True

    def bind(self, robot: Robot) -> Self:
        return replace(self, robot=robot)

    @property
    def needs_model(self) -> bool:
        return True

    @property
    def forward(self) -> str:
        return ""  # two masses: the simulator's plant

    def rows(self, count: int) -> tuple[int, ...]:
        return tuple(range(count))

    def slack(self, load: Array) -> Array:
        """How far the motor is ahead of its link (N,) under the torque that drives the link (N,)."""
        raise NotImplementedError

    def columns(self, motion: Motion) -> Array:
        return self.block(motion)[:, self.joint]

    def block(self, motion: Motion) -> Array:
        assert self.robot is not None, "Dynamics binds it"
        assert motion.rigid is not None, "Dynamics completes the motion"
        state = (motion.q, motion.dq, motion.ddq)
        load = rigid_torque(self.robot, motion.rigid, *state)[:, self.joint]
        slack = self.slack(load)
        rate = np.gradient(slack, motion.t)
        moves = (slack, rate, np.gradient(rate, motion.t))
        size = _SMALL / max(float(np.abs(slack).max()), np.finfo(float).tiny)
        ends = []
        for sign in (1, -1):
            moved = [x.copy() for x in state]
            for x, move in zip(moved, moves, strict=True):
                x[:, self.joint] -= sign * size * move
            ends.append(rigid_torque(self.robot, motion.rigid, *moved))
        return ((ends[0] - ends[1]) / (2 * size))[:, :, None]


class JointFlexibility(Yielding):
    """A spring of stiffness K = 1/C between motor and link: the motor is ahead by C times the link's torque."""

    name = "joint_flexibility"
    formula = "C (change of the rigid torque as the link lags its motor by its torque)"
    sentence = "a spring between motor and link, such as a harmonic drive or a belt, lets the link lag"
    symbols = positive = ("C",)
    alike = ("backlash", "torque_delay")

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.compliance,)

    def slack(self, load: Array) -> Array:
        return load

    def derived(self, values: Sequence[float], rotary: tuple[bool, ...]) -> tuple[Derived, ...]:
        """Stiffness K."""
        unit = Units(rotary[self.joint]).per_position()
        return (Derived(self.label("K"), 1 / float(values[0]), unit),) if values[0] else ()


@dataclass(frozen=True)
class Backlash(Yielding):
    """A gap between motor and link, of which the motor is ahead by half when it pulls, smoothed over `soft`."""

    soft: float = setting("torque over which the contact changes sides", "torque", above=0)
    name = "backlash"
    formula = "gap (change of the rigid torque as the link lags by tanh(its torque/soft)/2)"
    sentence = "a gap between motor and link opens whenever the torque changes direction"
    symbols = positive = ("gap",)
    alike = ("joint_flexibility", "presliding")

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Fractions of the model's rms torque."""
        assert motion.tau is not None and joint is not None, "Dynamics completes the motion"
        rms = float(np.sqrt(np.mean(motion.tau[:, joint] ** 2))) or 1.0
        return [{"soft": share * rms} for share in (0.05, 0.15, 0.4)]

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.position,)

    def slack(self, load: Array) -> Array:
        return 0.5 * np.tanh(load / self.soft)


def rigid_torque(robot: Robot, rigid: Array, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque (N, J) of the rigid robot with parameters `rigid` (P,), its regressor made a chunk at a time."""
    out = np.empty(q.shape)
    for start in range(0, len(q), _CHUNK):
        piece = slice(start, start + _CHUNK)
        out[piece] = robot.regressor(q[piece], dq[piece], ddq[piece]) @ rigid
    return out


EFFECTS: tuple[type[JointEffect], ...] = (RotorInertia, JointFlexibility, Backlash)
