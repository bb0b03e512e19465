"""Friction that depends on the joint's own velocity, load or distance since reversal.

Sources: Armstrong-Helouvry, Dupont, Canudas de Wit, A survey of models, analysis tools and compensation methods for
the control of machines with friction, Automatica 30 (1994), section 2; Dahl, A solid friction model, Aerospace
Corporation TOR-158 (1968).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.effects.dahl import bristle
from chebid.effects.effect import JointEffect, column
from chebid.effects.hyper import Extent, setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array


class Viscous(JointEffect):
    """Fv dq."""

    name = "viscous"
    formula = "Fv dq"
    sentence = "friction grows in proportion to speed, as in oil or grease"
    symbols = positive = ("Fv",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(),)

    def columns(self, motion: Motion) -> Array:
        return motion.dq[:, [self.joint]]


class DryFriction(JointEffect):
    """Base of what acts against the direction of motion, however slow it is."""

    @property
    def signs(self) -> tuple[int, ...]:
        return (self.joint,)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,) * len(self.symbols)

    def levels(self, motion: Motion) -> Array:
        """(N, k): the torque per unit of each parameter while the joint moves forward."""
        return np.ones((len(motion), 1))

    def columns(self, motion: Motion) -> Array:
        return self.levels(motion) * np.sign(motion.dq[:, [self.joint]])


class Coulomb(DryFriction):
    """Fs sign(dq)."""

    name = "coulomb"
    formula = "Fs sign(dq)"
    sentence = "dry friction of constant size opposes the motion"
    symbols = positive = ("Fs",)
    alike = ("viscous",)


class Offset(JointEffect):
    """Foff: a constant; the same as dry friction that differs with direction, wherever the joint moves."""

    name = "offset"
    formula = "Foff"
    sentence = "a constant torque is added: a drive offset, or dry friction that differs between the two directions"
    symbols = ("Foff",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,)

    def columns(self, motion: Motion) -> Array:
        return np.ones((len(motion), 1))


class ViscousAsymmetry(JointEffect):
    """dFv abs(dq): viscous friction Fv + dFv forward and Fv - dFv backward."""

    name = "viscous_asymmetry"
    formula = "dFv abs(dq)"
    sentence = "viscous friction differs between the two directions, as with wear on one flank of a screw"
    symbols = ("dFv",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(),)

    def columns(self, motion: Motion) -> Array:
        return np.abs(motion.dq[:, [self.joint]])


@dataclass(frozen=True)
class Stribeck(DryFriction):
    """Fst exp(-abs(dq/vs)^delta) sign(dq)."""

    vs: float = setting("Stribeck velocity, at which the excess has fallen to 37 %", "velocity", above=0)
    delta: float = setting("exponent, usually 1 or 2", "1", 2.0, above=0, high=8)
    name = "stribeck"
    formula = "Fst exp(-abs(dq/vs)^delta) sign(dq)"
    sentence = "dry friction is larger at low speed, before a film of lubricant builds up"
    symbols = positive = ("Fst",)
    alike = ("viscous_power", "presliding", "coulomb")

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        most = max(range_.top / 3, 2 * range_.gate)
        return {"vs": np.geomspace(range_.gate, most, 6), "delta": (1.0, 2.0)}

    def levels(self, motion: Motion) -> Array:
        speed = np.abs(motion.dq[:, [self.joint]])
        return np.exp(-((speed / self.vs) ** self.delta))


class ViscousQuadratic(JointEffect):
    """F2 dq abs(dq)."""

    name = "viscous_quadratic"
    formula = "F2 dq abs(dq)"
    sentence = "friction grows with the square of speed, as in churned oil or air"
    symbols = positive = ("F2",)
    alike = ("viscous_power", "viscous")

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(2),)

    def columns(self, motion: Motion) -> Array:
        dq = motion.dq[:, [self.joint]]
        return dq * np.abs(dq)


@dataclass(frozen=True)
class ViscousPower(JointEffect):
    """Fa abs(dq)^alpha sign(dq)."""

    alpha: float = setting("power of speed", "1", above=0, below=1)
    name = "viscous_power"
    formula = "Fa abs(dq)^alpha sign(dq)"
    sentence = "friction grows less than in proportion to speed: lubricant that thins as it is sheared"
    symbols = positive = ("Fa",)
    alike = ("stribeck", "viscous_quadratic", "viscous", "coulomb")

    @property
    def signs(self) -> tuple[int, ...]:
        return (self.joint,)

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return {"alpha": (0.2, 0.35, 0.5, 0.65, 0.8)}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(self.alpha),)

    def columns(self, motion: Motion) -> Array:
        dq = motion.dq[:, [self.joint]]
        return np.sign(dq) * np.abs(dq) ** self.alpha


class LoadFriction(DryFriction):
    """mu abs(torque of the model) sign(dq)."""

    name = "load_friction"
    formula = "mu abs(model's torque) sign(dq)"
    sentence = "dry friction grows with the load on the joint, as in a loaded gear or bearing"
    symbols = positive = ("mu",)
    alike = ("torque_gain", "coulomb")

    @property
    def needs_model(self) -> bool:
        return True

    def units(self, units: Units) -> tuple[str, ...]:
        return ("1",)

    def levels(self, motion: Motion) -> Array:
        assert motion.tau is not None, "Dynamics completes the motion"
        return np.abs(motion.tau[:, [self.joint]])


@dataclass(frozen=True)
class Presliding(JointEffect):
    """Fps (z - sign dq): what Coulomb friction lacks just after a reversal; Fps is Fs where Dahl's law holds."""

    delta: float = setting("distance over which friction builds up after a reversal", "position", above=0)
    name = "presliding"
    formula = "Fps (z - sign dq), dz/dq = (1 - z sign dq)/delta"
    sentence = "after a reversal dry friction builds up over a short distance, as a bristle bends before it slips"
    symbols = positive = ("Fps",)
    alike = ("stribeck", "backlash")
    memory = True

    @property
    def signs(self) -> tuple[int, ...]:
        return (self.joint,)

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return {"delta": range_.span * np.array([0.002, 0.006, 0.018, 0.05, 0.12])}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,)

    def columns(self, motion: Motion) -> Array:
        z = bristle(motion.q[:, self.joint], self.delta)
        return column(z - np.sign(motion.dq[:, self.joint]))


EFFECTS: tuple[type[JointEffect], ...] = (
    Viscous,
    Coulomb,
    Offset,
    ViscousAsymmetry,
    Stribeck,
    ViscousQuadratic,
    ViscousPower,
    LoadFriction,
    Presliding,
)
