"""What a fitted model leaves unexplained, as rows on which a new effect can be judged by one inner product.

The equations are those of `poly` on a wider band: columns made of positions and velocities are known beyond the band of
the accelerations. Rows are divided by the deviation of the noise at their joint and frequency, and made orthogonal to
the columns of the model, so that the gain of a candidate is the squared length of the residual along its columns.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.critique.variables import time_since_reversal
from chebid.dynamics import Dynamics
from chebid.effects import Effect, Motion
from chebid.effects.channel import TorqueDelay
from chebid.equations import Rows, measured_rows, moving
from chebid.equations.functions import Functions, moving_functions
from chebid.equations.span import orthonormal
from chebid.estimators.problem import Problem
from chebid.motion import Track, Used, make_track
from chebid.projection import Projection, from_bandwidth, project

_WIDER = 3.0  # times the band of the equations
_AT_LEAST = 20.0  # Hz
_NYQUIST = 0.4  # of the rate: the widest band of equations
_WIDEST = 0.35  # of the rate: the widest band of positions
_BANDS = 8  # of frequency, in which the noise of a joint is taken as constant
_OPEN = 2.0  # times the bandwidth that cross-validation chose for the positions
_EDGE = 0.7  # of the bandwidth: accelerations beyond are near the edge of the projection
_FADES = (0.02, 0.05, 0.15)  # s: how a drive that wound up against dry friction calms down
_EARLY = 2.5e-3  # s by which torques are logged early: half a control period of 200 Hz
_LATE = 0.55  # sampling periods by which torques are logged late, as means over the interval before; at most _EARLY
_DRAWS = 2  # of the noise of the positions
_SEEN = 1e-3  # share of a column's length that must be left beside the model's columns


@dataclass(frozen=True)
class Judged:
    """A candidate: `basis` (R, m) orthonormal whitened rows of its columns, `gain` = drop of the squared residual."""

    effect: Effect
    basis: Array
    gain: float


@dataclass(frozen=True)
class Held:
    """What is known of the parameters beforehand: values (P,) and covariance (P, P), in the order of the model's."""

    theta: Array
    covariance: Array


