"""`dr`: least squares on derivatives by a sliding-mode differentiator with adaptive gains (Sidhom et al., AIM 2010).

The differentiator is Levant's of third order (Int. J. Control 76, 2003) in its homogeneous discrete form (Livne and
Levant, Automatica 50, 2014), exact in finite time without noise while the fourth derivative stays below L. L adapts: it
follows the bound of the fourth derivative along the motion, joint by joint (too small loses the signal, too large
chatters). One pass runs forward in time and one backward; their mean has no lag. From there on the rows are those of
`poly`.

It takes some of the amplitude all the same, more where there is noise, and it is not linear: nothing in the residual
tells. So it is run on repetitions as well, motions whose derivatives are known, with white noise of the size that was
found (what a projection leaves lacks the noise within its band): what comes out of their exact torques, less what went
in, is its bias, which is taken off, and its scatter (Efron and Tibshirani, An Introduction to the Bootstrap, 1993,
chapters 6 and 10).
"""

from dataclasses import replace

import numpy as np
import scipy.ndimage
from scipy.interpolate import CubicSpline

from chebid.basis import Array
from chebid.effects import Motion
from chebid.equations import measured_rows
from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import DrSettings, method_settings
from chebid.estimators.weighted import Solution, solve
from chebid.motion import Track
from chebid.projection import Projection

# lambda = 3, 2, 1.5, 1.1 (Levant 2003, section 5), the recursion unrolled: lambda'_i = lambda_{3-i}
# lambda'_{i-1}^((3-i)/(4-i))
_NESTED = (3.0, 2.0 * 3.0 ** (2 / 3), 1.5 * (2.0 * 3.0 ** (2 / 3)) ** 0.5, 1.1)
_SUBSTEPS = 5  # steps of the differentiator per sample
_MARGIN = 2.5  # of L above the fourth derivative seen nearby
_LEAST = 0.02  # of the largest L: where the joint hardly moves
_REPEATS = 16
_SETTLE = 3.0  # periods of the bandwidth until it has found the signal


def dr(problem: Problem) -> Estimate:
    """Estimate on sliding-mode derivatives. Raises NoAnswerError on rank loss or when nothing is left to use."""
    settings = method_settings(problem.model, "dr", DrSettings)
    dynamics, band = problem.dynamics, problem.band.frequency
    random = np.random.default_rng(0)
    made = [_rederived(track, settings, random) for track in problem.tracks]
    rows = measured_rows([tracks[0] for tracks in made], dynamics, problem.gate, band)
    found = _calibrated(problem, solve(rows, dynamics.parameters), made)
    return assemble(problem, "dr", found, rows, {"equation_bandwidth": band, "dr": settings.model_dump()})


def _calibrated(problem: Problem, found: Solution, made: list[list[Track]]) -> Solution:
    """The solution without the bias that repetitions show; their scatter and the torque's noise make its covariance."""
    dynamics, gate, band = problem.dynamics, problem.gate, problem.band.frequency
    errors = []
    for k in range(1, _REPEATS + 1):
        tracks = [
            replace(again[k], tau=dynamics.torque(track.motion, found.theta))
            for track, again in zip(problem.tracks, made, strict=True)
        ]
        rows = measured_rows(tracks, dynamics, gate, band)
        weight = 1 / found.sigma[rows.joint]
        errors.append(np.linalg.lstsq(rows.W * weight[:, None], rows.Y * weight)[0] - found.theta)
    noise = solve(problem.rows, dynamics.parameters).covariance  # of the torque: the rows of `dr` hold chatter as well
    scatter = (1 + 1 / _REPEATS) * np.cov(np.array(errors).T).reshape(noise.shape)
    return replace(found, theta=found.theta - np.mean(errors, axis=0), covariance=noise + scatter)


