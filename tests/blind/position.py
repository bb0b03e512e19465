"""Torques over the position: springs, stops, cogging, gravity."""

from dataclasses import replace
from math import cos, pi, sin, tanh

import numpy as np
from blind.hidden import Effect, Push, Scene, sign
from blind.world import Arm


class TorqueRipple(Push):
    name = "torque_ripple"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "harmonics"]))
        # slow enough for the log: the fastest crossing gives at most some 6 Hz
        top = float(np.abs(scene.plain.dq[:, joint]).max())
        fastest = max(2 * pi * 1.5 / (high - low), 2 * pi * 6 / top)
        k = rng.uniform(2 * pi * 1.5 / (high - low), fastest)
        self.values = {"k": k, "phase": rng.uniform(0, 2 * pi), "phase2": rng.uniform(0, 2 * pi),
                       "second": rng.uniform(0.2, 0.6) if self.law == "harmonics" else 0.0}  # fmt: skip

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        p, x = self.values, q[self.at]
        return cos(p["k"] * x + p["phase"]) + p["second"] * cos(2 * p["k"] * x + p["phase2"])


class Spring(Push):
    name = "spring"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "softening"]))
        self.values = {"rest": rng.uniform(low, high), "half": (high - low) / 2, "soft": rng.uniform(1.5, 3.0)}

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        x = (q[self.at] - self.values["rest"]) / self.values["half"]
        return x if self.law == "library" else self.values["soft"] * tanh(x / self.values["soft"])


class CubicSpring(Push):
    name = "cubic_spring"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "exponent"]))
        middle, half = (low + high) / 2, (high - low) / 2
        self.values = {"rest": middle + rng.uniform(-0.3, 0.3) * half, "half": half,
                       "power": 3.0 if self.law == "library" else rng.uniform(2.6, 3.6)}  # fmt: skip

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        x = (q[self.at] - self.values["rest"]) / self.values["half"]
        return sign(x) * abs(x) ** self.values["power"]


class HardStop(Push):
    """A bumper that the joint runs into near one end of its travel; it may damp, and never pulls."""

    name = "hard_stop"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "damped"]))
        side = float(rng.choice([-1, 1]))
        far = rng.uniform(0.65, 0.9)
        self.values = {"side": side, "at": low + far * (high - low) if side > 0 else high - far * (high - low),
                       "depth": 0.1 * (high - low), "power": rng.uniform(1.0, 1.5), "speed": scene.speed(joint),
                       "damp": rng.uniform(0.05, 0.2) if self.law == "damped" else 0.0}  # fmt: skip

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        p = self.values
        x = p["side"] * (q[self.at] - p["at"]) / p["depth"]
        if x <= 0:
            return 0.0
        return p["side"] * max(0.0, x ** p["power"] * (1 + p["damp"] * p["side"] * v[self.at] / p["speed"]))


class BaseTilt(Effect):
    """An arm mounted out of level: MuJoCo's gravity, turned."""

    name, kinds, most = "base_tilt", ("scara",), 0.5

    @classmethod
    def whole(cls) -> bool:
        return True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.strength, self.values = 0.02, {"azimuth": rng.uniform(0, 2 * pi)}

    def adapt(self, arm: Arm) -> Arm:
        tilt, azimuth = self.strength, self.values["azimuth"]
        flat = 9.81 * sin(tilt)
        return replace(arm, gravity=(flat * cos(azimuth), flat * sin(azimuth), -9.81 * cos(tilt)))