class Ground:
    """What all models of the same logs have in common: wide tracks, gate, band and test functions."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.tracks = [_widened(track, problem) for track in problem.tracks]
        self.gate = problem.gate
        rate = min(track.rate for track in self.tracks)
        self.band = min(max(_WIDER * problem.band.frequency, _AT_LEAST), _NYQUIST * rate)
        self.used = [moving(track, self.gate) for track in self.tracks]
        self.functions: list[list[Functions]] = [
            list(moving_functions(track, used, track.valid, self.band))
            for track, used in zip(self.tracks, self.used, strict=True)
        ]

    @cached_property
    def lost(self) -> list[list[Array]]:
        """Of every track, accelerations (N, J) of the kind that a projection takes off.

        What lies near its edge; and the jump that dry friction makes at every reversal, smoothed away by it.
        """
        return [[_edge(track), _jumps(track)] for track in self.tracks]

    @cached_property
    def counts(self) -> Array:
        """Step (J,) of the encoder of every joint, rad or m: the smallest change of its position."""
        return np.max([[_smallest_step(p.x) for p in track.projections] for track in self.tracks], axis=0)

    @cached_property
    def noises(self) -> list[list[Array]]:
        """Draws of the accelerations (N, J) of every track that noise of its positions makes."""
        random = np.random.default_rng(0)
        return [[_noise(track, random) for track in self.tracks] for _ in range(_DRAWS)]


class Evidence:
    """Whitened rows of a model on its logs: the model's columns, the residual, and the means to add columns.

    With `held`, the parameters are not free: what is known of them beforehand stands as P more rows below the others.
    `elsewhere`: these are not the logs of the fit, and know nothing of what happened once. `calm`: what joints do just
    after a reversal is no fault of the model.
    """

    def __init__(
        self,
        ground: Ground,
        dynamics: Dynamics | None = None,
        held: Held | None = None,
        *,
        elsewhere: bool = False,
        calm: bool = False,
    ) -> None:
        self.ground, self.elsewhere, self.calm = ground, elsewhere, calm
        self.dynamics = dynamics or ground.problem.dynamics
        self.rows: Rows = measured_rows(ground.tracks, self.dynamics, ground.gate, ground.band)
        self._held = held

    @cached_property
    def deviation(self) -> Array:
        """Deviation (R,) of the noise of each row."""
        return noise_profile(self.rows, self.rows.Y - self.rows.W @ self._start)

    @cached_property
    def _start(self) -> Array:
        weight = 1 / np.array([np.std(self.rows.Y[self.rows.joint == j]) + 1e-300 for j in range(self.rows.joints)])
        scale = weight[self.rows.joint]
        return np.asarray(np.linalg.lstsq(self.rows.W * scale[:, None], self.rows.Y * scale)[0])

    @cached_property
    def system(self) -> tuple[Array, Array]:
        """Whitened W (R, P) and Y (R,), with the rows of what is known beforehand."""
        W, Y = self.rows.W / self.deviation[:, None], self.rows.Y / self.deviation
        if self.elsewhere:
            W = W * self.dynamics.elsewhere(np.ones(W.shape[1]))
        if self._held is None:
            return W, Y
        root = _inverse_root(self._held.covariance)
        return np.vstack([W, root]), np.concatenate([Y, root @ self._held.theta])

    def padded(self, rows: NDArray[Any]) -> Array:
        """Rows (R0, ...) of the logs with zeros for those of what is known beforehand."""
        more = len(self.system[1]) - len(rows)
        return np.concatenate([rows, np.zeros((more, *rows.shape[1:]))]) if more else rows

    @cached_property
    def nuisance(self) -> Array:
        """Whitened columns (R, J) or (R, J + 1) of what is no fault of the model: the edge of the projection, and a
        torque that was logged a fraction of a control period early or late.
        """
        late = [self.late] if self.brief else []
        return np.hstack([self.edge, *late, *([self._jerk] if self.calm else [])])

    @cached_property
    def _jerk(self) -> Array:
        """Whitened columns (R, 3 J): torque of accelerations that fade after every reversal of a joint."""
        columns = []
        for motion, mass in zip(self.motions, self.mass, strict=True):
            count = motion.q.shape[1]
            parts = []
            for j in range(count):
                since, sign = time_since_reversal(motion, j), np.sign(motion.dq[:, j])
                own = np.arange(count) == j
                parts += [np.where(own, (sign * np.exp(-since / fade))[:, None], 0.0) for fade in _FADES]
            columns.append(np.stack([_times(mass, part) for part in parts], axis=2))
        return self.project(columns)

    @cached_property
    def brief(self) -> bool:
        """Whether the lag between torque and positions is that of logging, too short to be an effect.

        (Torque logged at the command's instant and held leads by half a control period, facts.md section 5.)
        """
        control = self.ground.problem.model.control
        held = 0.5 / control.rate if control else 0.0
        late = max(min(_LATE / min(track.rate for track in self.ground.tracks), _EARLY), held)
        return self.lag is not None and -max(_EARLY, held) <= self.lag <= late

    @cached_property
    def lag(self) -> float | None:
        """Seconds by which the torques are late; None where the motion cannot tell."""
        basis = orthonormal(np.hstack([self.system[0], self.edge]))
        column = self.late[:, 0] - basis @ (basis.T @ self.late[:, 0])
        length = float(column @ column)
        return float(column @ self.system[1]) / length if length > 0 else None

    @cached_property
    def late(self) -> Array:
        """Whitened column (R, 1) of a torque logged late."""
        return self.columns(TorqueDelay(None))

    @cached_property
    def model(self) -> Array:
        """Orthonormal basis (R, P + J) of the whitened columns of the model and of what is no fault of it."""
        return orthonormal(np.hstack([self.system[0], self.nuisance]))

    @cached_property
    def edge(self) -> Array:
        """Whitened rows (R, 2 J): torque of accelerations that the projection of each joint has taken off.

        They look like a flexible joint, or like Stribeck friction; with these columns in the model they cannot.
        """
        columns = []
        for lost, mass in zip(self.ground.lost, self.mass, strict=True):
            # of each joint alone: its column of the mass matrix
            columns.append(np.concatenate([mass * part[:, None, :] for part in lost], axis=2))
        return self.project(columns)

    @cached_property
    def mass(self) -> list[Array]:
        """Mass matrices (N, J, J) along the motion of every track: the torque is affine in the accelerations."""
        regressor, theta = self.dynamics.robot.regressor, self.dynamics.rigid(self.theta)
        out = []
        for motion in self.motions:
            base = regressor(motion.q, motion.dq, motion.ddq) @ theta
            units = np.eye(motion.q.shape[1])
            parts = [regressor(motion.q, motion.dq, motion.ddq + unit) @ theta - base for unit in units]
            out.append(np.stack(parts, axis=2))
        return out

    @cached_property
    def residual(self) -> Array:
        """Whitened residual (R,)."""
        return self._unexplained(self.system[1])

    def _unexplained(self, y: Array) -> Array:
        """What the columns of the model leave of whitened rows (R,)."""
        return y - self.model @ (self.model.T @ y)

    def shaken(self, noise: Sequence[Array], random: np.random.Generator) -> tuple[list[Motion], Array]:
        """The worst that errors of the accelerations could do: motions with the noise (N, J) of every track, and a
        residual (R,) of the torque of this and of white noise, as large in every band as that of the logs.
        """
        torque = self.project([-_times(*pair)[:, :, None] for pair in zip(self.mass, noise, strict=True)])[:, 0]
        label, count = self._band, len(self._band)
        have, own = (np.bincount(label, x[:count] ** 2) for x in (self.residual, torque))
        part = np.sqrt(np.minimum(1.0, have / np.maximum(own, np.finfo(float).tiny)))
        white = np.sqrt(np.maximum(have - part**2 * own, 0.0) / np.bincount(label))
        drawn = part[label] * torque[:count] + white[label] * random.standard_normal(count)
        moved = [replace(motion, ddq=motion.ddq + more) for motion, more in zip(self.motions, noise, strict=True)]
        return moved, self._unexplained(self.padded(drawn))

    @cached_property
    def theta(self) -> Array:
        """Parameters (P,) of the model on these rows."""
        return np.asarray(np.linalg.lstsq(*self.system)[0])

    @cached_property
    def motions(self) -> list[Motion]:
        """The motion of every track, with the model's own torque in it."""
        return [self.dynamics.prepare(track.motion, self.theta) for track in self.ground.tracks]

    @cached_property
    def trusted(self) -> Motion:
        """All samples that are used on some joint, for the ranges of hyper-parameters."""
        parts = []
        for used, motion in zip(self.ground.used, self.motions, strict=True):
            at = np.flatnonzero(np.any(used, axis=1))
            tau = motion.tau if motion.tau is not None else self.dynamics.torque(motion, self.theta)
            parts.append([x[at] for x in (motion.t, motion.q, motion.dq, motion.ddq, tau)])
        t, q, dq, ddq, tau = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return Motion(t, q, dq, ddq, tau, self.dynamics.rigid(self.theta))

    def project(self, columns: Sequence[Array]) -> Array:
        """Whitened rows (R, K) of columns (N, J, K) given for every track."""
        return self.padded(self._whitened(columns))

    def _whitened(self, columns: Sequence[Array]) -> Array:
        out = []
        for functions, x in zip(self.ground.functions, columns, strict=True):
            made = [f.rows(x[f.piece]) for f in functions]
            out.append(np.concatenate([part[j] for j in range(self.rows.joints) for part in made]))
        return np.concatenate(out) / self.deviation[:, None]

    def left_beside(self, columns: Array) -> dict[str, float]:
        """By joint: share of the rms error of the model (band of the fit) that whitened columns (R, K) leave."""
        W, Y = self.system
        inside = self.rows.frequency <= self.ground.problem.band.frequency
        bases = orthonormal(W), orthonormal(np.hstack([W, columns]))
        parts = [(Y - basis @ (basis.T @ Y))[: len(inside)] * self.deviation for basis in bases]
        out = {}
        for j, name in enumerate(self.dynamics.joints):
            at = inside & (self.rows.joint == j)
            whole, left = (float(np.linalg.norm(part[at])) for part in parts)
            out[name] = min(left / whole, 1.0) if whole else 1.0
        return out

    def error(self, theta: Array) -> list[Array]:
        """The part (N, J) of the error of every track, under theta (P,), that lies within the band; N.m or N."""
        out = []
        for track, motion, functions in zip(self.ground.tracks, self.motions, self.ground.functions, strict=True):
            raw = track.torque - self.dynamics.torque(motion, theta)
            banded = np.zeros_like(raw)
            for f in functions:
                rows = f.rows(raw[f.piece][:, :, None])
                for j, mix in enumerate(f.mix):
                    banded[f.piece, j] = f.basis @ (mix.T @ rows[j][:, 0])
            out.append(banded)
        return out

    @cached_property
    def present(self) -> frozenset[tuple[str, int | None]]:
        """Name and joint of the effects that the model has."""
        return frozenset((effect.name, effect.joint) for effect in self.dynamics.effects)

    def columns(self, effect: Effect) -> Array:
        """Whitened rows (R, k) of an effect, per unit of each parameter."""
        made = self.project([self.dynamics.block(effect, motion) for motion in self.motions])
        return np.zeros_like(made) if self.elsewhere and effect.once else made

    def beside(self, rows: Array) -> Array:
        """Orthonormal basis (R, m) of what whitened rows (R, K) have beside the model's columns."""
        length = np.linalg.norm(rows, axis=0)
        rows = rows[:, length > 0] / length[length > 0]
        left = rows - self.model @ (self.model.T @ rows)
        if left.shape[1] == 0:
            return left
        u, singular, _ = np.linalg.svd(left, full_matrices=False)
        return u[:, singular > _SEEN]

    def worth(self, basis: Array, residual: Array | None = None) -> float:
        """ln of how much likelier the logs are with the columns of a basis (R, m), at their best values.

        The noise of every joint and band of frequency is fitted too: what no model explains is no noise of known size.
        Another residual (R,) than that of the logs may be given.
        """
        before, after = self._energies(basis, residual)
        count = np.bincount(self._band)
        known = (before[-1] - after[-1]) / 2
        there = (before[:-1] > 0) & (after[:-1] > 0)
        return float(known + np.sum(count[there] / 2 * np.log(before[:-1][there] / after[:-1][there])))

    def share(self, basis: Array) -> float:
        """Largest share, over the joints, of the squared residual that the columns of a basis (R, m) take away."""
        before, after = self._energies(basis)
        first, last = (np.bincount(self._owner, energy[:-1]) for energy in (before, after))
        there = first > 0
        return float(np.max(1 - last[there] / first[there], initial=0.0))

    def _energies(self, basis: Array, residual: Array | None = None) -> tuple[Array, Array]:
        """Squared residual by joint and band without and with the columns; the last of what is known beforehand."""
        before = self.residual if residual is None else residual
        after = before - basis @ (basis.T @ before)
        count = int(self._band.max()) + 2
        label = np.concatenate([self._band, np.full(len(before) - len(self._band), count - 1)])
        return np.asarray(np.bincount(label, before**2, count)), np.asarray(np.bincount(label, after**2, count))

    @cached_property
    def _band(self) -> NDArray[np.int64]:
        """Number (R0,) of the joint and band of frequency of each row."""
        out = np.zeros(len(self.rows.Y), dtype=np.int64)
        for number, (_, part) in enumerate(bands(self.rows)):
            out[part] = number
        return out

    @cached_property
    def _owner(self) -> NDArray[np.int64]:
        """Joint of every band."""
        return np.array([joint for joint, _ in bands(self.rows)], dtype=np.int64)

    def judge(self, effect: Effect) -> Judged:
        """A candidate on these rows."""
        rows = self.columns(effect)
        if self._impossible(effect, rows):
            return Judged(effect, np.zeros((len(rows), 0)), 0.0)
        basis = self.beside(rows)
        return Judged(effect, basis, float(np.sum((basis.T @ self.residual) ** 2)))

    def _impossible(self, effect: Effect, rows: Array) -> bool:
        """Whether an effect with one parameter would need a sign that it cannot have in nature."""
        if rows.shape[1] != 1 or not effect.one_way:
            return False
        known = (effect.name, effect.joint) in self.present
        return not known and float(rows[:, 0] @ self.residual) < 0


def _times(mass: Array, ddq: Array) -> Array:
    """Torque (N, J) that accelerations (N, J) take."""
    return np.asarray(np.einsum("nji,ni->nj", mass, ddq))


def _inverse_root(covariance: Array) -> Array:
    """R with R^T R the inverse of a covariance (P, P)."""
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray((vectors / np.sqrt(np.maximum(values, 1e-12))).T / scale)


def _widened(track: Track, problem: Problem) -> Track:
    """The track with its positions passed up to twice their bandwidth.

    Cross-validation balances the noise of the positions against what it takes off them. Here the two are not alike: the
    noise that comes in is random, and counts as noise; what is taken off follows the motion, and looks like an effect.
    """
    used = [
        Used(from_bandwidth(p.t, min(_OPEN * p.plan.bandwidth, _WIDEST * track.rate), "smooth"), track.record.duration)
        for p in track.projections
    ]
    trim = problem.model.processing.trim
    delay = problem.model.log.torque_delay
    wider = make_track(track.log, track.record, problem.setting, plans=tuple(used), delay=delay, trim=trim)
    return replace(wider, signs=track.signs, left_out=track.left_out)


def _edge(track: Track) -> Array:
    """Accelerations (N, J) between 0.7 of the bandwidth and all of it."""
    return track.motion.ddq - np.column_stack([_below(p, track.motion.t) for p in track.projections])


def _smallest_step(x: Array) -> float:
    steps = np.abs(np.diff(x))
    moved = steps[steps > 1e-9 * max(float(np.ptp(x)), np.finfo(float).tiny)]  # not the rounding of a gain
    return float(moved.min()) if moved.size else 0.0


def _noise(track: Track, random: np.random.Generator) -> Array:
    """A draw of the accelerations (N, J) that noise of the positions, as large as that found, makes."""
    drawn = [
        project(p.t, p.noise * random.standard_normal(len(p.t)), p.plan, p.name).at(track.motion.t, 2)
        for p in track.projections
    ]
    return np.column_stack(drawn)


def _jumps(track: Track) -> Array:
    """A unit jump (N, J) of acceleration at every reversal, less what the projection passes of it."""
    sign = np.sign(track.motion.dq)
    passed = [project(p.t, np.sign(p.at(p.t, 1)), p.plan, p.name).at(track.motion.t, 0) for p in track.projections]
    return sign - np.column_stack(passed)


def _below(projection: Projection, t: Array) -> Array:
    """Acceleration (N,) of the same signal projected on 0.7 of the bandwidth."""
    plan = from_bandwidth(projection.t, _EDGE * projection.plan.bandwidth, "smooth")
    return project(projection.t, projection.x, plan, projection.name).at(t, 2)


def bands(rows: Rows) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Joints, each in bands of frequency of as many rows: (joint, indices)."""
    for j in range(rows.joints):
        mine = np.flatnonzero(rows.joint == j)
        order = mine[np.argsort(rows.frequency[mine], kind="stable")]
        for part in np.array_split(order, min(_BANDS, max(1, len(order) // 24))):
            yield j, part


def noise_profile(rows: Rows, residual: Array) -> Array:
    """Deviation (R,) of the noise of each row, from a residual (R,): by joint and band of frequency, smoothed."""
    out = np.empty(len(residual))
    parts = list(bands(rows))
    for j in range(rows.joints):
        mine = np.flatnonzero(rows.joint == j)
        own = [part for joint, part in parts if joint == j]
        # the median of squares: a few rows with a missing effect in them do not make the noise
        level = np.sqrt([np.median(residual[part] ** 2) / 0.455 for part in own])
        centre = [float(np.mean(rows.frequency[part])) for part in own]
        out[mine] = np.interp(rows.frequency[mine], centre, np.maximum(level, 1e-9 * np.max(level) + 1e-300))
    return out
