"""A model as one regressor: rigid robot plus effects, parameters in the paper's order (eq. 19: joint by joint)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chebid.effects import Effect, Motion, make_effects
from chebid.model import Model
from chebid.robots import Array, Parameter, Robot, make_robot


@dataclass(frozen=True)
class Dynamics:
    """torque = regressor(motion) @ theta, theta in the order of `parameters`."""

    robot: Robot
    effects: tuple[Effect, ...]

    @property
    def joints(self) -> tuple[str, ...]:
        return self.robot.joints

    @cached_property
    def _unordered(self) -> tuple[Parameter, ...]:
        own = (effect.parameters(self.joints, self.robot.rotary) for effect in self.effects)
        return self.robot.parameters + tuple(parameter for group in own for parameter in group)

    @cached_property
    def _order(self) -> list[int]:
        """By joint; within a joint the rigid body first, then effects in file order."""
        place = {joint: i for i, joint in enumerate(self.joints)}
        return sorted(range(len(self._unordered)), key=lambda i: place.get(self._unordered[i].joint or "", len(place)))

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(self._unordered[i] for i in self._order)

    def regressor(self, motion: Motion) -> Array:
        """(N, J, P) at the instants of the motion."""
        rigid = self.robot.regressor(motion.q, motion.dq, motion.ddq)
        out = np.zeros((*rigid.shape[:2], len(self._unordered)))
        out[:, :, : rigid.shape[2]] = rigid
        at = rigid.shape[2]
        for effect in self.effects:
            out[:, effect.joint, at : at + len(effect.symbols)] = effect.columns(motion)
            at += len(effect.symbols)
        return out[:, :, self._order]

    def torque(self, motion: Motion, theta: Array) -> Array:
        """Inverse dynamic model (eq. 16) at N instants: (N, J)."""
        return self.regressor(motion) @ theta


def make_dynamics(model: Model) -> Dynamics:
    """The dynamics of a model file."""
    return Dynamics(make_robot(model), make_effects(model))
