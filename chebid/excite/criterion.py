"""How exciting a motion is: cond(W) + 1/sigma_min(W) (eq. 23; Presse and Gautier, ICRA 1993), and what is optimised.

Eq. 23 by itself is served best by crawling much of the time: the columns sign(dq) of a crawling joint are as long as
those of a fast one, and balance the others. On the SCARA of the paper such a motion has a criterion of 2.5, and
deviations 4 times those of a random fast motion. So the search minimises

    log(criterion) - information * log(geometric mean of the singular values of W),

where the second term is that of D-optimal design and does not depend on units, and where rows of joints slower than a
gate hardly count: dq^2/(dq^2 + gate^2). With 0 for both it is eq. 23 alone, as which every score is reported.
"""

from dataclasses import dataclass

import numpy as np

from chebid.dynamics import Dynamics
from chebid.effects import Motion
from chebid.robots import Array

STEP = 1e-7  # rad (m) and s, of the differences of the regressor: errors of 1e-7, far below what a search needs


@dataclass(frozen=True)
class Score:
    """Of an observation matrix W: `value` of the criterion, condition number, smallest singular value."""

    value: float
    condition: float
    smallest: float


@dataclass(frozen=True)
class Criterion:
    """The criterion of a model for motions sampled at t (N,) s; W is not weighted.

    `scale`: that of the singular values, where the motion of a log has more samples than t; `information`, `gate`
    ((J,) rad/s or m/s): of the objective.
    """

    dynamics: Dynamics
    t: Array
    scale: float = 1.0
    information: float = 0.0
    gate: Array | float = 0.0

    @property
    def pointwise(self) -> bool:
        """The gradient is that of effects without a past, even where there are others."""
        return True

    def value(self, state: Array) -> float:
        """Of eq. 23; infinite where rank is lost."""
        return self.score(state).value

    def score(self, state: Array) -> Score:
        """Of a motion (3, N, J): q, dq, ddq."""
        return self._decompose(self._rows(state))[0]

    def objective(self, state: Array) -> tuple[float, Array]:
        """What the search makes small, and its gradient (3, N, J) with respect to the motion."""
        W, slopes = self._slopes(state)
        score, by_W = self._decompose(W)
        if not np.isfinite(score.value):
            return np.inf, np.zeros_like(state)
        stacked = W.reshape(-1, W.shape[2])
        gram = stacked.T @ stacked
        mean = np.linalg.slogdet(gram)[1] / (2 * len(gram)) + np.log(self.scale)
        by_mean = (stacked @ np.linalg.inv(gram)).reshape(W.shape) / len(gram)
        by_rows = by_W / score.value - self.information * by_mean
        gradient = np.einsum("njp,oinjp->oni", by_rows, slopes)
        gradient[1, np.abs(state[1]) < 10 * STEP] = 0.0  # a direction may change there
        return float(np.log(score.value) - self.information * mean), gradient

    def _rows(self, state: Array) -> Array:
        """W as (N, J, P)."""
        return self.dynamics.regressor(Motion(self.t, *state))

    def _slopes(self, state: Array) -> tuple[Array, Array]:
        """W (N, J, P) and its derivative (3, J, N, J, P) by each column of the motion, from differences."""
        count, joints = len(self.t), state.shape[2]
        moved = moved_states(state)
        if any(effect.memory for effect in self.dynamics.effects):
            W = np.stack([self._rows(one) for one in moved])
        else:
            flat = Motion(np.tile(self.t, len(moved)), *np.moveaxis(moved, 1, 0).reshape(3, -1, joints))
            W = self.dynamics.regressor(flat).reshape(len(moved), count, joints, -1)
        W *= counted(moved[:, 1], self.gate)[..., None]
        return W[0], ((W[1:] - W[0]) / STEP).reshape(3, joints, *W[0].shape)

    def _decompose(self, W: Array) -> tuple[Score, Array]:
        """The score of W and its gradient (N, J, P) with respect to W, from the ends of the spectrum of W^T W."""
        stacked = W.reshape(-1, W.shape[2])
        squares, vectors = np.linalg.eigh(stacked.T @ stacked)
        low, high = np.sqrt(max(squares[0], 0.0)), np.sqrt(squares[-1])
        if not low > 1e-7 * high:
            return Score(np.inf, np.inf, self.scale * low), np.zeros_like(W)
        score = Score(float(high / low + 1 / (self.scale * low)), float(high / low), float(self.scale * low))
        v, V = vectors[:, 0], vectors[:, -1]
        per_low = -(high + 1 / self.scale) / low**2
        gradient = np.outer(stacked @ V, V) / (high * low) + per_low * np.outer(stacked @ v, v) / low
        return score, gradient.reshape(W.shape)


def moved_states(state: Array) -> Array:
    """(1 + 3 J, 3, N, J): a motion (3, N, J), and with each of its columns moved by `STEP`, position first."""
    joints = state.shape[2]
    moved = np.tile(state, (1 + 3 * joints, 1, 1, 1))
    for order in range(3):
        for joint in range(joints):
            moved[1 + order * joints + joint, order, :, joint] += STEP
    return moved


def counted(dq: Array, gate: Array | float) -> Array:
    """How much rows of joints with these speeds (..., J) count: 0 at rest, half at the gate, 1 when fast."""
    squares = dq**2
    return squares / (squares + np.square(gate) + 1e-300)
