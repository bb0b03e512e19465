"""Which effects are candidates: the library and those of other packages, but for what must be asked for by name."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.basis import Array
from chebid.effects import Effect, Motion, Units, all_effects
from chebid.effects.channel import Saturation
from chebid.effects.effect import Grid, JointEffect
from chebid.effects.hyper import setting
from chebid.errors import Notice

_NOT = frozenset({"motor_coupling"})  # of a known gear between two joints; a part of the inertia on a SCARA
_SHARES = (60, 70, 80, 87, 92, 95, 97, 98.5, 99.3)  # percentiles of the model's torque: limits worth trying


@dataclass(frozen=True)
class Clipped(JointEffect):
    """`saturation` as a candidate: what is missing of the model's torque beyond a limit, `share` of it (1 if clipped).

    Once it is added, the samples at the limit are left out, and no torque is modelled.
    """

    limit: float = setting("largest torque of the drive", "torque", above=0)
    name = Saturation.name
    formula = Saturation.formula
    sentence = Saturation.sentence
    kind = Saturation.kind
    symbols = positive = ("share",)
    alike = ("load_friction", "torque_gain")

    @property
    def needs_model(self) -> bool:
        return True

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Percentiles of the model's torque."""
        assert motion.tau is not None and joint is not None, "the evidence gives the model's torque"
        limits: Iterable[Any] = np.percentile(np.abs(motion.tau[:, joint]), _SHARES)
        return [{"limit": float(limit)} for limit in limits if limit > 0]

    def units(self, units: Units) -> tuple[str, ...]:
        return ("1",)

    def columns(self, motion: Motion) -> Array:
        assert motion.tau is not None, "the evidence gives the model's torque"
        tau = motion.tau[:, [self.joint]]
        return -np.sign(tau) * np.maximum(0.0, np.abs(tau) - self.limit)


def candidate_kinds() -> tuple[dict[str, type[Effect]], tuple[Notice, ...]]:
    """Effects by name, and a notice for each of another package that cannot be used."""
    kinds, notices = addable_kinds()
    return {name: kind for name, kind in kinds.items() if name not in _NOT}, notices


def addable_kinds() -> tuple[dict[str, type[Effect]], tuple[Notice, ...]]:
    """Candidates, and effects that are only added by name."""
    kinds, notices = all_effects()
    return kinds | {Clipped.name: Clipped}, notices
