"""Between the command and the link: what the drive reports, its rotor, a soft or loose transmission."""

from math import exp, pi

import numpy as np
from blind.hidden import Effect, Scene
from blind.world import Arm, Array, Transmission


class RotorInertia(Effect):
    """The rotor of the elbow's motor, which turns with its own joint only: MuJoCo's armature."""

    name, kinds = "rotor_inertia", ("scara",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.joint = 1
        acceleration = float(np.sqrt((scene.plain.ddq[:, 1] ** 2).mean()))
        self.strength = float(scene.noise[1]) / acceleration

    def adapt(self, arm: Arm) -> Arm:
        return arm.with_link(self.at, armature=self.strength)


class TorqueDelay(Effect):
    """The drive reports late: by a dead time, or through a first-order filter."""

    name, most = "torque_delay", 0.03

    @classmethod
    def whole(cls) -> bool:
        return True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.law, self.strength = str(rng.choice(["library", "filter"])), 2e-3

    def report(self, torque: Array, step: float) -> Array:
        from scipy.signal import lfilter

        if self.law == "filter":
            pole = exp(-step / self.strength)
            return lfilter([1 - pole], [1, -pole], torque - torque[0], axis=0) + torque[0]
        rows = np.arange(len(torque))
        early = np.maximum(rows - self.strength / step, 0)
        return np.column_stack([np.interp(early, rows, column) for column in torque.T])


class TorqueGain(Effect):
    """A wrong torque constant on one joint; on which one cannot be told."""

    name, kinds, any_joint, most = "torque_gain", ("scara",), True, 1.0

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.strength, self.values = 0.05, {"side": float(rng.choice([-1, 1]))}

    def report(self, torque: Array, step: float) -> Array:
        out = torque.copy()
        out[:, self.at] *= 1 + self.strength if self.values["side"] > 0 else 1 / (1 + self.strength)
        return out


class Saturation(Effect):
    """The reported torque stops at a limit that the real one exceeds; strength is the share of the peak cut off."""

    name, most = "saturation", 0.7

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.strength = 0.3
        self.values["peak"] = float(np.percentile(np.abs(scene.plain.motor[:, joint]), 99.9))

    def report(self, torque: Array, step: float) -> Array:
        out, limit = torque.copy(), self.values["peak"] * (1 - min(self.strength, self.most))
        out[:, self.at] = np.clip(out[:, self.at], -limit, limit)
        return out


class Flexibility(Effect):
    """A spring between motor and link, the encoder on the motor; strength is its compliance (rad/N.m)."""

    name = "joint_flexibility"

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        link = scene.arm.links[joint]
        inertia = link.mass if scene.arm.prismatic[joint] else link.inertia + link.mass * np.hypot(*link.com) ** 2
        self.values = {"inertia": float(inertia), "rotor": rng.uniform(0.2, 0.8), "zeta": rng.uniform(0.02, 0.08)}
        self.values["most"] = 1 / (inertia * (2 * pi * 9) ** 2)
        self.strength = 1 / (inertia * (2 * pi * 25) ** 2)

    def adapt(self, arm: Arm) -> Arm:
        inertia, compliance = self.values["inertia"], min(self.strength, self.values["most"])
        spring = 1 / compliance
        damping = 2 * self.values["zeta"] * (spring * inertia) ** 0.5
        return arm.with_link(self.at, transmission=Transmission(self.values["rotor"] * inertia, spring, damping))


class Backlash(Effect):
    """A gap between motor and link, closed by MuJoCo's joint limits; the encoder on the motor."""

    name, impacts = "backlash", True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        link = scene.arm.links[joint]
        low, high = scene.span(joint)
        inertia = link.mass if scene.arm.prismatic[joint] else link.inertia + link.mass * np.hypot(*link.com) ** 2
        self.values = {"inertia": float(inertia), "rotor": rng.uniform(0.2, 0.8), "most": 0.04 * (high - low)}
        self.values["drag"] = rng.uniform(0.2, 0.6) * link.damping
        self.strength = 0.004 * (high - low)

    def adapt(self, arm: Arm) -> Arm:
        gap = min(self.strength, self.values["most"])
        gear = Transmission(self.values["rotor"] * self.values["inertia"], 0.0, self.values["drag"], gap)
        return arm.with_link(self.at, transmission=gear)
