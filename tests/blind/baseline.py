"""What rigid links, viscous and Coulomb friction can explain of a run: own closed form, own least squares."""

from dataclasses import dataclass

import numpy as np
from blind.world import Array, Run, averaged, instants

GATE = 0.01  # of the peak speed: slower samples may stick, and then dry friction takes any value


def rigid(kind: str, q: Array, dq: Array, ddq: Array) -> Array:
    """Columns (K, J, P) of the rigid body, from its kinetic energy.

    Two links: J1 and I2 are inertias about the joints (the mass of body 2 at the elbow within J1), (hx, hy) = L1 m2
    times the centre of mass of body 2, and g = hx cos q2 - hy sin q2:
    T = J1 v1²/2 + I2 (v1 + v2)²/2 + g v1 (v1 + v2).
    """
    if kind == "axes":
        return ddq[:, :, None] * np.eye(ddq.shape[1])
    a1, a2, v1, v2 = ddq[:, 0], ddq[:, 1], dq[:, 0], dq[:, 1]
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    W = np.zeros((len(q), 2, 4))
    W[:, 0, 0] = a1
    W[:, 0, 1] = W[:, 1, 1] = a1 + a2
    for column, g, slope in ((2, c, -s), (3, -s, -c)):  # g and dg/dq2 per unit of hx, hy
        W[:, 0, column] = g * (2 * a1 + a2) + slope * v2 * (2 * v1 + v2)
        W[:, 1, column] = g * a1 - slope * v1**2
    return W


def columns(kind: str, q: Array, dq: Array, ddq: Array) -> Array:
    """Rigid body, then viscous and Coulomb friction of each joint: (K, J, P)."""
    eye = np.eye(q.shape[1])
    return np.concatenate([rigid(kind, q, dq, ddq), dq[:, :, None] * eye, np.sign(dq)[:, :, None] * eye], axis=2)


@dataclass(frozen=True)
class Fit:
    """Parameters, residual (N, J) and which samples (N, J) counted."""

    parameters: Array
    residual: Array
    used: Array

    def dnr(self, noise: Array) -> Array:
        """rms of what is not explained over the torque noise, per joint."""
        squares = np.where(self.used, self.residual**2, 0.0).sum(axis=0)
        return np.sqrt(squares / np.maximum(self.used.sum(axis=0), 1)) / noise


def explain(
    kind: str, outcome: Run, torque: Array, rate: float, duration: float, noise: Array, most: int = 6000
) -> Fit:
    """Least squares of torques (N, J) at the log's instants on the columns averaged over one sampling interval each.

    Averaging both sides of exact equations leaves them exact: for an arm with nothing missing the residual is nil up
    to the step of the physics.
    """
    rows = instants(outcome, rate, duration)
    stride = max(1, len(rows) // most)
    rows, torque = rows[::stride], torque[::stride]
    width = round(1 / (rate * outcome.step))
    lo, hi = rows[0] - width, rows[-1] + 2 * width
    at = slice(lo, hi)
    W = averaged(columns(kind, outcome.q[at], outcome.dq[at], outcome.ddq[at]), rows - lo, width)
    slow = np.abs(outcome.dq) < GATE * np.abs(outcome.dq).max(axis=0)
    used = averaged(slow[at].astype(float), rows - lo, width) == 0
    weights = used / noise
    A = (W * weights[:, :, None]).reshape(-1, W.shape[2])
    b = (torque * weights).ravel()
    scale = np.linalg.norm(A, axis=0) + 1e-300
    parameters = np.linalg.lstsq(A / scale, b, rcond=1e-10)[0] / scale
    return Fit(parameters, torque - W @ parameters, used)
