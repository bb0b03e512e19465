"""The operator on one window: samples -> coefficients, as two small matrices per fold."""

from dataclasses import dataclass

import numpy as np

from chebid.basis import CHEBYSHEV, LEGENDRE, Array, Family, convert
from chebid.projection.fold import Fold, folds
from chebid.projection.modes import Frame, frame
from chebid.projection.plan import Plan


@dataclass(frozen=True)
class Local:
    """Coefficients (n_b,) = synthesis (n_b, k) @ Q^T x (k,), on one fold."""

    frame: Frame
    synthesis: Array
    trace: float  # of the map from samples to fitted samples

    def fit(self, x: Array) -> Array:
        """Coefficients (..., n_b) of samples (..., N)."""
        return self.frame.coordinates(x) @ self.synthesis.T

    @property
    def degrees(self) -> slice:
        """Which of the coefficients c_0 .. c_n these are."""
        return self.frame.fold.degrees(self.frame.degree)


def make_locals(tau: Array, half: float, plan: Plan, target: Family) -> tuple[Local, ...]:
    """The operator of `plan` on samples at tau (N,) of a window of half-length `half` s, coefficients in `target`."""
    make = _penalised if plan.fit == "smooth" else _least_squares
    return tuple(make(tau, half, plan, target, fold) for fold in folds(tau))


def _least_squares(tau: Array, half: float, plan: Plan, target: Family, fold: Fold) -> Local:
    made = frame(tau, plan.degree, fold, CHEBYSHEV)
    synthesis = _converted(made.inverse(), fold, plan.degree, CHEBYSHEV, target)
    return Local(made, synthesis, float(len(synthesis)))


def _penalised(tau: Array, half: float, plan: Plan, target: Family, fold: Fold) -> Local:
    made = frame(tau, plan.degree, fold, LEGENDRE)
    spectrum = plan.spectrum.scaled(1 / (2 * half))
    modes = made.modes(spectrum)
    weight = float(spectrum.weight(plan.penalty * 2 * half, len(tau) - 1))
    synthesis = _converted(modes.coefficients(weight), fold, plan.degree, LEGENDRE, target)
    return Local(made, synthesis, modes.free + float(modes.transfer(weight).sum()))


def _converted(rows: Array, fold: Fold, degree: int, source: Family, target: Family) -> Array:
    """Coefficients of one fold (n_b, k) in another family: no family mixes even and odd degrees."""
    whole = np.zeros((degree + 1, rows.shape[1]))
    whole[fold.degrees(degree)] = rows
    return convert(whole, source, target)[fold.degrees(degree)]
