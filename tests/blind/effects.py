"""Hidden physics, each by formulas of its own: what the library of chebid knows, and what it does not.

An effect is drawn for one arm and one motion (`Scene`), and has a `strength` that `strength.py` sets from the asked
ratio of unexplained torque to noise. It may change the arm (`adapt`), act at every step of the physics (`start` returns
a hook) and change what the drive reports (`report`). Friction acts through MuJoCo's own dry friction wherever it can,
so that a joint at rest really sticks. `law` names the formula; those called `library` are the ones of the effect
library, all others are the same physics by another formula.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import copysign, cos, exp, log1p, pi, sin, tanh
from typing import Any, ClassVar

import numpy as np
from blind.world import Arm, Array, Hook, Physics, Run, Transmission

_EDGE = 1e-3  # share of the rms speed over which a sign turns, where the sign of ANOTHER joint's velocity acts


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
    known: ClassVar[bool] = True  # in the library of chebid
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


KNOWN: tuple[type[Effect], ...] = (
    Offset, ViscousAsymmetry, Stribeck, ViscousQuadratic, ViscousPower, LoadFriction, FrictionRipple, TorqueRipple,
    Presliding, ViscousCoupling, CoulombCoupling, CoulombDrift, ViscousDrift, Spring, CubicSpring, HardStop, BaseTilt,
    Payload, RotorInertia, TorqueDelay, TorqueGain, Saturation, Flexibility, Backlash, ExternalPush,
)  # fmt: skip

_FAMILIES: dict[str, tuple[type[Effect], ...]] = {
    "curve": (Stribeck, ViscousQuadratic, ViscousPower, Presliding),
    "coupling": (ViscousCoupling, CoulombCoupling),
    "time": (CoulombDrift, ViscousDrift, ExternalPush, Payload),
    "position": (Spring, CubicSpring, HardStop, BaseTilt, TorqueRipple),
    "side": (Offset, ViscousAsymmetry),
    "load": (LoadFriction, FrictionRipple),
    "channel": (RotorInertia, TorqueDelay, TorqueGain, Saturation, Flexibility, Backlash),
}
for _family, _members in _FAMILIES.items():
    for _member in _members:
        _member.family = _family


class Unknown:
    """Marks effects that no library has."""

    known: ClassVar[bool] = False


class UnevenViscous(Unknown, Push):
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


class Breathing(Unknown, Dry):
    """Dry friction that rises and falls with a cooling cycle."""

    name, variables, bipolar = "breathing_friction", ("t",), True

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.values = {"T": min(scene.durations) / rng.uniform(2.0, 4.0), "phase": rng.uniform(0, 2 * pi)}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        return sin(2 * pi * t / self.values["T"] + self.values["phase"])


class OtherAngleFriction(Unknown, Dry):
    """A cable that presses on one joint the more, the further the other is bent."""

    name, kinds, variables = "other_angle_friction", ("scara",), ("other_q",)

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        low, high = scene.span(1 - joint)
        self.values = {"low": low, "range": high - low, "power": float(rng.choice([1, 2]))}

    def level(self, t: float, q: list[float], v: list[float], u: list[float]) -> float:
        x = (q[1 - self.at] - self.values["low"]) / self.values["range"]
        return max(0.0, x) ** self.values["power"]


class BetweenJoints(Unknown, Effect):
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


class LoadViscous(Unknown, Effect):
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


class BentMotor(Unknown, Effect):
    """A drive whose torque constant falls with the current: the report is too high where the torque is high."""

    name, variables, most = "bent_torque_constant", ("tau",), 0.4

    def prepare(self, scene: Scene, joint: int, rng: np.random.Generator) -> None:
        self.strength, self.values = 0.05, {"load": scene.load(joint)}

    def report(self, torque: Array, step: float) -> Array:
        out = torque.copy()
        x = out[:, self.at] / self.values["load"]
        out[:, self.at] *= 1 + self.strength * x**2
        return out


class Ageing(Unknown, Effect):
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


UNKNOWN: tuple[type[Effect], ...] = (
    UnevenViscous, Breathing, OtherAngleFriction, BetweenJoints, LoadViscous, BentMotor, Ageing,
)  # fmt: skip
ALL: dict[str, type[Effect]] = {effect.name: effect for effect in (*KNOWN, *UNKNOWN)}


def describe(effect: Effect) -> dict[str, Any]:
    """For the results table."""
    return {
        "effect": effect.name,
        "joint": effect.joint,
        "law": effect.law,
        "strength": effect.strength,
    } | effect.values
