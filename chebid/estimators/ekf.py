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
_PASSES = 2  # the motion is linearised about the estimate of `poly`, then about that of the pass before


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
    about = first.theta
    for _ in range(_PASSES):
        mean, covariance = prior, np.diag(variance)
        innovations: list[float] = []
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
    """Factor on the covariance: mean of the squares (N,) of whitened innovations, never below one."""
    return max(1.0, float(np.mean(innovations[len(innovations) // 10 :])))


@dataclass(frozen=True)
class _Steps:
    """K midpoint steps of x = (q, dq, theta), less the projected motion and the parameters it is linearised about:
    x' = F x + u + noise of covariance Q; F (K, X, X), u (K, X), Q (K, 2J, 2J).

    Because the projected motion is stepped exactly, the midpoint rule errs in the difference only. For the whole
    motion, its error at 100 Hz would bias LMX2 by a deviation.
    """

    F: Array
    u: Array
    Q: Array


def _steps(setting: "_Filter", t: Array) -> Iterator[_Steps]:
    """Steps between instants t (K + 1,), some at a time."""
    dynamics, track = setting.dynamics, setting.track
    middle = (t[1:] + t[:-1]) / 2
    known = np.isfinite(track.torque).all(axis=1)
    torque = CubicSpline(track.motion.t[known], track.torque[known])(middle)
    motion = [np.column_stack([p.at(middle, k) for p in track.projections]) for k in range(3)]
    joints, width = torque.shape[1], len(dynamics.parameters)
    chunk = max(16, _HELD // ((1 + joints) * (1 + 2 * joints) * joints * width))
    for start in range(0, len(middle), chunk):
        piece = slice(start, start + chunk)
        q, dq, ddq = (x[piece] for x in motion)
        yield _linear(setting, Motion(middle[piece], q, dq, ddq), torque[piece], np.diff(t)[piece])


def _linear(setting: "_Filter", motion: Motion, tau: Array, h: Array) -> _Steps:
    """Steps of h (K,) s about the motion in their middle, under the torque tau (K, J)."""
    dynamics, about = setting.dynamics, setting.about
    tables, slopes = _tables(dynamics, motion.t, motion.q, motion.dq)
    torque = tables @ about
    inverse = np.asarray(np.linalg.inv(np.swapaxes(torque[:, 1:], 1, 2)), dtype=np.float64)
    ddq = np.einsum("kij,kj->ki", inverse, tau - torque[:, 0])
    # the torque is sum_i w_i (T_i + dT_i x) theta with w = (1, ddq)
    weight = np.concatenate([np.ones((len(h), 1)), ddq], axis=1)
    by_theta = np.einsum("ki,kijp->kjp", weight, tables)
    by_state = np.einsum("ki,kijps,p->kjs", weight, slopes, about, optimize=True)
    slope = -inverse @ np.concatenate([by_state, by_theta], axis=2)
    # within a step of a reversal, the torque's samples hold both directions of friction
    slow = np.abs(motion.dq) < setting.gate + np.abs(motion.ddq) * h[:, None]
    friction = np.abs(_friction(dynamics, motion.t, motion.q, setting.gate) @ about)
    noise = setting.held * np.maximum(setting.torque_noise, np.where(slow, friction, 0.0)) ** 2
    return _stepped(slope, ddq - motion.ddq, inverse, noise, h)


def _stepped(slope: Array, excess: Array, inverse: Array, noise: Array, h: Array) -> _Steps:
    """From the slopes (K, J, X) of the acceleration, what it is beyond the projected one, and variances of torque."""
    count, joints, size = slope.shape
    q, v = slice(joints), slice(joints, 2 * joints)
    step = h[:, None, None]
    slope = slope.copy()
    slope[:, :, v] += step / 2 * slope[:, :, q]
    both = np.concatenate([step**2 / 2 * slope, step * slope], axis=1)
    F = np.tile(np.eye(size), (count, 1, 1))
    F[:, : 2 * joints] += both
    F[:, q, v] += step * np.eye(joints)
    u = np.zeros((count, size))
    u[:, q], u[:, v] = h[:, None] ** 2 / 2 * excess, h[:, None] * excess
    G = np.concatenate([step**2 / 2 * inverse, step * inverse], axis=1)
    return _Steps(F, u, (G * noise[:, None, :]) @ np.swapaxes(G, 1, 2))


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
    """One pass over a record. `about` (P,): parameters about which the motion is linearised."""

    dynamics: Dynamics
    track: Track
    gate: Array
    torque_noise: Array
    about: Array

    def __post_init__(self) -> None:
        self.innovations: list[float] = []
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
        off = q - np.column_stack([p.at(t, 0) for p in track.projections])
        x = np.concatenate([np.zeros(2 * joints), theta - self.about])
        P = np.zeros((len(x), len(x)))
        P[:joints, :joints] = self.R
        P[joints : 2 * joints, joints : 2 * joints] = np.diag((0.02 * np.abs(track.motion.dq).max(axis=0)) ** 2)
        P[2 * joints :, 2 * joints :] = covariance
        seen: Mask = np.asarray(np.isfinite(q).all(axis=1))
        done = 0
        for part in _steps(self, fine):
            for F, u, Q in zip(part.F, part.u, part.Q, strict=True):
                x, P = F @ x + u, F @ P @ F.T
                P[: 2 * joints, : 2 * joints] += Q
                done += 1
                if done % count == 0 and seen[done // count]:
                    x, P = self._correct(x, P, off[done // count])
        return self.about + x[2 * joints :], P[2 * joints :, 2 * joints :]

    def _correct(self, x: Array, P: Array, q: Array) -> tuple[Array, Array]:
        """By positions q (J,), less the projected ones."""
        joints = self.joints
        inverse = np.linalg.inv(P[:joints, :joints] + self.R)
        gain, innovation = P[:, :joints] @ inverse, q - x[:joints]
        self.innovations.append(float(innovation @ inverse @ innovation) / joints)
        P = P - gain @ P[:joints]
        return x + gain @ innovation, (P + P.T) / 2
