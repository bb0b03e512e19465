"""Friction of a joint by its own motion and load: the curves over speed, ripple, bristles."""

from collections.abc import Sequence
from math import copysign, cos, exp, log1p, pi

import numpy as np
from blind.hidden import Dry, Effect, Push, Scene, sign
from blind.world import Arm, Hook, Physics


class Offset(Push):
    name = "offset"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values["side"] = float(rng.choice([-1, 1]))

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        return self.values["side"]


class ViscousAsymmetry(Push):
    name = "viscous_asymmetry"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values["speed"] = scene.speed(joint) * float(rng.choice([-1, 1]))

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        return abs(v[self.at]) / self.values["speed"]


class Stribeck(Dry):
    """Sticks harder than it slides: the break-away torque is real."""

    name = "stribeck"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law = str(rng.choice(["library", "exponent", "rational"]))
        power = {"library": float(rng.choice([1, 2])), "exponent": rng.uniform(0.6, 1.7), "rational": 2.0}[self.law]
        self.values = {"speed": scene.speed(joint) * rng.uniform(0.15, 0.7), "power": power}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        x = (abs(v[self.at]) / self.values["speed"]) ** self.values["power"]
        return 1 / (1 + x) if self.law == "rational" else exp(-x)


class ViscousQuadratic(Dry):
    name = "viscous_quadratic"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law = str(rng.choice(["library", "exponent"]))
        self.values = {"speed": scene.speed(joint), "power": 2.0 if self.law == "library" else rng.uniform(1.75, 2.4)}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        return (abs(v[self.at]) / self.values["speed"]) ** self.values["power"]


class ViscousPower(Dry):
    name = "viscous_power"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law = str(rng.choice(["library", "logarithm"]))
        share = 1.0 if self.law == "library" else rng.uniform(0.05, 0.3)
        self.values = {"speed": scene.speed(joint) * share, "power": rng.uniform(0.25, 0.75)}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        x = abs(v[self.at]) / self.values["speed"]
        return log1p(x) if self.law == "logarithm" else x ** self.values["power"]


class LoadFriction(Effect):
    """Dry friction that grows with what the joint transmits, from the drive or to the link."""

    name = "load_friction"
    most = 0.6

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law = str(rng.choice(["library", "motor", "rounded"]))
        self.strength = 0.05
        self.values["rounding"] = 0.3 * scene.load(joint)

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, mu, law, rounding = self.at, self.strength, self.law, self.values["rounding"]
        dof, data = physics.drive[j], physics.data

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            # motor torque less dry friction (the engine's constraint) is what goes into the link
            load = u[j] if law == "motor" else u[j] + float(data.qfrc_constraint[dof])
            loss[j] += mu * (((load**2 + rounding**2) ** 0.5 - rounding) if law == "rounded" else abs(load))

        return (hook,)


class FrictionRipple(Dry):
    name = "friction_ripple"
    bipolar = True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "harmonics"]))
        # one to five periods over the travel
        self.values = {"k": 2 * pi * rng.uniform(1.0, 5.0) / (high - low), "phase": rng.uniform(0, 2 * pi),
                       "second": rng.uniform(0.2, 0.5) if self.law == "harmonics" else 0.0,
                       "phase2": rng.uniform(0, 2 * pi)}  # fmt: skip

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        p, x = self.values, q[self.at]
        return (cos(p["k"] * x + p["phase"]) + p["second"] * cos(2 * p["k"] * x + p["phase2"])) / (1 + p["second"])


class Presliding(Effect):
    """Bristles for dry friction: Dahl, LuGre (a damped bristle; no peak, that is Stribeck's), other exponents."""

    name = "presliding"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(joint)
        self.law = str(rng.choice(["library", "lugre", "exponent"]))
        self.strength = 0.01 * (high - low)
        self.values = {"largest": 0.25 * (high - low), "friction": scene.load(joint) * rng.uniform(0.15, 0.4),
                       "power": rng.uniform(1.2, 2.0)}  # fmt: skip

    def adapt(self, arm: Arm) -> Arm:
        return arm.with_link(self.at, friction=0.0)

    def start(self, physics: Physics) -> Sequence[Hook]:
        j, p, law, h = self.at, self.values, self.law, physics.step
        delta, friction = min(self.strength, p["largest"]), p["friction"]
        # the bristle's damping (s) stays below the explicit limit of the step
        sigma1 = 0.3 * friction * h / delta if law == "lugre" else 0.0
        z = 0.0

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            nonlocal z
            s, way, before = sign(v[j]), abs(v[j]) * h, z
            if law == "exponent":
                z += way / delta * s * abs(1 - z * s) ** p["power"] * copysign(1.0, 1 - z * s)
            else:
                z = s + (z - s) * exp(-way / delta) if s else z
            push[j] -= friction * z + sigma1 * (z - before) / h

        return (hook,)
