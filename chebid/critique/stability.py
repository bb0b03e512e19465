"""How firmly a ranking stands: how often each candidate stays first when the rows are weighed anew.

Bayesian bootstrap (Rubin, Ann. Stat. 9, 1981) over groups of rows: a stretch of time, a joint, a band of frequency. The
model is refitted with every weighting.
"""

from collections.abc import Sequence

import numpy as np

from chebid.basis import Array
from chebid.critique.candidates import Candidate, penalty
from chebid.critique.evidence import Evidence

_DRAWS = 200
_BANDS = 3  # of frequency


def stability(evidence: Evidence, candidates: Sequence[Candidate], seed: int = 0) -> list[float]:
    """Share of the weightings in which each candidate has the best score of all that are given."""
    group = _groups(evidence)
    weights = np.random.default_rng(seed).exponential(size=(_DRAWS, int(group.max()) + 1))
    scores = np.column_stack(
        [
            _gains(evidence, c.judged.basis, group, weights) / 2 - penalty(evidence, c.judged, c.settings)
            for c in candidates
        ]
    )
    first = np.argmax(scores, axis=1)
    return [float(np.mean(first == i)) for i in range(len(candidates))]


def _groups(evidence: Evidence) -> Array:
    """Number of the group (R,) of each row; rows of what is known beforehand are one more."""
    rows = evidence.rows
    third = np.minimum((_BANDS * rows.frequency / (rows.frequency.max() * (1 + 1e-9))).astype(int), _BANDS - 1)
    label = np.column_stack([rows.block, rows.joint, third])
    group = np.unique(label, axis=0, return_inverse=True)[1].ravel()
    more = len(evidence.residual) - len(group)
    return np.concatenate([group, np.full(more, group.max() + 1)]) if more else np.asarray(group)


def _gains(evidence: Evidence, basis: Array, group: Array, weights: Array) -> Array:
    """Drop of the squared residual (D,) by the columns of a basis, model and columns fitted with weights (D, G)."""
    known = evidence.model.shape[1]
    Z = np.hstack([evidence.model, basis, evidence.residual[:, None]])
    order = np.argsort(group, kind="stable")
    starts = np.searchsorted(group[order], np.arange(weights.shape[1]))
    parts = np.split(Z[order], starts[1:])
    grams = np.array([part.T @ part for part in parts])
    sums = np.tensordot(weights, grams, axes=1)
    return _explained(sums, sums.shape[1] - 1) - _explained(sums, known)


def _explained(sums: Array, columns: int) -> Array:
    """Squared length (D,) of the last column along the first ones, from Gram matrices (D, K, K)."""
    if columns == 0:
        return np.zeros(len(sums))
    A, b = sums[:, :columns, :columns], sums[:, :columns, -1]
    A = A + 1e-10 * np.trace(A, axis1=1, axis2=2)[:, None, None] * np.eye(columns)
    return np.asarray(np.einsum("dk,dk->d", b, np.linalg.solve(A, b[:, :, None])[:, :, 0]))
