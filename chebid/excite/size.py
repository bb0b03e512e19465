"""How large each rival is, if it is the one, and the noise it is seen against.

Where the logs of the model's fit are at hand, every rival is fitted on them together with the model: what it explains
there is its torque. Otherwise, and where it explains nothing there, it is as strong as the torque noise: what of it the
model cannot explain has the rms of the noise, on random motions within the limits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from chebid.dynamics import Dynamics
from chebid.effects import Effect, Motion
from chebid.equations import moving, project_columns
from chebid.equations.span import orthonormal
from chebid.estimators import Problem
from chebid.excite.contest import Contest, Piece, Truth, beside
from chebid.excite.refine import refine
from chebid.excite.rivals import Rival
from chebid.log import file_sha256, read_log
from chebid.model import Model, per_joint
from chebid.robots import Array

_SHARE = 0.03  # of the torque's rms: noise, where nobody knows better
_SEEN = 4.0  # log likelihood that a rival must gain on the logs for them to tell its size
_CLOSE = 4.0  # log likelihood by which other settings may fall behind the best
_SETTINGS = 3  # of a rival, as which it may be the truth
_SAMPLES = 4000  # of the logs that are used to tell how well they separate


@dataclass(frozen=True)
class Noise:
    """Deviation (J,) of the torque noise of a sample, N.m or N, and where it is known from."""

    deviation: Array
    source: str


class FittedOn:
    """The logs of a model's fit, and the model on them."""

    def __init__(self, model: Model, paths: Sequence[Path]) -> None:
        logs = tuple(read_log(path, model.log, model.joints, need_torque=True) for path in paths)
        self.problem = Problem(model, logs, used=model.fit.treatment if model.fit else None)
        rows = self.problem.rows
        theta = np.linalg.lstsq(rows.W, rows.Y)[0]
        spread = [float(np.std((rows.Y - rows.W @ theta)[rows.joint == j])) + 1e-300 for j in range(rows.joints)]
        self._weight = 1 / np.array(spread)[rows.joint]
        self.theta: Array = np.asarray(np.linalg.lstsq(rows.W * self._weight[:, None], rows.Y * self._weight)[0], float)
        self._basis = orthonormal(rows.W * self._weight[:, None])
        self._residual = beside(self._basis, rows.Y * self._weight)
        dynamics = self.problem.dynamics
        self.motions = [dynamics.prepare(track.motion, self.theta) for track in self.problem.tracks]

    def noise(self) -> Array:
        """(J,) of a sample, from what the model leaves in and out of the band."""
        return np.array([np.sqrt(n.energy(self.theta) / max(n.samples, 1)) for n in self.problem.rows.noise])

    def pieces(self, noise: Array) -> list[Piece]:
        """The motions, in at most some thousand samples."""
        total = sum(len(motion) for motion in self.motions)
        step = -(-total // _SAMPLES)
        used = [moving(track, self.problem.gate) for track in self.problem.tracks]
        return [
            Piece(motion, np.where(at, np.sqrt(step) / noise, 0.0), step)
            for motion, at in zip(self.motions, used, strict=True)
        ]

    def trusted(self) -> Motion:
        """All samples that are used on some joint."""
        parts = []
        for track, motion in zip(self.problem.tracks, self.motions, strict=True):
            at = np.flatnonzero(moving(track, self.problem.gate).any(axis=1))
            tau = motion.tau if motion.tau is not None else self.problem.dynamics.torque(motion, self.theta)
            parts.append([x[at] for x in (motion.t, motion.q, motion.dq, motion.ddq, tau)])
        t, q, dq, ddq, tau = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return Motion(t, q, dq, ddq, tau)

    def columns(self, effect: Effect) -> Array:
        """Weighted rows (R, k)."""
        problem = self.problem
        parts = [
            project_columns(track, problem.gate, problem.band.frequency, problem.dynamics.block(effect, motion))
            for track, motion in zip(problem.tracks, self.motions, strict=True)
        ]
        return np.concatenate(parts) * self._weight[:, None]

    def gain(self, effect: Effect) -> float:
        """Log likelihood that an effect adds to the model's."""
        before, (values, after) = self._residual, self._left(effect)
        if effect.one_way and values[0] < 0:
            return 0.0
        joint = self.problem.rows.joint
        return sum(
            float((joint == j).sum() / 2 * np.log(np.sum(before[joint == j] ** 2) / np.sum(after[joint == j] ** 2)))
            for j in range(self.problem.rows.joints)
            if np.any(after[joint == j])
        )

    def _left(self, effect: Effect) -> tuple[Array, Array]:
        """Values (k,) of an effect at their best, and the residual (R,)."""
        columns = beside(self._basis, self.columns(effect))
        length = np.linalg.norm(columns, axis=0) + 1e-300
        values = np.linalg.lstsq(columns / length, self._residual, rcond=1e-9)[0] / length
        return values, self._residual - columns @ values

    def truths(self, number: int, rival: Rival) -> list[Truth]:
        """The rival as these logs show it: its best settings and others nearly as good; none if it explains nothing."""
        gate = float(self.problem.gate[rival.joint or 0])
        trusted = self.trusted()
        gains = [(self.gain(effect), effect) for effect in rival.settings(trusted, gate)]
        if not gains or max(gain for gain, _ in gains) < _SEEN:
            return []
        most, best = max(gains, key=lambda pair: pair[0])
        best = refine(best, lambda effect: -self.gain(effect), trusted, gate)
        near = [effect for gain, effect in gains if gain > most - _CLOSE]
        chosen = dict.fromkeys([best, *_spread(near, _SETTINGS - 1)])
        return [Truth(number, effect, self._left(effect)[0], True) for effect in chosen]


def find_logs(model: Model) -> list[Path]:
    """The logs of a model's fit that lie beside the model file or in the working directory, unchanged."""
    record = model.fit.record.model_dump() if model.fit else {}
    found = []
    for entry in record.get("logs") or []:
        if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
            continue
        for folder in (model.path.parent, Path()):
            path = folder / Path(entry["file"]).name
            if path.is_file() and file_sha256(path) == entry.get("sha256"):
                found.append(path)
                break
    return found


def find_noise(model: Model, dynamics: Dynamics, motions: Sequence[Motion], logs: FittedOn | None) -> Noise:
    """From `sensors:`, else from the logs of the fit, else a share of the torque on random motions."""
    count = len(model.joints)
    if model.sensors is not None and all(value > 0 for value in per_joint(model.sensors.torque_noise, count)):
        return Noise(np.array(per_joint(model.sensors.torque_noise, count)), "sensors: torque_noise")
    if logs is not None:
        return Noise(logs.noise(), "what the model leaves of its logs")
    if dynamics.reference is None:
        return Noise(np.ones(count), "not known: 1 on every joint")
    theta = np.array([dynamics.reference.get(p.name, 0.0) for p in dynamics.parameters])
    square = np.mean([np.mean(dynamics.torque(motion, theta) ** 2, axis=0) for motion in motions], axis=0)
    return Noise(_SHARE * np.sqrt(np.maximum(square, 1e-300)), f"{_SHARE:.0%} of the torque on random motions")


def as_noise(number: int, contest: Contest, pieces: Sequence[Piece]) -> list[Truth]:
    """A rival as strong as the noise on these motions, with a few of its settings."""
    basis = orthonormal(contest.model_rows(pieces))
    samples = sum(len(piece.motion) for piece in pieces)
    out = []
    for effect in _spread(list(contest.settings[number]), _SETTINGS):
        left = beside(basis, contest.effect_rows(effect, pieces))
        length = np.linalg.norm(left, axis=0) + 1e-300
        _, singular, directions = np.linalg.svd(left / length, full_matrices=False)
        size = np.sqrt(samples) / max(float(singular[0]), 1e-12)
        values = size * directions[0] / length
        positive = [symbol in effect.positive for symbol in effect.bind(contest.dynamics.robot).symbols]
        out.append(Truth(number, effect, -values if values[positive].sum() < 0 else values))
    return out


def _spread(effects: list[Effect], most: int) -> list[Effect]:
    """At most so many, evenly along the list."""
    if len(effects) <= most:
        return effects
    return [effects[i] for i in np.linspace(0, len(effects) - 1, most).round().astype(int)]
