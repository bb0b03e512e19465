"""The objective of a search for motions that separate rivals: E of `contest`, smoothly the smallest of all duels.

Where E is smallest the best imitation does not change to first order, so that the gradient is that of the error of the
imitation with its coefficients held: r^T d(a - W x - B y), from differences of one torque and not of all columns.

A little of eq. 23 is added: a motion that separates rivals but lets a joint rest would leave the model's own parameters
to the other logs.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chebid.effects import Motion
from chebid.excite.contest import Contest, Outcome, Piece
from chebid.excite.criterion import STEP, Criterion, counted, moved_states
from chebid.robots import Array

_POWER = 6.0  # of the smooth minimum: below the smallest of two equal E by a factor of 1.12
_FELT = 0.01  # share of the gradient from which on an imitation is followed
_NONE = 1e-12  # E that is no separation at all
_IDENTIFY = 0.15  # weight of ln(eq. 23) beside ln E
_LOST = 1e7  # eq. 23 where rank is lost


@dataclass(frozen=True)
class Separation:
    """For motions sampled at t (N,) s; `noise` (J,) N.m or N per sample; `gate` (J,) rad/s or m/s.

    `repeat`: samples of the record for each of t.
    """

    contest: Contest
    t: Array
    noise: Array
    gate: Array
    repeat: float = 1.0

    @cached_property
    def pointwise(self) -> bool:
        """Whether no effect remembers the past."""
        contest = self.contest
        effects = [*contest.dynamics.effects, *(truth.effect for truth in contest.truths), *sum(contest.settings, ())]
        return not any(effect.memory for effect in effects)

    def value(self, state: Array) -> float:
        """-sqrt(E) of the duel that separates worst; infinite where it does not separate at all."""
        least = min(outcome.left.min() for outcome in self._outcomes(state))
        return -float(np.sqrt(least)) if least > _NONE else np.inf

    def objective(self, state: Array) -> tuple[float, Array]:
        """-ln of the smoothly smallest E with a little of eq. 23, and its gradient (3, N, J)."""
        beside, by_beside = Criterion(self.contest.dynamics, self.t, gate=self.gate).objective(state)
        beside = min(beside, float(np.log(_LOST)))
        apart, by_apart = self._apart(state)
        return apart + _IDENTIFY * beside, by_apart + _IDENTIFY * by_beside

    def _apart(self, state: Array) -> tuple[float, Array]:
        outcomes = self._outcomes(state)
        left = np.concatenate([outcome.left for outcome in outcomes])
        logarithm = np.log(np.maximum(left, _NONE))
        weight = np.exp(-_POWER * (logarithm - logarithm.min()))
        value = np.log(weight.sum()) / _POWER - logarithm.min()
        if not self.pointwise:
            return float(value), np.zeros_like(state)
        share = np.split(weight / weight.sum(), np.cumsum([len(outcome.left) for outcome in outcomes])[:-1])
        return float(value), self._gradient(state, outcomes, share)

    def piece(self, t: Array, state: Array) -> Piece:
        """A motion with the weights of its rows."""
        return Piece(Motion(t, *state), self._weight(state[1]))

    def _weight(self, dq: Array) -> Array:
        return np.sqrt(self.repeat) * counted(dq, self.gate) / self.noise

    def _outcomes(self, state: Array) -> list[Outcome]:
        return self.contest.outcomes([self.piece(self.t, state)])

    def _gradient(self, state: Array, outcomes: list[Outcome], shares: list[Array]) -> Array:
        """(3, N, J) of the objective; `shares`: of each outcome (S,), what its settings weigh."""
        moved = moved_states(state)
        flat = self.piece(np.tile(self.t, len(moved)), np.moveaxis(moved, 1, 0).reshape(3, -1, state.shape[2]))
        W = flat.whiten(self.contest.dynamics.regressor(flat.motion))
        fit = np.linalg.pinv(W[: state[0].size])
        gradient = np.zeros((len(moved) - 1, len(self.t)))
        for outcome, share in zip(outcomes, shares, strict=True):
            truth = self.contest.truth_rows(outcome.duel.truth, [flat])
            for number in np.flatnonzero(share > _FELT):
                effect = self.contest.settings[outcome.duel.rival][number]
                columns = self.contest.effect_rows(effect, [flat])
                error = truth - columns @ outcome.values[number, : columns.shape[1]]
                error = (error - W @ (fit @ error[: state[0].size])).reshape(-1, *state.shape[1:])
                slope = 2 * np.sum(error[0] * (error[1:] - error[0]), axis=2) / STEP
                gradient -= slope * share[number] / max(outcome.left[number], _NONE)
        by_motion = np.moveaxis(gradient.reshape(3, state.shape[2], -1), 1, 2)
        by_motion[1, np.abs(state[1]) < 10 * STEP] = 0.0  # a direction may change there
        return by_motion
