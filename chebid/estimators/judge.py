"""How well given parameters explain rows: rms, relative error, noise floor, joint by joint."""

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.equations import Rows, repeat_floor
from chebid.estimators.problem import Problem
from chebid.estimators.result import JointResidual
from chebid.motion import Track


def judge(problem: Problem, rows: Rows, theta: Array) -> dict[str, JointResidual]:
    """One `JointResidual` per joint for theta (P,) on the rows of a problem."""
    raw = relative_raw(problem.tracks, problem.dynamics, theta)
    repeats = repeat_floor(problem.tracks, problem.dynamics, theta, problem.gate, float(rows.frequency.max()))
    residual = rows.Y - rows.W @ theta
    return {
        name: _joint(rows, residual, theta, j, float(raw[j]), None if repeats is None else float(repeats[j]))
        for j, name in enumerate(problem.dynamics.joints)
    }


def _joint(rows: Rows, residual: Array, theta: Array, joint: int, raw: float, repeats: float | None) -> JointResidual:
    mine = rows.joint == joint
    norm, measured = float(np.linalg.norm(residual[mine])), float(np.linalg.norm(rows.Y[mine]))
    return JointResidual(
        rms=norm * rows.rms_scale(joint),
        relative=norm / measured if measured > 0 else 0.0,
        relative_raw=raw,
        floor=repeats if repeats is not None else _floor(rows, norm**2 * rows.repeat, theta, joint),
        floor_kind="out-of-band" if repeats is None else "repeats",
    )


def _floor(rows: Rows, inside: float, theta: Array, joint: int) -> float | None:
    """Rms in the band of noise as strong as that found outside it; None when the rows fill all of the spectrum."""
    noise = rows.noise[joint]
    freedom = noise.samples - noise.equations
    outside = noise.energy(theta) - inside
    if freedom < 10 or outside <= 0:
        return None
    return float(np.sqrt(outside / freedom * noise.equations / noise.samples))


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
