"""What changes within a log: warming up, a payload picked up, a push."""

from collections.abc import Sequence
from math import cos, exp, pi

import numpy as np
from blind.hidden import Dry, Effect, Push, Scene
from blind.world import Hook, Physics


def _warming(rng: np.random.Generator, duration: float) -> tuple[str, dict[str, float]]:
    law = str(rng.choice(["library", "hyperbola", "stretched"]))
    return law, {"T": duration * rng.uniform(0.15, 0.6), "power": rng.uniform(0.6, 1.5)}


def _warmth(law: str, p: dict[str, float], t: float) -> float:
    x = max(t, 0.0) / p["T"]
    return x / (1 + x) if law == "hyperbola" else 1 - exp(-(x ** p["power"] if law == "stretched" else x))


class CoulombDrift(Dry):
    """Dry friction that falls, or rises, while the joint warms up from the beginning of each log."""

    name = "coulomb_drift"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law, self.values = _warming(rng, min(scene.durations))
        self.values["falls"] = float(rng.random() < 0.7)

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        warm = _warmth(self.law, self.values, t)
        return 1 - warm if self.values["falls"] else warm


class ViscousDrift(Push):
    name = "viscous_drift"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law, self.values = _warming(rng, min(scene.durations))
        self.values |= {"falls": float(rng.random() < 0.7), "speed": scene.speed(joint)}

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        warm = _warmth(self.law, self.values, t)
        return (1 - warm if self.values["falls"] else warm) * v[self.at] / self.values["speed"]


class Payload(Effect):
    """A mass that the last link holds from an instant on (from the start, refitted inertias would swallow it)."""

    name, most = "payload", 50.0

    @classmethod
    def whole(cls) -> bool:
        return True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        last = scene.arm.links[-1]
        self.strength = 0.1 * last.mass
        reach = last.length or 0.1
        self.values = {"t0": rng.uniform(0.3, 0.6) * min(scene.durations),
                       "x": reach * rng.uniform(0.8, 1.1), "y": reach * rng.uniform(-0.1, 0.1)}  # fmt: skip
        if scene.arm.kind == "axes" and not scene.arm.prismatic[-1]:
            self.values |= {"x": float(np.sqrt(last.inertia / last.mass)), "y": 0.0}

    def start(self, physics: Physics) -> Sequence[Hook]:
        import mujoco

        model, p, mass = physics.model, self.values, self.strength
        body = int(model.nbody) - 1
        done = False

        def hook(
            t: float, q: list[float], v: list[float], u: list[float], push: list[float], loss: list[float]
        ) -> None:
            nonlocal done
            if done or t < p["t0"]:
                return
            done = True
            before, com = float(model.body_mass[body]), np.array(model.body_ipos[body])
            place = np.array([p["x"], p["y"], 0.0])
            after = (before * com + mass * place) / (before + mass)
            parallel = before * ((com - after) ** 2).sum() + mass * ((place - after) ** 2).sum()
            model.body_mass[body], model.body_ipos[body] = before + mass, after
            model.body_inertia[body] += parallel
            mujoco.mj_setConst(model, mujoco.MjData(model))

        return (hook,)


class ExternalPush(Push):
    """Somebody leans on the arm, once."""

    name = "external_push"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law = str(rng.choice(["library", "half-sine", "trapezoid"]))
        self.values = {"t0": rng.uniform(0.15, 0.85) * min(scene.durations), "width": rng.uniform(0.2, 1.5),
                       "side": float(rng.choice([-1, 1]))}  # fmt: skip

    def torque(self, t: float, q: list[float], v: list[float]) -> float:
        x = (t - self.values["t0"]) / self.values["width"]
        if self.law == "library":
            return self.values["side"] * exp(-0.5 * (2 * x) ** 2)
        if abs(x) >= 0.5:
            return 0.0
        return self.values["side"] * (cos(pi * x) if self.law == "half-sine" else min(1.0, (0.5 - abs(x)) / 0.15))

    def on_another_day(self) -> "Effect | None":
        return None
