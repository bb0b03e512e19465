"""What every hidden effect is: drawn for an arm and a motion, with one strength, in the engine or in the report."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from blind.world import Arm, Array, Hook, Physics, Run


@dataclass(frozen=True)
class Scene:
    """What an effect may know when it is drawn: the arm, its run without effects, the noise and the durations."""

    arm: Arm
    plain: Run
    noise: Array
    durations: tuple[float, float]

    def span(self, joint: int) -> tuple[float, float]:
        low, high = np.percentile(self.plain.q[:, joint], [0.5, 99.5])
        return float(low), float(high)

    def speed(self, joint: int) -> float:
        return float(np.sqrt((self.plain.dq[:, joint] ** 2).mean()))

    def load(self, joint: int) -> float:
        return float(np.sqrt((self.plain.motor[:, joint] ** 2).mean()))


def sign(x: float) -> float:
    return (x > 0) - (x < 0)


@dataclass
class Effect:
    """One hidden effect of an arm; `joint` None where it is the whole arm's."""

    joint: int | None
    strength: float = 1.0
    law: str = "library"
    values: dict[str, float] = field(default_factory=dict)

    name: ClassVar[str] = ""
    any_joint: ClassVar[bool] = False  # the joint cannot be told from a log
    variables: ClassVar[tuple[str, ...]] = ()  # of an unknown effect: what its torque depends on, most telling first
    kinds: ClassVar[tuple[str, ...]] = ("scara", "axes")
    most: ClassVar[float] = 1e9  # strengths beyond are no longer this effect
    family: ClassVar[str] = ""  # effects of one family look alike: never hidden together
    impacts: ClassVar[bool] = False  # its ratio counts below 10 Hz only: what rings above is no torque of the motion

    @classmethod
    def draw(cls, scene: Scene, joint: int, rng: np.random.Generator) -> "Effect":
        """An effect with random values and a first guess of its strength: one noise."""
        effect = cls(None if cls.whole() else joint, float(scene.noise[joint]))
        effect.prepare(scene, joint, rng)
        return effect

    @classmethod
    def whole(cls) -> bool:
        return False

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None: ...

    def adapt(self, arm: Arm) -> Arm:
        return arm

    def start(self, physics: Physics) -> Sequence[Hook]:
        return ()

    def report(self, torque: Array, step: float) -> Array:
        return torque

    def on_another_day(self) -> "Effect | None":
        """The effect as it is when the hold-out log is taken."""
        return self

    @property
    def at(self) -> int:
        assert self.joint is not None
        return self.joint


class Push(Effect):
    """A torque that does not depend on what the joint does at rest: subclasses give it by `torque`."""

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        raise NotImplementedError

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, size, torque = self.at, self.strength, self.torque

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            push[j] -= size * torque(t, q, v)

        return (hook,)


class Dry(Effect):
    """Friction against the joint's own motion: `level` >= 0 times strength, through MuJoCo's dry friction."""

    bipolar: ClassVar[bool] = False  # the level swings about zero: the joint needs that much Coulomb friction

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        raise NotImplementedError

    def adapt(self, arm: Arm) -> Arm:
        link = arm.links[self.at]
        least = 1.2 * self.strength if self.bipolar else 0.0
        return arm.with_link(self.at, friction=max(link.friction, least))

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, size, level = self.at, self.strength, self.level

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            loss[j] += size * level(t, q, v, u)

        return (hook,)
