"""Friction and inertia that one joint's motion causes on another: coupled transmissions, as in many wrists."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.effects.effect import Grid, JointEffect
from chebid.effects.hyper import Extent, setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array, Parameter


@dataclass(frozen=True)
class Coupling(JointEffect):
    """Base: a torque on `joint` because of the motion of the joint `source`."""

    source: int = setting("the joint whose motion causes it", "joint")
    kind = "transmission"

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Every other joint."""
        return [{"source": other} for other in range(motion.q.shape[1]) if other != joint]

    def label(self, symbol: str) -> str:
        return f"{symbol}{self.joint + 1}_{self.source + 1}"

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        torque, moving = Units(rotary[self.joint]).torque, Units(rotary[self.source]).position
        units = self.crossed(torque, moving)
        named = zip(self.symbols, units, strict=True)
        return tuple(Parameter(self.label(symbol), joints[self.joint], unit) for symbol, unit in named)

    def units(self, units: Units) -> tuple[str, ...]:
        return self.crossed(units.torque, units.position)

    def crossed(self, torque: str, moving: str) -> tuple[str, ...]:
        """Units for a torque on one joint by the motion of another."""
        raise NotImplementedError


class ViscousCoupling(Coupling):
    """Fv_ji dq_i on joint j."""

    name = "viscous_coupling"
    formula = "Fv dq of the source"
    sentence = "the motion of another joint drags on this one in proportion to its speed: a coupled transmission"
    symbols = ("Fv",)
    alike = ("coulomb_coupling", "motor_coupling")

    def crossed(self, torque: str, moving: str) -> tuple[str, ...]:
        return (f"{torque}.s/{moving}",)

    def columns(self, motion: Motion) -> Array:
        return motion.dq[:, [self.source]]


class CoulombCoupling(Coupling):
    """Fs_ji sign(dq_i) on joint j."""

    name = "coulomb_coupling"
    formula = "Fs sign(dq of the source)"
    sentence = "the direction of another joint's motion adds dry friction to this one: a coupled transmission"
    symbols = ("Fs",)
    alike = ("viscous_coupling", "motor_coupling")

    @property
    def signs(self) -> tuple[int, ...]:
        return (self.source,)

    def crossed(self, torque: str, moving: str) -> tuple[str, ...]:
        return (torque,)

    def columns(self, motion: Motion) -> Array:
        return np.sign(motion.dq[:, [self.source]])


@dataclass(frozen=True)
class MotorCoupling(Coupling):
    """A motor that turns with w = dq_j + r dq_i: its inertia and friction act between both joints.

    Joint j: Iam r ddq_i + Fvm r dq_i + Fsm sign(w); joint i: r (Iam ddq_j + Fvm dq_j + Fsm sign(w)). What the motor
    does to each joint alone is in that joint's own viscous friction and rotor inertia. The form is that of the
    published figures of the Staubli TX40, whose motor 6 turns with joints 5 and 6.
    """

    ratio: float = setting("r: how much the motor turns with the source, relative to this joint", "1", 1.0)
    name = "motor_coupling"
    formula = "Iam ddq + Fvm dq of the other joint, Fsm sign(dq + dq of the source), on both joints"
    sentence = "one motor turns with the sum of two joints, so that its friction and inertia act on both"
    symbols = ("Iam", "Fvm", "Fsm")
    positive = ("Iam", "Fvm", "Fsm")
    alike = ("viscous_coupling", "coulomb_coupling")

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Every other joint, turning along or against."""
        return [entry | {"ratio": ratio} for entry in super().grid(motion, joint, gate) for ratio in (1.0, -1.0)]

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return {"ratio": (1.0, -1.0)}

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        return {}  # a ratio of teeth: 1 or -1 seen from the joints, else known to whoever built it

    @property
    def signs(self) -> tuple[int, ...]:
        return (self.joint, self.source)

    def rows(self, count: int) -> tuple[int, ...]:
        return (self.joint, self.source)

    def vector(self) -> Array:
        """Own joint, source, ratio: the forward form is asked for either joint."""
        return np.array([self.joint, self.source, self.ratio], dtype=float)

    def crossed(self, torque: str, moving: str) -> tuple[str, ...]:
        inertia = "kg.m^2" if torque == "N.m" else "kg"
        return (inertia, f"{torque}.s/{moving}", torque)

    def columns(self, motion: Motion) -> Array:
        return self.block(motion)[:, self.joint]

    def block(self, motion: Motion) -> Array:
        j, i, r = self.joint, self.source, self.ratio
        way = np.sign(motion.dq[:, j] + r * motion.dq[:, i])
        out = np.zeros((len(motion), motion.q.shape[1], 3))
        out[:, j] = np.column_stack([r * motion.ddq[:, i], r * motion.dq[:, i], way])
        out[:, i] = r * np.column_stack([motion.ddq[:, j], motion.dq[:, j], way])
        return out


EFFECTS: tuple[type[JointEffect], ...] = (ViscousCoupling, CoulombCoupling, MotorCoupling)
