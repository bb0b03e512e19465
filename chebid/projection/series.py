"""`Series`: a function of time given by polynomial coefficients on the windows of a record."""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array, Family
from chebid.projection.layout import Layout


@dataclass(frozen=True)
class Series:
    """x(t) for J signals: `coefficients` (W, n + 1, J), one polynomial of degree n per window of `layout` (eq. 6)."""

    family: Family
    layout: Layout
    coefficients: Array

    @property
    def degree(self) -> int:
        return self.coefficients.shape[1] - 1

    def __call__(self, t: Array, order: int = 0) -> Array:
        """Values (N, J) of the derivative of that order at sorted times `t` (N,) in s (eq. 6, 13, 14).

        In a blend of two windows the derivative is the blend of their derivatives.
        """
        t = np.asarray(t, dtype=float)
        out = np.zeros((len(t), self.coefficients.shape[2]))
        for window in self.layout.touched(t):
            where = self.layout.active(window, t)
            tau = self.layout.tau(window, t[where])
            values = self.family.evaluate(tau, self.derivative(window, order))
            out[where] += self.layout.weight(window, t[where])[:, None] * values
        return out

    def derivative(self, window: int, order: int) -> Array:
        """Coefficients (n + 1, J) of the derivative with respect to time on one window: eq. 13 and 14."""
        scale = self.layout.half[window] ** -order
        return scale * self.family.differentiate(self.coefficients[window], order)
