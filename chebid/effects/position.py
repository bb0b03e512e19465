"""Torques that depend on where the joint is: springs, stops, ripple of gears and motors."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.effects.effect import Derived, Grid, JointEffect, motion_extent
from chebid.effects.friction import DryFriction
from chebid.effects.hyper import Extent, setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array

_MOST = 25  # waves over the range of a joint


@dataclass(frozen=True)
class FrictionRipple(DryFriction):
    """sign(dq) (ac cos kq + as sin kq)."""

    k: float = setting("waves of the friction", "wave", above=0)
    name = "friction_ripple"
    formula = "sign(dq) (ac cos(k q) + as sin(k q))"
    sentence = "dry friction comes and goes with position: a gear or bearing out of centre"
    kind = "position"
    symbols = ("ac", "as")
    alike = ("torque_ripple", "coulomb")

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return {"k": waves(range_)}

    def levels(self, motion: Motion) -> Array:
        return wave(self.k, motion.q[:, self.joint])


@dataclass(frozen=True)
class TorqueRipple(JointEffect):
    """bc cos kq + bs sin kq, and the same of 2 k, 3 k, ... up to `harmonics`."""

    k: float = setting("waves of the torque, not always a whole number", "wave", above=0)
    harmonics: int = setting("how many multiples of k", "1", 1, low=1, high=20, whole=True)
    name = "torque_ripple"
    formula = "bc cos(k q) + bs sin(k q), with harmonics"
    sentence = "a torque comes and goes with position whatever the direction: cogging of the motor, or its gear"
    kind = "position"
    symbols = ("bc", "bs")
    alike = ("friction_ripple", "spring")

    def __post_init__(self) -> None:
        more = (f"b{n}{part}" for n in range(2, self.harmonics + 1) for part in "cs")
        object.__setattr__(self, "symbols", ("bc", "bs", *more))

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """One wave at every k, and two harmonics where the second can still be seen; at least one over the range.

        What does not come back within the range is no ripple: a spring, a stop, gravity.
        """
        ks = waves(motion_extent(motion, joint, gate))
        ks = ks[1:] or ks
        one = [{"k": k, "harmonics": 1} for k in ks]
        return one + [{"k": k, "harmonics": 2} for k in ks if 2 * k <= ks[-1]]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        ks = [entry["k"] for entry in cls.grid(motion, joint, gate)]
        return {"k": (0.75 * min(ks), 2 * max(ks))}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.torque,) * len(self.symbols)

    def columns(self, motion: Motion) -> Array:
        q = motion.q[:, self.joint]
        return np.concatenate([wave(n * self.k, q) for n in range(1, self.harmonics + 1)], axis=1)


@dataclass(frozen=True)
class Spring(JointEffect):
    """k (q - q0), linear in k and k q0; or one that softens as it is stretched: k r tanh((q - q0) / r)."""

    r: float | None = setting("stretch over which it softens; a linear spring if absent", "position", None, above=0)
    q0: float | None = setting("position at rest of one that softens", "position", None)
    name = "spring"
    formula = "k (q - q0), or k r tanh((q - q0) / r)"
    sentence = "a spring pulls the joint to one position: a counterbalance, a cable, a hose"
    kind = "position"
    symbols = ("k", "kq0")
    positive = ("k",)
    alike = ("base_tilt", "cubic_spring", "hard_stop")

    def __post_init__(self) -> None:
        if self.r is not None:
            object.__setattr__(self, "symbols", ("k",))

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """The linear spring, and softening ones: from a third of the range on, below which it would be a stop."""
        range_ = motion_extent(motion, joint, gate)
        rests = np.linspace(range_.low, range_.high, 5)
        return [{}] + [{"r": r * range_.span, "q0": float(q0)} for r in (0.4, 1.0) for q0 in rests]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        range_ = motion_extent(motion, joint, gate)
        beyond = range_.span / 4
        return {"r": (range_.span / 3, 4 * range_.span), "q0": (range_.low - beyond, range_.high + beyond)}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_position(), units.torque)[: len(self.symbols)]

    def columns(self, motion: Motion) -> Array:
        q = motion.q[:, [self.joint]]
        if self.r is None:
            return np.concatenate([q, np.full_like(q, -1.0)], axis=1)
        return self.r * np.tanh((q - (self.q0 or 0.0)) / self.r)

    def derived(self, values: Sequence[float], rotary: tuple[bool, ...]) -> tuple[Derived, ...]:
        """Rest position q0 of a linear one."""
        if self.r is not None or not values[0]:
            return ()
        unit = Units(rotary[self.joint]).position
        return (Derived(self.label("q0_"), float(values[1] / values[0]), unit),)


@dataclass(frozen=True)
class CubicSpring(JointEffect):
    """k3 (q - q0)^3."""

    q0: float = setting("position at rest", "position", 0.0)
    name = "cubic_spring"
    formula = "k3 (q - q0)^3"
    sentence = "a spring that stiffens as it is stretched pulls the joint to one position"
    kind = "position"
    symbols = ("k3",)
    alike = ("spring", "base_tilt", "hard_stop")

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        return {"q0": np.linspace(range_.low, range_.high, 5)}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_position(3),)

    def columns(self, motion: Motion) -> Array:
        return (motion.q[:, [self.joint]] - self.q0) ** 3


@dataclass(frozen=True)
class HardStop(JointEffect):
    """kh s max(0, s (q - qs))^m: the stiffness kh is positive at either end."""

    qs: float = setting("position at which the stop is touched", "position")
    s: int = setting("side: 1 at the upper end of the range, -1 at the lower", "1", 1, choices=(-1, 1), whole=True)
    m: float = setting("exponent, from 1 (rubber) to 1.5 (two round bodies)", "1", 1.0, low=0.5, high=4)
    name = "hard_stop"
    formula = "kh s max(0, s (q - qs))^m"
    sentence = "near one end of its range the joint runs into a stop, a cable or a seal that pushes it back"
    kind = "position"
    symbols = positive = ("kh",)
    alike = ("spring", "cubic_spring", "base_tilt")

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Stops within the last 3 to 35 % of the range, at both ends."""
        range_ = motion_extent(motion, joint, gate)
        ends = [(1, range_.high), (-1, range_.low)]
        inside = range_.span * np.array([0.03, 0.08, 0.15, 0.25, 0.35])
        return [{"qs": float(end - s * d), "s": s, "m": m} for s, end in ends for d in inside for m in (1.0, 1.5)]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        range_ = motion_extent(motion, joint, gate)
        return {"qs": (range_.low, range_.high), "m": (1.0, 2.0)}

    def units(self, units: Units) -> tuple[str, ...]:
        return (units.per_position(self.m),)

    def columns(self, motion: Motion) -> Array:
        inside = self.s * (motion.q[:, [self.joint]] - self.qs)
        return self.s * np.maximum(0.0, inside) ** self.m


def wave(k: float, q: Array) -> Array:
    """cos kq and sin kq: (N, 2)."""
    return np.column_stack([np.cos(k * q), np.sin(k * q)])


def waves(range_: Extent) -> list[float]:
    """Wave numbers k, from half a wave to 25 over the range, by halves, as far as the sampling shows them."""
    half = float(np.pi / range_.span)
    ks = [half * n for n in range(1, 2 * _MOST + 1)]
    return [k for k in ks if k * range_.top <= 0.5 * np.pi * range_.rate] or ks[:1]


EFFECTS: tuple[type[JointEffect], ...] = (FrictionRipple, TorqueRipple, Spring, CubicSpring, HardStop)
