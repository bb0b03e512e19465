"""Friction that depends on the joint's own velocity (`shared effects`: Armstrong-Helouvry et al., Automatica 30,
1994).
"""

import numpy as np

from chebid.effects.effect import Effect, Motion, Units
from chebid.robots import Array


class Viscous(Effect):
    """Fv dq."""

    name = "viscous"
    sentence = "friction grows in proportion to speed, as in oil or grease"
    symbols = ("Fv",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(),)

    def columns(self, motion: Motion) -> Array:
        return motion.dq[:, [self.joint]]


class Coulomb(Effect):
    """Fs sign(dq)."""

    name = "coulomb"
    sentence = "dry friction of constant size opposes the motion"
    symbols = ("Fs",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,)

    def columns(self, motion: Motion) -> Array:
        return np.sign(motion.dq[:, [self.joint]])


class Offset(Effect):
    """Foff: a constant; the same as dry friction that differs with direction, wherever the joint moves."""

    name = "offset"
    sentence = "a constant torque is added: a drive offset, or dry friction that differs between the two directions"
    symbols = ("Foff",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,)

    def columns(self, motion: Motion) -> Array:
        return np.ones((len(motion.t), 1))


class ViscousAsymmetry(Effect):
    """dFv abs(dq): viscous friction Fv + dFv forward and Fv - dFv backward."""

    name = "viscous_asymmetry"
    sentence = "viscous friction differs between the two directions, as with wear on one flank of a screw"
    symbols = ("dFv",)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(),)

    def columns(self, motion: Motion) -> Array:
        return np.abs(motion.dq[:, [self.joint]])


EFFECTS: tuple[type[Effect], ...] = (Viscous, Coulomb, Offset, ViscousAsymmetry)