def _rederived(track: Track, settings: DrSettings, random: np.random.Generator) -> list[Track]:
    """The track with q, dq, ddq of the differentiator, and the same of each repetition.

    It settles within some periods of the bandwidth at each end.
    """
    t, at, joints = track.record.t, track.motion.t, len(track.projections)
    fine = np.linspace(t[0], t[-1], _SUBSTEPS * (len(t) - 1) + 1)
    signals = [_repetitions(p, random) for p in track.projections]
    signal = np.hstack([CubicSpline(t, np.column_stack(each))(fine) for each in zip(*signals, strict=True)])
    bound = np.column_stack([_bound(p, t, fine, settings.lipschitz) for p in track.projections])
    derivatives = differentiate(signal, float(fine[1] - fine[0]), np.tile(bound, len(signals[0])))
    settled = (at >= t[0] + _SETTLE / track.bandwidth) & (at <= t[-1] - _SETTLE / track.bandwidth)
    states = [np.column_stack([np.interp(at, fine, column) for column in x.T]) for x in derivatives]
    out = []
    for k in range(0, joints * (_REPEATS + 1), joints):
        q, dq, ddq = (x[:, k : k + joints] for x in states)
        out.append(replace(track, motion=Motion(at, q, dq, ddq), valid=track.valid & settled))
    return out


def _repetitions(projection: Projection, random: np.random.Generator) -> list[Array]:
    """The signal (N,) as measured, and its projection with fresh noise, time and again."""
    smooth = projection.at(projection.t, 0)
    noise = projection.noise * random.standard_normal((_REPEATS, len(smooth)))
    return [projection.x, *(smooth + noise)]


def _bound(projection: Projection, t: Array, fine: Array, given: float | None) -> Array:
    """L (M,) at the fine instants: the largest fourth derivative within a period of the bandwidth, with a margin."""
    if given:
        return np.full(len(fine), given)
    fourth = np.abs(projection.at(t, 4))
    inside = projection.valid(4)
    fourth = np.minimum(fourth, np.max(fourth[: len(inside)][inside])) if len(inside) == len(t) else fourth
    reach = max(3, round((len(t) - 1) / (t[-1] - t[0]) / projection.plan.bandwidth))
    local = scipy.ndimage.maximum_filter1d(fourth, 2 * reach + 1)
    return _MARGIN * np.interp(fine, t, np.maximum(local, _LEAST * np.max(local)))


def differentiate(x: Array, step: float, bound: Array) -> tuple[Array, Array, Array]:
    """x, its velocity and acceleration (N, J) from samples x (N, J) at `step` s, with L = `bound` (N, J)."""
    # forward and backward pass run side by side as 2 J signals
    z = _run(np.hstack([x, x[::-1]]), step, np.hstack([bound, bound[::-1]]))
    joints = x.shape[1]
    position, velocity = ((z[:, k, :joints] + (-1) ** k * z[::-1, k, joints:]) / 2 for k in range(2))
    # z_2 follows its signal with a lag that the mean of the passes turns into a loss of 3 % of amplitude; z_1 hardly
    return position, velocity, np.gradient(velocity, step, axis=0)


def _run(x: Array, step: float, bound: Array) -> Array:
    """States z_0 and z_1 (N, 2, K) of the differentiator along x (N, K)."""
    z = np.zeros((4, x.shape[1]))
    z[0] = x[0]
    z[1] = (x[1] - x[0]) / step
    out = np.empty((len(x), 2, x.shape[1]))
    powers = [_NESTED[i] * bound ** ((i + 1) / 4) for i in range(4)]
    second, third = step**2 / 2, step**3 / 6
    for k in range(len(x)):
        error = z[0] - x[k]
        out[k] = z[:2]
        size, sign = np.abs(error), np.sign(error)
        root = np.sqrt(np.sqrt(size))
        # v_i = -lambda'_i L^((i+1)/4) |e|^((3-i)/4) sign(e), and the Taylor terms of the states above
        z[0] += step * (z[1] - powers[0][k] * root**3 * sign) + second * z[2] + third * z[3]
        z[1] += step * (z[2] - powers[1][k] * root**2 * sign) + second * z[3]
        z[2] += step * (z[3] - powers[2][k] * root * sign)
        z[3] -= step * powers[3][k] * sign
    return out
