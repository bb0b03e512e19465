"""Physics that the library of chebid does not have; `variables` names what it depends on."""

from collections.abc import Sequence
from math import pi, sin

import numpy as np
from blind.hidden import Dry, Effect, Push, Scene, sign
from blind.world import Array, Hook, Physics


class UnevenViscous(Push):
    """Grease that lies unevenly: viscous friction that changes along the travel."""

    name, variables = "uneven_viscous", ("q", "dq")

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.values = {"middle": (low + high) / 2, "half": (high - low) / 2, "speed": scene.speed(joint),
                       "k": rng.uniform(0.5, 1.5), "phase": rng.uniform(0, 2 * pi)}  # fmt: skip

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        p = self.values
        x = (q[self.at] - p["middle"]) / p["half"]
        return sin(p["k"] * pi * x + p["phase"]) * v[self.at] / p["speed"]


class Breathing(Dry):
    """Dry friction that rises and falls with a cooling cycle."""

    name, variables, bipolar = "breathing_friction", ("t",), True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values = {"T": min(scene.durations) / rng.uniform(2.0, 4.0), "phase": rng.uniform(0, 2 * pi)}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        return sin(2 * pi * t / self.values["T"] + self.values["phase"])


class OtherAngleFriction(Dry):
    """A cable that presses on one joint the more, the further the other is bent."""

    name, kinds, variables = "other_angle_friction", ("scara",), ("other_q",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(1 - joint)
        self.values = {"low": low, "range": high - low, "power": float(rng.choice([1, 2]))}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        x = (q[1 - self.at] - self.values["low"]) / self.values["range"]
        return max(0.0, x) ** self.values["power"]


class BetweenJoints(Effect):
    """A magnetic detent between the joints: a torque on both that depends on the sum or difference of their angles."""

    name, kinds, variables = "magnetic_detent", ("scara",), ("other_q", "q")

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        side = float(rng.choice([-1, 1]))
        way = scene.plain.q[:, 0] + side * scene.plain.q[:, 1]
        self.values = {
            "side": side,
            "k": 2 * pi * rng.uniform(1.0, 2.5) / float(np.ptp(way)),
            "phase": rng.uniform(0, 6),
        }

    def start(self, physics: Physics) -> Sequence[Hook]:
        p, size, weak = self.values, self.strength, 0.5

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            force = size * sin(p["k"] * (q[0] + p["side"] * q[1]) + p["phase"])
            push[0] -= force if self.at == 0 else weak * force
            push[1] -= p["side"] * (force if self.at == 1 else weak * force)

        return (hook,)


class LoadViscous(Effect):
    """Viscous friction that grows with the torque transmitted: a loaded worm gear."""

    name, variables = "load_viscous", ("tau",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values = {"load": scene.load(joint), "speed": scene.speed(joint)}

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, p, size = self.at, self.values, self.strength

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            loss[j] += size * abs(u[j]) / p["load"] * abs(v[j]) / p["speed"]

        return (hook,)


class BentMotor(Effect):
    """A drive whose torque constant falls with the current: the report is too high where the torque is high."""

    name, variables, most = "bent_torque_constant", ("tau",), 0.4

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.strength, self.values = 0.05, {"load": scene.load(joint)}

    def report(self, torque: Array, step: float) -> Array:
        out = torque.copy()
        x = out[:, self.at] / self.values["load"]
        out[:, self.at] *= 1 + self.strength * x**2
        return out


class Ageing(Effect):
    """Dry friction that grows with the way gone since the joint last turned back (a seal that winds up)."""

    name, variables = "winding_seal", ("reversal",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.values = {"way": (high - low) * rng.uniform(0.4, 0.8)}

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, size, whole = self.at, self.strength, self.values["way"]
        way, side = 0.0, 0.0

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            nonlocal way, side
            if abs(v[j]) > 1e-5 and sign(v[j]) != side:
                way, side = 0.0, sign(v[j])
            way += abs(v[j]) * physics.step
            loss[j] += size * (way / whole) ** 2

        return (hook,)
