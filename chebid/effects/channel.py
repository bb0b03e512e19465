"""What the torque channel does to a torque that the model has right: delay, gain, clipping."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chebid.effects.effect import ArmEffect, Effect, Grid, JointEffect
from chebid.effects.hyper import setting
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array

_LAGS = (0.003, 0.006, 0.012, 0.025, 0.05)  # s
_BESIDE = 3  # samples at each side
_CLOSE = 2e-3  # of the limit: samples that near are at it


@dataclass(frozen=True)
class TorqueDelay(ArmEffect):
    """-delay d(model's torque)/dt on all joints: the torque column lags the motion.

    A lag that is not short beside the motion wants the difference over a time `d` instead of the derivative; where the
    torque is no more than late, the delay comes out as `d`.
    """

    d: float | None = setting("time over which the change of the torque is taken; its derivative if absent", "s", None,
                              above=0)  # fmt: skip
    name = "torque_delay"
    formula = "-delay d(model's torque)/dt, or -delay (its change over d)/d, all joints"
    sentence = "the logged torque comes later than the motion it belongs to"
    kind = "channel"
    symbols = ("delay",)
    alike = ("joint_flexibility",)
    memory = True

    @property
    def needs_model(self) -> bool:
        return True

    @property
    def forward(self) -> str:
        return ""  # the log is delayed, not the robot

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Short, and lags of several samples."""
        step = float(np.median(np.diff(motion.t)))
        return [{}] + [{"d": d} for d in _LAGS if d >= 2 * step]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        return {"d": (_LAGS[0] / 2, 2 * _LAGS[-1])}

    def units(self, units: Units) -> tuple[str, ...]:
        return ("s",)

    def block(self, motion: Motion) -> Array:
        assert motion.tau is not None, "Dynamics completes the motion"
        if self.d is None:
            return -np.gradient(motion.tau, motion.t, axis=0)[:, :, None]
        before = np.column_stack([np.interp(motion.t - self.d, motion.t, tau) for tau in motion.tau.T])
        return (before - motion.tau)[:, :, None] / self.d


class TorqueGain(JointEffect):
    """g times the model's torque: shows only where other joints fix the scale."""

    name = "torque_gain"
    formula = "g (model's torque)"
    sentence = "the torque channel of this joint is scaled: a wrong torque constant, current gain or gear ratio"
    kind = "channel"
    symbols = ("g",)
    alike = ("load_friction",)

    @property
    def needs_model(self) -> bool:
        return True

    def units(self, units: Units) -> tuple[str, ...]:
        return ("1",)

    def columns(self, motion: Motion) -> Array:
        assert motion.tau is not None, "Dynamics completes the motion"
        return motion.tau[:, [self.joint]]


@dataclass(frozen=True)
class Saturation(JointEffect):
    """The drive clips: no torque of its own, but samples that say nothing about the robot (`mask`)."""

    limit: float = setting("largest torque of the drive", "torque", above=0)
    name = "saturation"
    formula = "samples at the limit are left out"
    sentence = "the drive is at its limit: these samples show the limit and not the robot"
    kind = "channel"
    symbols = ()
    linear = False

    @property
    def forward(self) -> str:
        return ""  # a limit of the drive

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Nothing: the limit shows in the measured torque (`find_limit`), not in the motion."""
        return []

    def units(self, units: Units) -> tuple[str, ...]:
        return ()

    def columns(self, motion: Motion) -> Array:
        return np.zeros((len(motion), 0))

    def mask(self, motion: Motion, measured: Array) -> NDArray[np.bool_]:
        """(N,): the samples of measured torque (N, J) that are clipped on this joint, and their neighbours.

        Noise that came after the clipping hides half of them.
        """
        at = np.abs(measured[:, self.joint]) >= (1 - _CLOSE) * self.limit
        return np.convolve(at, np.ones(2 * _BESIDE + 1), "same") > 0.5


def find_limit(measured: Array, share: float = 0.002) -> float | None:
    """The limit at which a measured torque (N,) is clipped, or None.

    Clipping piles samples up at the largest absolute value: more than `share` of all, in runs of three at least, and
    five times as many as in the next layer of the same thickness below.
    """
    size = np.abs(measured[np.isfinite(measured)])
    if size.size < 20 or not size.max() > 0:
        return None
    most = float(size.max())
    top = size >= (1 - _CLOSE) * most
    below = (size >= (1 - 2 * _CLOSE) * most) & ~top
    held = top[2:] & top[1:-1] & top[:-2]
    return most if top.mean() > share and held.any() and top.sum() >= 5 * (below.sum() + 1) else None


def saturated(effects: tuple[Effect, ...], motion: Motion, measured: Array) -> NDArray[np.bool_]:
    """(N, J): samples of the measured torque (N, J) that effects say to leave out."""
    out: NDArray[Any] = np.zeros(measured.shape, dtype=bool)
    for effect in effects:
        if isinstance(effect, Saturation):
            out[:, effect.joint] |= effect.mask(motion, measured)
    return out


EFFECTS: tuple[type[Effect], ...] = (TorqueDelay, TorqueGain, Saturation)
