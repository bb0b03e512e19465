"""`ekf`: extended Kalman filter on state and parameters (Gautier and Poignet, Control Eng. Pract. 9, 2001).

State (q, dq, theta), theta constant; the measured torque drives the model, the measured positions correct it. The prior
is the model file's fit, with `methods: ekf: prior:` as its relative standard deviation. The torque's noise, which
drives the state, is that of the residual of `poly`; a joint below its velocity gate gets the whole of its friction as
uncertainty, because nobody knows where it points.
"""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.effects import Motion
from chebid.errors import InputError, NoAnswerError, Place
from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import EkfSettings, method_settings
from chebid.estimators.weighted import Solution, solve
from chebid.motion import Track

_STEP = 1e-6  # relative step of the differences that linearise the motion
_LONGEST = 1e-2  # s of one integration step


def ekf(problem: Problem) -> Estimate:
    """Estimate by filtering. Raises InputError without a prior, NoAnswerError when the filter diverges."""
    settings = method_settings(problem.model, "ekf", EkfSettings)
    rows, dynamics = problem.rows, problem.dynamics
    first = solve(rows, dynamics.parameters)
    mean = _prior(problem)
    spread = settings.prior * np.abs(mean)
    covariance = np.diag(np.where(spread > 0, spread, settings.prior * np.max(spread)) ** 2)
    prior = covariance.copy()
    innovations: list[Array] = []
    for track in problem.tracks:
        filter_ = _Filter(dynamics, track, problem.gate, _torque_noise(problem, first.theta))
        mean, covariance = filter_.run(mean, covariance)
        innovations.append(np.array(filter_.innovations))
    if not np.all(np.isfinite(mean)):
        raise NoAnswerError("the filter diverged", hint="give a better prior in the fit: section, or use --method poly")
    honest = covariance * _inflation(np.concatenate(innovations))
    return assemble(
        problem,
        "ekf",
        Solution(mean, honest, covariance, first.sigma, first.condition),
        rows,
        {
            "equation_bandwidth": problem.band.frequency,
            "ekf": {"prior": settings.prior, "prior_sd": list(np.sqrt(np.diag(prior)))},
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


def _torque_noise(problem: Problem, theta: Array) -> Array:
    """Standard deviation (J,) of the torque per sample: all that the first fit leaves, in and out of band."""
    return np.array([np.sqrt(n.energy(theta) / max(n.samples, 1)) for n in problem.rows.noise])


def _inflation(innovations: Array) -> float:
    """Factor on the covariance: mean square of the whitened innovations, never below one."""
    kept = innovations[len(innovations) // 10 :]
    return max(1.0, float(np.mean(kept**2)))


@dataclass
class _Filter:
    """One pass over a record."""

    dynamics: Dynamics
    track: Track
    gate: Array
    torque_noise: Array

    def __post_init__(self) -> None:
        self.innovations: list[Array] = []
        self.joints = len(self.gate)
        noise = np.array([p.noise for p in self.track.projections])
        self.R = np.diag(np.maximum(noise, 1e-12) ** 2)

    def run(self, theta: Array, covariance: Array) -> tuple[Array, Array]:
        """Parameters and their covariance after the record, from those before it."""
        track, joints = self.track, self.joints
        t, q, tau = track.motion.t, track.record.q, track.torque
        used = np.flatnonzero(track.valid)
        first, last = used[0], used[-1]
        x = np.concatenate([track.motion.q[first], track.motion.dq[first], theta])
        P = np.zeros((len(x), len(x)))
        P[:joints, :joints] = self.R
        P[joints : 2 * joints, joints : 2 * joints] = np.diag((0.02 * np.abs(track.motion.dq).max(axis=0)) ** 2)
        P[2 * joints :, 2 * joints :] = covariance
        for k in range(first, last):
            held = (tau[k] + tau[k + 1]) / 2
            held = np.where(np.isfinite(held), held, 0.0)
            x, P = self._predict(x, P, t[k + 1] - t[k], held)
            if np.all(np.isfinite(q[k + 1])):
                x, P = self._correct(x, P, q[k + 1])
        return x[2 * joints :], P[2 * joints :, 2 * joints :]

    def _correct(self, x: Array, P: Array, q: Array) -> tuple[Array, Array]:
        joints = self.joints
        S = P[:joints, :joints] + self.R
        root = np.linalg.cholesky(S)
        innovation = q - x[:joints]
        self.innovations.append(np.linalg.solve(root, innovation))
        gain = np.linalg.solve(S, P[:joints]).T
        kept = np.eye(len(x))
        kept[:, :joints] -= gain
        # Joseph's form keeps P symmetric and positive
        return x + gain @ innovation, kept @ P @ kept.T + gain @ self.R @ gain.T

    def _predict(self, x: Array, P: Array, step: float, tau: Array) -> tuple[Array, Array]:
        joints = self.joints
        F, G = np.eye(len(x)), np.zeros((len(x), joints))
        count = max(1, int(np.ceil(step / _LONGEST)))
        small = step / count
        for _ in range(count):
            x, f, g = self._step(x, small, tau)
            F, G = f @ F, f @ G + g
        slow = np.abs(x[joints : 2 * joints]) < self.gate
        noise = np.where(slow, np.maximum(self.torque_noise, self._friction(x)), self.torque_noise)
        return x, F @ P @ F.T + (G * noise**2) @ G.T

    def _friction(self, x: Array) -> Array:
        """Torque (J,) that changes sign with the velocity."""
        joints = self.joints
        q, theta, speed = x[:joints], x[2 * joints :], np.maximum(self.gate, 1e-9)
        both = [self._regressor(q[None], (s * speed)[None], np.zeros((1, joints)))[0] @ theta for s in (1.0, -1.0)]
        return np.abs(both[0] - both[1]) / 2

    def _step(self, x: Array, h: float, tau: Array) -> tuple[Array, Array, Array]:
        """One midpoint step, its derivative with respect to x and to the torque (to second order in h)."""
        joints = self.joints
        v, unit = slice(joints, 2 * joints), np.eye(len(x))
        first, _, _ = self._acceleration(x, tau, linearise=False)
        middle = x.copy()
        middle[:joints] += h / 2 * x[v]
        middle[v] += h / 2 * first
        a, J, inverse = self._acceleration(middle, tau)
        out = x.copy()
        out[:joints] += h * middle[v]
        out[v] += h * a
        half = unit.copy()
        half[:joints] += h / 2 * unit[v]
        half[v] += h / 2 * J
        F = unit.copy()
        F[:joints] += h * half[v]
        F[v] += h * J @ half
        G = np.zeros((len(x), joints))
        G[:joints], G[v] = h * h / 2 * inverse, h * inverse
        return out, F, G

    def _acceleration(self, x: Array, tau: Array, linearise: bool = True) -> tuple[Array, Array, Array]:
        """ddq (J,), d ddq / dx (J, n) and the inverse of the mass matrix, from one batch of regressors."""
        joints, theta = self.joints, x[2 * self.joints :]
        steps = _STEP * np.maximum(1.0, np.abs(x[: 2 * joints]))
        # a difference in velocity goes away from zero: it must not cross a reversal of friction
        steps[joints:] *= np.where(x[joints : 2 * joints] < 0, -1.0, 1.0)
        moved = np.diag(steps) if linearise else np.zeros((0, 2 * joints))
        states = x[: 2 * joints] + np.vstack([np.zeros(2 * joints), moved])
        batch = np.repeat(states, joints + 1, axis=0)
        unit = np.tile(np.vstack([np.zeros(joints), np.eye(joints)]), (len(states), 1))
        torque = self._regressor(batch[:, :joints], batch[:, joints:], unit) @ theta
        bias, *columns = torque.reshape(len(states), joints + 1, joints).transpose(1, 0, 2)
        mass = np.stack([column - bias for column in columns], axis=2)
        a: Array = np.asarray(np.linalg.solve(mass, (tau - bias)[:, :, None])[:, :, 0], dtype=np.float64)
        J = np.zeros((joints, len(x)))
        inverse: Array = np.asarray(np.linalg.inv(mass[0]), dtype=np.float64)
        if linearise:
            J[:, : 2 * joints] = ((a[1:] - a[0]) / steps[:, None]).T
            # the torque R(q, dq, ddq) theta stays when theta changes: d ddq = - M^-1 R d theta
            J[:, 2 * joints :] = -inverse @ self._regressor(x[None, :joints], x[None, joints : 2 * joints], a[:1])[0]
        return a[0], J, inverse

    def _regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        return self.dynamics.regressor(Motion(np.zeros(len(q)), q, dq, ddq))
