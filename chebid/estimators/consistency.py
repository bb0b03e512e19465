"""Is least squares as good as instrumental variables here? A revised Durbin-Wu-Hausman test.

Janot, Vandanjon, Gautier, Control Eng. Practice 48, 2016. W is split into what the instruments explain, Z Z^+ W, and
the rest V. If noise of the positions in W went along with the residuals, least squares would be biased, and V would
explain a part of Y beyond W: a QR factorisation of [W V] gives the part, an F-test says whether it is more than
chance. That the instruments themselves are valid is seen first, from how much of W they explain.

The F-test wants rows of equal variance, and V is widest where the noise of positions is, at high frequency: rows are
divided by the deviation that the residual has at their frequency. A test on many rows finds noise in W long before it
matters: `shift` says how far it moves the estimate.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from chebid.basis import Array
from chebid.equations import Rows
from chebid.estimators.restricted import restricted_variance

_LEVEL = 0.05
_RELEVANT = 0.9  # of the energy of every column of W
_LITTLE = 0.3  # of a deviation: takes an interval of 95 % to 94 %
_RANK = 1e-7  # of a column of W: what is left of it in V beyond that is more than rounding


@dataclass(frozen=True)
class Consistency:
    """F statistic, its degrees of freedom, p value; `relevance`: the least share of a column of W that Z explains.

    `shift`: largest difference between the estimates by least squares and by instruments, in deviations.
    """

    statistic: float
    freedom: tuple[int, int]
    p_value: float
    relevance: float
    shift: float | None = None

    @property
    def consistent(self) -> bool | None:
        """Whether least squares passes; None when the instruments are too weak to tell."""
        return None if self.relevance < _RELEVANT else self.p_value >= _LEVEL

    @property
    def message(self) -> str:
        """In words."""
        if self.consistent is None:
            return (
                f"no answer: the simulated motion explains only {100 * self.relevance:.0f} % of a column of W; check "
                "the control law and the reference"
            )
        test = f"F({self.freedom[0]}, {self.freedom[1]}) = {self.statistic:.2f}, p = {self.p_value:.2g}"
        if self.consistent:
            return f"least squares is as consistent as instrumental variables ({test})"
        if self.shift is not None and self.shift < _LITTLE:
            return f"noise in W is seen, but moves least squares by at most {self.shift:.2g} deviations ({test})"
        return f"least squares is biased by noise in W: lower the bandwidth, or use iv ({test})"

    def document(self) -> dict[str, object]:
        """For JSON and `fit.record`."""
        return {
            "statistic": self.statistic,
            "freedom": list(self.freedom),
            "p_value": self.p_value,
            "relevance": self.relevance,
            "shift": self.shift,
            "consistent": self.consistent,
            "message": self.message,
        }


def hausman(rows: Rows, Z: Array, sigma: Array) -> Consistency:
    """Test the rows of least squares against instruments Z (R, P); `sigma` (J,) residual deviation of each joint."""
    weight = 1 / (sigma[rows.joint] * _coloured(rows, sigma))[:, None]
    W, Z, Y = rows.W * weight, Z * weight, rows.Y * weight[:, 0]
    size = np.linalg.norm(W, axis=0)
    size[size == 0] = 1.0
    basis = np.linalg.qr(Z / np.maximum(np.linalg.norm(Z, axis=0), np.finfo(float).tiny))[0]
    W = W / size
    V = W - basis @ (basis.T @ W)
    relevance = float(1 - np.max(np.sum(V**2, axis=0)))
    q = np.linalg.qr(W)[0]
    V -= q @ (q.T @ V)
    u, singular, _ = np.linalg.svd(V, full_matrices=False)
    extra = u[:, singular > _RANK]
    residual = Y - q @ (q.T @ Y)
    explained, freedom = (
        float(np.sum((extra.T @ residual) ** 2)),
        (extra.shape[1], len(Y) - W.shape[1] - extra.shape[1]),
    )
    if not freedom[0] or freedom[1] < 1:
        return Consistency(0.0, freedom, 1.0, relevance)
    left = float(residual @ residual) - explained
    statistic = explained / freedom[0] / max(left / freedom[1], np.finfo(float).tiny)
    return Consistency(statistic, freedom, float(f_distribution.sf(statistic, *freedom)), relevance)


def _coloured(rows: Rows, sigma: Array) -> Array:
    """Deviation (R,) of the residual at each row's frequency, over that of its joint."""
    out = np.ones(len(rows.Y))
    for j, size in enumerate(sigma):
        mine = rows.joint == j
        out[mine] = np.sqrt(restricted_variance(rows.W[mine] / size, rows.Y[mine] / size, rows.frequency[mine]))
    return out
