"""Friction that one joint feels when another moves."""

from math import tanh

import numpy as np
from blind.hidden import Push, Scene

_EDGE = 1e-3  # share of the rms speed over which a sign turns, where the sign of ANOTHER joint's velocity acts


class ViscousCoupling(Push):
    name, kinds = "viscous_coupling", ("scara",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values = {"speed": scene.speed(1 - joint) * float(rng.choice([-1, 1]))}

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        return v[1 - self.at] / self.values["speed"]


class CoulombCoupling(Push):
    name, kinds = "coulomb_coupling", ("scara",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values = {"edge": _EDGE * scene.speed(1 - joint), "side": float(rng.choice([-1, 1]))}

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        return self.values["side"] * tanh(v[1 - self.at] / self.values["edge"])
