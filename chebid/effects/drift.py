"""Friction that changes while the robot warms up: (1 - exp(-t/T)), t from the start of the record."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.effects.effect import JointEffect, column
from chebid.effects.friction import DryFriction
from chebid.effects.hyper import Extent, setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array


def warmed(motion: Motion, constant: float) -> Array:
    """(N, 1): from 0 at the start of the record towards 1."""
    return column(-np.expm1(-(motion.t - motion.start) / constant))


def constants(range_: Extent) -> dict[str, Iterable[Any]]:
    """Time constants from a 20th of the record to all of it; a longer one looks like a straight line."""
    return {"T": np.geomspace(range_.duration / 20, range_.duration, 5)}


@dataclass(frozen=True)
class CoulombDrift(DryFriction):
    """dFsT (1 - exp(-t/T)) sign(dq)."""

    T: float = setting("time constant", "s", above=0)
    name = "coulomb_drift"
    formula = "dFsT (1 - exp(-t/T)) sign(dq)"
    sentence = "dry friction changes while the joint warms up, or its seal wears in"
    kind = "time"
    symbols = ("dFsT",)
    alike = ("viscous_drift",)

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return constants(range_)

    def levels(self, motion: Motion) -> Array:
        return warmed(motion, self.T)


@dataclass(frozen=True)
class ViscousDrift(JointEffect):
    """dFvT (1 - exp(-t/T)) dq."""

    T: float = setting("time constant", "s", above=0)
    name = "viscous_drift"
    formula = "dFvT (1 - exp(-t/T)) dq"
    sentence = "viscous friction changes while the lubricant warms up"
    kind = "time"
    symbols = ("dFvT",)
    alike = ("coulomb_drift",)

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return constants(range_)

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_velocity(),)

    def columns(self, motion: Motion) -> Array:
        return warmed(motion, self.T) * motion.dq[:, [self.joint]]


EFFECTS: tuple[type[JointEffect], ...] = (CoulombDrift, ViscousDrift)
