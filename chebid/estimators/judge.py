"""How well given parameters explain rows: rms, relative error, noise floor, joint by joint."""

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.equations import Rows, neighbour_floor, repeat_floor
from chebid.estimators.problem import Problem
from chebid.estimators.result import JointResidual
from chebid.motion import Track


def judge(problem: Problem, rows: Rows, theta: Array) -> dict[str, JointResidual]:
    """One `JointResidual` per joint for theta (P,) on the rows of a problem."""
    raw = relative_raw(problem.tracks, problem.dynamics, theta)
    kind, floor = noise_floor(problem, theta, float(rows.frequency.max()))
    residual = rows.Y - rows.W @ theta
    return {
        name: _joint(rows, residual, j, float(raw[j]), None if floor is None else float(floor[j]), kind)
        for j, name in enumerate(problem.dynamics.joints)
    }


def noise_floor(problem: Problem, theta: Array, band: float) -> tuple[str, Array | None]:
    """What noise alone would leave (J,) within the band, and how that is known: from repeats of the motion where there
    are any, which assumes nothing, else from the octave above the band.
    """
    given = problem.tracks, problem.dynamics, theta, problem.gate, band
    repeats = repeat_floor(*given)
    return ("repeats", repeats) if repeats is not None else ("out-of-band", neighbour_floor(*given))


def _joint(rows: Rows, residual: Array, joint: int, raw: float, floor: float | None, kind: str) -> JointResidual:
    mine = rows.joint == joint
    norm, measured = float(np.linalg.norm(residual[mine])), float(np.linalg.norm(rows.Y[mine]))
    return JointResidual(
        rms=norm * rows.rms_scale(joint),
        relative=norm / measured if measured > 0 else 0.0,
        relative_raw=raw,
        floor=floor,
        floor_kind=kind,
    )


def overall(rows: Rows, theta: Array) -> float:
    """Relative error of all joints together."""
    total = float(np.linalg.norm(rows.Y))
    return float(np.linalg.norm(rows.Y - rows.W @ theta)) / total if total > 0 else 0.0


def relative_raw(tracks: list[Track], dynamics: Dynamics, theta: Array) -> Array:
    """||measured - predicted|| / ||measured|| (J,) over every sample of the logs as they are."""
    error, energy = np.zeros(len(dynamics.joints)), np.zeros(len(dynamics.joints))
    for track in tracks:
        difference = track.torque - dynamics.torque(track.motion, theta)
        error = error + np.nansum(difference**2, axis=0)
        energy = energy + np.nansum(track.torque**2, axis=0)
    return np.sqrt(error / np.maximum(energy, np.finfo(float).tiny))
