"""What logs that were not fitted on say of a candidate: how much better it predicts them.

The logarithm of the predictive density of the hold-out under model and candidate, their parameters known from the
fitted logs with their covariance, less that of the model alone. With Gram matrices A = Z^T Z of the fitted logs and B
of the hold-out, R rows, and its deviation fitted: -(R / 2) ln(RSS(A + B) - RSS(A)) - (ln det(A + B) - ln det A) / 2.
"""

import numpy as np

from chebid.basis import Array
from chebid.critique.evidence import Evidence
from chebid.critique.transmission import simulated_rows
from chebid.effects import Effect
from chebid.equations.span import orthonormal


class Holdout:
    """The evidence of hold-out logs beside that of the fitted ones, under the same model."""

    def __init__(self, fitted: Evidence, held_out: Evidence) -> None:
        self._sides = (fitted, held_out)
        self._start = self._density(None)

    def score(self, effect: Effect) -> float:
        """ln of how much likelier the hold-out is with the effect; its hyper-parameters are those given."""
        return self._density(effect) - self._start

    def _density(self, effect: Effect | None) -> float:
        systems = [_system(side, effect) for side in self._sides]
        scale = np.sqrt(sum(np.sum(W**2, axis=0) for W, _ in systems)) + 1e-300
        fitted, held_out = (_gram(W / scale, Y) for W, Y in systems)
        before, after = _solved(fitted), _solved(fitted + held_out)
        predicted = max(after[0] - before[0], np.finfo(float).tiny)
        rows = len(self._sides[1].rows.Y)
        return (-rows * float(np.log(predicted)) + before[1] - after[1]) / 2


def _system(evidence: Evidence, effect: Effect | None) -> tuple[Array, Array]:
    """Whitened columns of model and effect, and torques, without what lies along what is no fault of the model."""
    W, Y = evidence.system
    if effect is not None:
        W = np.hstack([W, simulated_rows(evidence, effect)])
    basis = orthonormal(evidence.nuisance)
    return W - basis @ (basis.T @ W), Y - basis @ (basis.T @ Y)


def _gram(W: Array, Y: Array) -> Array:
    Z = np.column_stack([W, Y])
    return np.asarray(Z.T @ Z)


def _solved(gram: Array) -> tuple[float, float]:
    """Residual sum of squares and ln det of the columns; a trace of ridge keeps what is not identifiable finite."""
    A = gram[:-1, :-1] + 1e-9 * np.eye(len(gram) - 1)
    b = gram[:-1, -1]
    return float(gram[-1, -1] - b @ np.linalg.solve(A, b)), float(np.linalg.slogdet(A)[1])
