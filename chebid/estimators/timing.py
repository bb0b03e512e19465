"""Does the torque column lag the position column? (facts: half a control period makes viscous friction negative.)

A torque logged `delay` s late is tau(t - delay), to first order the model's torque less delay times its rate. One more
column, the rate of the model's own torque (never of the measured one), gives the delay with its deviation.
"""

from dataclasses import replace

import numpy as np

from chebid.basis import Array
from chebid.equations import project_columns
from chebid.errors import NoAnswerError, Notice, Place
from chebid.estimators.problem import Problem
from chebid.estimators.result import Lag
from chebid.estimators.weighted import solve
from chebid.motion import Track
from chebid.robots import Parameter

_SURE = 4.0  # deviations from zero before anyone is told
_LEAST = 0.05  # of a sample: a shorter lag has no effect worth telling


def lag_notice(lag: Lag, problem: Problem) -> Notice | None:
    """A warning when the lag is surely there and long enough to matter."""
    step = 1 / max(track.rate for track in problem.tracks)
    if abs(lag.value) < max(_SURE * lag.sd, _LEAST * step):
        return None
    delay = problem.model.log.torque_delay + lag.value
    word = "lags" if lag.value > 0 else "leads"
    return Notice(
        "torque_lag",
        f"the torque {word} the positions by {1e3 * abs(lag.value):.3g} ms (sd {1e3 * lag.sd:.1g} ms); "
        f"unless the model lacks an effect, set log: torque_delay: {delay:.3g} in the model file",
        Place(file=str(problem.logs[0].path)),
    )


def torque_lag(problem: Problem, theta: Array) -> Lag | None:
    """The lag that explains the residual of theta (P,) best; None when the motion cannot tell."""
    rows = problem.rows
    parts = [
        project_columns(track, problem.gate, problem.band.frequency, -_rate(track, problem, theta)[:, :, None])
        for track in problem.tracks
    ]
    extended = replace(rows, W=np.hstack([rows.W, np.concatenate(parts)]), noise=rows.noise)
    try:
        found = solve(extended, (*problem.dynamics.parameters, Parameter("delay", None, "s")))
    except NoAnswerError:
        return None
    return Lag(float(found.theta[-1]), float(np.sqrt(found.covariance[-1, -1])))


def _rate(track: Track, problem: Problem, theta: Array) -> Array:
    """Rate (N, J) of the model's torque; zero across a reversal, where friction jumps."""
    torque = problem.dynamics.torque(track.motion, theta)
    rate = np.gradient(torque, track.motion.t, axis=0)
    sign = np.sign(track.motion.dq)
    turned = np.zeros(sign.shape, dtype=bool)
    turned[1:-1] = sign[2:] != sign[:-2]
    return np.where(turned, 0.0, rate)
