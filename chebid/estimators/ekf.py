"""`ekf`: extended Kalman filter on state and parameters (Gautier and Poignet, Control Eng. Pract. 9, 2001).

State (q, dq, theta), theta constant; the measured torque drives the model, the measured positions correct it. The prior
is the model file's fit, with `methods: ekf: prior:` as its relative standard deviation. The torque's noise, which
drives the state, is that of the rows of `poly`: what noise of the projected accelerations adds out of band is no
torque; a joint below its velocity gate gets the whole of its friction as
uncertainty, because nobody knows where it points.

The filter passes over the logs several times, always from the same prior, each time linearised about the parameters
of the time before: linearised about a prior that is 30 % off, it would take its result for much surer than it is. In
q and dq the dynamics are taken to first order about the projected motion, all instants at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.effects import Motion
from chebid.errors import InputError, NoAnswerError, Place
from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import EkfSettings, method_settings
from chebid.estimators.weighted import Solution, solve
from chebid.motion import Mask, Track

_STEP = 1e-6  # relative step of the differences that linearise the motion
_LONGEST = 1e-2  # s of one integration step
_HELD = 1_000_000  # numbers of the linearised dynamics that are held at a time
_PASSES = 3  # the motion is linearised about the estimate of the pass before


def ekf(problem: Problem) -> Estimate:
    """Estimate by filtering. Raises InputError without a prior, NoAnswerError when the filter diverges."""
    settings = method_settings(problem.model, "ekf", EkfSettings)
    rows, dynamics = problem.rows, problem.dynamics
    first = solve(rows, dynamics.parameters)
    prior = _prior(problem)
    spread = settings.prior * np.abs(prior)
    variance = np.where(spread > 0, spread, settings.prior * np.max(spread)) ** 2
    if not dynamics.needs_model:
        dynamics = replace(dynamics, reference=None)
    about: Array | None = None
    for _ in range(_PASSES):
        mean, covariance = prior, np.diag(variance)
        innovations: list[Array] = []
        for track in problem.tracks:
            filter_ = _Filter(dynamics, track, problem.gate, first.sigma, about)
            mean, covariance = filter_.run(mean, covariance)
            innovations += filter_.innovations
        about = mean
    if not np.all(np.isfinite(mean)):
        raise NoAnswerError("the filter diverged", hint="give a better prior in the fit: section, or use --method poly")
    honest = _honest(covariance, variance, first) * _inflation(np.array(innovations))
    return assemble(
        problem,
        "ekf",
        Solution(mean, honest, covariance, first.sigma, first.condition),
        rows,
        {
            "equation_bandwidth": problem.band.frequency,
            "ekf": {"prior": settings.prior, "prior_sd": list(np.sqrt(variance))},
        },
    )


def _prior(problem: Problem) -> Array:
    fit = problem.model.fit
    names = [p.name for p in problem.dynamics.parameters]
    if fit is None or any(name not in fit.parameters for name in names):
        raise InputError(
            "the method ekf needs prior values of all parameters",
            hint="identify with --method poly -o FITTED first and give FITTED as the model, or write a fit: section",
            place=Place(file=str(problem.model.path), key="fit.parameters"),
        )
    return np.array([fit.parameters[name].value for name in names])


def _honest(covariance: Array, prior: Array, first: Solution) -> Array:
    """The covariance when the torque's noise is not white: what it does to the deviations of `poly`, it does here.

    The filter weighs the prior, of variances `prior` (P,), and the data by their information.
    """
    information = np.linalg.inv(covariance)
    data = information - np.diag(1 / prior)
    factor = np.sqrt(np.diag(first.covariance) / np.diag(first.white))
    coloured = data @ (np.linalg.pinv(data, hermitian=True) * np.outer(factor, factor)) @ data
    return np.asarray(covariance @ (np.diag(1 / prior) + coloured) @ covariance)


def _inflation(innovations: Array) -> float:
    """Factor on the covariance: mean square of the whitened innovations, never below one."""
    kept = innovations[len(innovations) // 10 :]
    return max(1.0, float(np.mean(kept**2)))


@dataclass(frozen=True)
class _Steps:
    """The dynamics to first order about the projected motion, in the middle of each of K steps.

    The torque is sum_i w_i (T_i + dT_i off) theta with w = (1, ddq), `off` the projected motion. `start` (K, 2J): that
    motion at the step's start, `tables` (K, 1 + J, J, P): T, `slopes` (K, 1 + J, J, P, 2J): dT, `tau` (K, J): torque,
    `drive` (K, J, P): the rows by whose theta friction may be wrong, zero where its direction is known. `rest` (K, 2J):
    what the midpoint rule leaves out of the step of q and dq, along the projected motion; at 100 Hz it would bias LMX2
    by its standard deviation.
    """

    start: Array
    tables: Array
    slopes: Array
    tau: Array
    drive: Array
    rest: Array


def _steps(dynamics: Dynamics, track: Track, gate: Array, t: Array) -> Iterator[_Steps]:
    """Steps between instants t (K + 1,), some at a time."""
    middle = (t[1:] + t[:-1]) / 2
    projected = [np.column_stack([p.at(middle, k) for p in track.projections]) for k in range(3)]
    edges, rest = _edges(track, t, projected[2])
    known = np.isfinite(track.torque).all(axis=1)
    tau = CubicSpline(track.motion.t[known], track.torque[known])(middle)
    joints, width = tau.shape[1], len(dynamics.parameters)
    chunk = max(16, _HELD // ((1 + joints) * (1 + 2 * joints) * joints * width))
    for start in range(0, len(middle), chunk):
        piece = slice(start, start + chunk)
        q, dq, ddq = (x[piece] for x in projected)
        tables, slopes = _tables(dynamics, middle[piece], q, dq)
        # within a step of a reversal, the torque's samples hold both directions of friction
        slow = np.abs(dq) < gate + np.abs(ddq) * np.diff(t)[piece, None]
        drive = np.where(slow[:, :, None], _friction(dynamics, middle[piece], q, gate), 0.0)
        yield _Steps(edges[piece], tables, slopes, tau[piece], drive, rest[piece])


def _edges(track: Track, t: Array, ddq: Array) -> tuple[Array, Array]:
    """q and dq (K, 2J) at the starts of steps between t (K + 1,), and their steps less those of a midpoint rule."""
    q, dq = (np.column_stack([p.at(t, k) for p in track.projections]) for k in range(2))
    h = np.diff(t)[:, None]
    rest = [np.diff(q, axis=0) - h * dq[:-1] - h**2 / 2 * ddq, np.diff(dq, axis=0) - h * ddq]
    return np.hstack([q, dq])[:-1], np.hstack(rest)


def _tables(dynamics: Dynamics, t: Array, q: Array, dq: Array) -> tuple[Array, Array]:
    """T (K, 1 + J, J, P) and its derivatives (K, 1 + J, J, P, 2J) by q and dq."""
    count, joints = q.shape
    state = np.hstack([q, dq])
    step = _STEP * np.maximum(1.0, np.abs(state))
    # a difference in velocity goes away from zero: it must not cross a reversal of friction
    step[:, joints:] *= np.where(dq < 0, -1.0, 1.0)
    moved = state + np.vstack([np.zeros((1, 2 * joints)), np.eye(2 * joints)])[:, None, :] * step
    unit = np.vstack([np.zeros((1, joints)), np.eye(joints)])
    shape = (1 + 2 * joints, 1 + joints, count)
    times, states = np.broadcast_to(t, shape), np.broadcast_to(moved[:, None], (*shape, 2 * joints))
    accelerations = np.broadcast_to(unit[None, :, None, :], (*shape, joints))
    flat = states.reshape(-1, 2 * joints)
    motion = Motion(times.ravel(), flat[:, :joints], flat[:, joints:], accelerations.reshape(-1, joints))
    torque = dynamics.regressor(motion).reshape(*shape, joints, -1)
    torque[:, 1:] -= torque[:, :1]
    slopes = (torque[1:] - torque[0]) / step.T[:, None, :, None, None]
    return np.moveaxis(torque[0], 1, 0), np.ascontiguousarray(np.moveaxis(slopes, (0, 2), (4, 0)))


def _friction(dynamics: Dynamics, t: Array, q: Array, gate: Array) -> Array:
    """Rows (K, J, P) of half the torque that changes sign with the velocity."""
    speed, none = np.broadcast_to(np.maximum(gate, 1e-9), q.shape), np.zeros(q.shape)
    forward, backward = (dynamics.regressor(Motion(t, q, sign * speed, none)) for sign in (1.0, -1.0))
    return (forward - backward) / 2


@dataclass
class _Filter:
    """One pass over a record. `about` (P,): parameters about which the motion is linearised; None: the estimate."""

    dynamics: Dynamics
    track: Track
    gate: Array
    torque_noise: Array
    about: Array | None = None

    def __post_init__(self) -> None:
        self.innovations: list[Array] = []
        self.joints = len(self.gate)
        noise = np.array([p.noise for p in self.track.projections])
        self.R = np.diag(np.maximum(noise, 1e-12) ** 2)

    def run(self, theta: Array, covariance: Array) -> tuple[Array, Array]:
        """Parameters and their covariance after the record, from those before it."""
        track, joints = self.track, self.joints
        used = np.flatnonzero(track.valid)
        first, last = used[0], used[-1]
        t, q = track.record.t[first : last + 1], track.record.q[first : last + 1]
        # steps of a sample share its noise
        self.held = count = int(np.ceil((t[-1] - t[0]) / (len(t) - 1) / _LONGEST - 1e-3))
        fine = np.interp(np.arange(count * (len(t) - 1) + 1) / count, np.arange(len(t)), t)
        start = [np.array([p.at(t[:1], k)[0] for p in track.projections]) for k in range(2)]
        x = np.concatenate([*start, theta])
        P = np.zeros((len(x), len(x)))
        P[:joints, :joints] = self.R
        P[joints : 2 * joints, joints : 2 * joints] = np.diag((0.02 * np.abs(track.motion.dq).max(axis=0)) ** 2)
        P[2 * joints :, 2 * joints :] = covariance
        seen: Mask = np.asarray(np.isfinite(q).all(axis=1))
        done, steps = 0, np.diff(fine)
        for part in _steps(self.dynamics, track, self.gate, fine):
            for k in range(len(part.tau)):
                x, P = self._predict(x, P, float(steps[done]), part, k)
                done += 1
                if done % count == 0 and seen[done // count]:
                    x, P = self._correct(x, P, q[done // count])
        return x[2 * joints :], P[2 * joints :, 2 * joints :]

    def _correct(self, x: Array, P: Array, q: Array) -> tuple[Array, Array]:
        joints = self.joints
        root = np.linalg.cholesky(P[:joints, :joints] + self.R)
        whitened = np.linalg.solve(root, np.column_stack([P[:joints], q - x[:joints]]))
        gain, innovation = whitened[:, :-1], whitened[:, -1]
        self.innovations.append(innovation)
        P = P - gain.T @ gain
        return x + gain.T @ innovation, (P + P.T) / 2

    def _predict(self, x: Array, P: Array, h: float, steps: _Steps, k: int) -> tuple[Array, Array]:
        """One midpoint step."""
        joints = self.joints
        q, v = slice(joints), slice(joints, 2 * joints)
        off = x[: 2 * joints] - steps.start[k]  # from the projected motion: hardly changes within a step
        off[q] += h / 2 * off[v]
        ddq, J, inverse = self._acceleration(off, x[2 * joints :], steps, k)
        out = x.copy()
        out[q] += h * x[v] + h * h / 2 * ddq
        out[v] += h * ddq
        out[: 2 * joints] += steps.rest[k]
        F = np.eye(len(x))
        F[v] += h * J
        F[v, v] += h * h / 2 * J[:, q]
        F[q] += h * h / 2 * J
        F[q, v] += h * np.eye(joints)
        G = np.vstack([h * h / 2 * inverse, h * inverse])
        noise = self.held * np.maximum(self.torque_noise, np.abs(steps.drive[k] @ x[2 * joints :])) ** 2
        P = F @ P @ F.T
        P[: 2 * joints, : 2 * joints] += (G * noise) @ G.T
        return out, P

    def _acceleration(self, off: Array, theta: Array, steps: _Steps, k: int) -> tuple[Array, Array, Array]:
        """ddq (J,) `off` (2J,) the projected motion, its derivative (J, 2J + P), and the inverse of the mass matrix."""
        about = theta if self.about is None else self.about
        slopes = steps.slopes[k]
        tables = steps.tables[k] + slopes @ off
        torque = tables @ about
        inverse = _inverse(torque[1:].T)
        ddq = inverse @ (steps.tau[k] - torque[0])
        weight = np.concatenate([[1.0], ddq])
        rows = np.tensordot(weight, tables, 1)
        by_state = np.tensordot(weight, np.tensordot(slopes, about, (2, 0)), 1)
        J = -inverse @ np.hstack([by_state, rows])
        return ddq - inverse @ (rows @ (theta - about)), J, inverse


def _inverse(mass: Array) -> Array:
    return np.asarray(np.linalg.inv(mass), dtype=np.float64)
