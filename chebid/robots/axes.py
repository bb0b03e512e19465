"""Independent axes of one inertia each: a positioning stage, a pendulum without gravity, a test bench."""

from dataclasses import dataclass

import numpy as np

from chebid.robots.robot import Array, Parameter


@dataclass(frozen=True)
class Axes:
    """J uncoupled joints, torque_j = inertia_j ddq_j: M_j in kg on a prismatic joint, J_j in kg.m^2 on a revolute
    one.
    """

    joints: tuple[str, ...]
    types: tuple[str, ...]

    @property
    def rotary(self) -> tuple[bool, ...]:
        return tuple(kind == "revolute" for kind in self.types)

    @property
    def positive(self) -> tuple[str, ...]:
        return tuple(p.name for p in self.parameters)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        numbered = enumerate(zip(self.joints, self.rotary, strict=True), start=1)
        return tuple(
            Parameter(f"J{i}", joint, "kg.m^2") if rotary else Parameter(f"M{i}", joint, "kg")
            for i, (joint, rotary) in numbered
        )

    def regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Accelerations (N, J) on the diagonal of (N, J, J)."""
        return ddq[:, :, None] * np.eye(len(self.joints))
