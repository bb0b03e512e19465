"""`Operator`: the linear map from the samples of a record to a `Series`, for one `Plan` and one set of instants.

Every command goes through it: project, derive, identify and the critique apply it to signals, freqresp to sines.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from chebid.basis import CHEBYSHEV, Array, Family, convert, family
from chebid.errors import NoAnswerError, UsageError
from chebid.projection.layout import Layout, divide
from chebid.projection.modes import DegreeModes, PenaltyModes, degree_modes, penalty_modes
from chebid.projection.quadrature import quadrature_coefficients
from chebid.projection.series import Series
from chebid.projection.sums import normal_blocks

FITS = ("lsq", "quadrature", "smooth")
_UNEVEN = 1e-4  # steps: stamps nearer than this to a uniform grid are uniform, 100 ns at 1 kHz


@dataclass(frozen=True)
class Plan:
    """What an operator is to do. `window` s (None: the whole record), `penalty` Hz: half-gain frequency of the penalty.

    `bandwidth` Hz is the frequency up to which the plan lets signals pass: n / (pi T) for one least-squares window, in
    its middle (facts: n_c = pi f T polynomials resolve a sine).
    """

    fit: str = "lsq"
    basis: str = "chebyshev"
    degree: int = 0
    window: float | None = None
    penalty: float = np.inf
    bandwidth: float = 0.0
    reason: str = ""

    def weight(self, rate: float, half: float) -> float:
        """Penalty in units of tau for samples at `rate` Hz on a window of half-length `half` s.

        In time, sum_k r_k^2 + w int (x'''')^2 dt has the gain 1 / (1 + (f / f0)^8) inside a record: that of a
        4th-order Butterworth filter forward and backward. f0 = `penalty`; the 7 comes from d^4/dt^4 squared and dt.
        """
        return rate * (2 * np.pi * self.penalty) ** -8 * half**-7


@dataclass(frozen=True)
class _Local:
    """The operator on one window: U^T (m, N), coefficients per mode (n + 1, m), gain included, and the trace of H."""

    analysis: Array
    synthesis: Array
    trace: float


class Operator:
    """Projection of signals sampled at times `t` (N,) s, strictly increasing, according to `plan`."""

    def __init__(self, t: Array, plan: Plan) -> None:
        self.t = np.asarray(t, dtype=float)
        self.plan = plan
        self.layout = divide(self.t, plan.window) if plan.window else Layout(self.t[:1].copy(), self.t[-1:].copy())
        self.family: Family = family(plan.basis)
        self._check()

    def _check(self) -> None:
        if self.plan.fit not in FITS:
            raise UsageError(f"unknown fit {self.plan.fit!r}", hint=f"choose one of: {', '.join(FITS)}")
        fewest = min(self._slice(w).stop - self._slice(w).start for w in range(self.layout.count))
        most = limit(self.plan.fit, fewest)
        if self.plan.degree > most:
            raise NoAnswerError(
                f"degree {self.plan.degree} is too high for {fewest} samples: at most {most} with fit {self.plan.fit}",
                hint="take a lower degree, a longer record or a higher rate; or let chebid choose (no degree)",
            )

    @cached_property
    def uniform(self) -> bool:
        return is_uniform(self.t)

    def fit(self, x: Array) -> Series:
        """Series of the signals x (N,) or (N, J)."""
        x = x.reshape(len(self.t), -1)
        coefficients = np.stack([self._fit_window(w, x[self._slice(w)]) for w in range(self.layout.count)])
        return Series(self.family, self.layout, coefficients)

    def _fit_window(self, window: int, x: Array) -> Array:
        if self.plan.fit == "quadrature":
            return quadrature_coefficients(self._tau(window), x, self.plan.degree, self.family)
        if self.plan.fit == "lsq" and self.layout.count == 1:
            return convert(_least_squares(self._tau(0), x, self.plan.degree), CHEBYSHEV, self.family)
        local = self._local(window)
        return local.synthesis @ (local.analysis @ x)

    def at_samples(self, series: Series, order: int = 0) -> Array:
        """Values (N, J) of a derivative at the operator's own instants: `series(t, order)`, fast on uniform grids."""
        if not self._repeating:
            return series(self.t, order)
        out = np.zeros((len(self.t), series.coefficients.shape[2]))
        values = self.family.values(self._tau(0), self.plan.degree)
        for window in range(self.layout.count):
            here, where = self._slice(window), self.layout.active(window, self.t)
            rows = values[where.start - here.start : where.stop - here.start]
            blend = self.layout.weight(window, self.t[where])
            out[where] += blend[:, None] * (rows @ series.derivative(window, order))
        return out

    def noise_gain(self, order: int) -> Array:
        """Standard deviation (N,) of a derivative at the samples per unit of white noise on them, blends neglected."""
        out = np.empty(len(self.t))
        for w in range(self.layout.count):
            where, here = self.layout.active(w, self.t), self._slice(w)
            gains = self._window_gain(0 if self._repeating else w, order)
            out[where] = gains[where.start - here.start : where.stop - here.start]
        return out

    def _window_gain(self, window: int, order: int) -> Array:
        # fit the identity through the modes of this window: rows of the map have the norm of E G
        tau = self._tau(window)
        local = self._local(window)
        coefficients = self.family.differentiate(local.synthesis, order) * self.layout.half[window] ** -order
        return np.linalg.norm(self.family.evaluate(tau, coefficients), axis=1)

    @property
    def freedom(self) -> float:
        """Degrees of freedom that the fit takes from each sample: trace of H over the samples of a window."""
        where = self._slice(0)
        taken = self._local(0).trace if self.plan.fit == "smooth" else self.plan.degree + 1.0
        return taken / (where.stop - where.start)

    @cached_property
    def _repeating(self) -> bool:
        """Whether all windows hold the same local grid."""
        sizes = {self._slice(w).stop - self._slice(w).start for w in range(self.layout.count)}
        return self.uniform and len(sizes) == 1

    def _slice(self, window: int) -> slice:
        step = (self.t[-1] - self.t[0]) / max(len(self.t) - 1, 1)
        first = np.searchsorted(self.t, self.layout.start[window] - step / 4)
        last = np.searchsorted(self.t, self.layout.stop[window] + step / 4)
        return slice(int(first), int(last))

    def _tau(self, window: int) -> Array:
        """Local times of the samples of a window; exactly symmetric where the grid is uniform."""
        where = self._slice(window)
        if self.uniform:
            grid = np.linspace(-1.0, 1.0, where.stop - where.start)
            return (grid - grid[::-1]) / 2
        return np.clip(self.layout.tau(window, self.t[where]), -1.0, 1.0)

    def _local(self, window: int) -> _Local:
        key = 0 if self._repeating else window
        if key not in self._locals:
            if not self._repeating:
                self._locals.clear()  # every window has its own: keep one
            self._locals[key] = self._make_local(key)
        return self._locals[key]

    @cached_property
    def _locals(self) -> dict[int, _Local]:
        return {}

    def _make_local(self, window: int) -> _Local:
        tau = self._tau(window)
        modes: DegreeModes | PenaltyModes
        if self.plan.fit == "smooth":
            modes = penalty_modes(tau, self.plan.degree)
            half = float(self.layout.half[window])
            setting = self.plan.weight((len(tau) - 1) / (2 * half), half)
        else:
            modes = degree_modes(tau, self.plan.degree)
            setting = self.plan.degree
        synthesis = convert(modes.synthesis * modes.gain(setting), modes.family, self.family)
        return _Local(np.ascontiguousarray(modes.samples.T), synthesis, float(modes.transfer(setting).sum()))


def is_uniform(t: Array) -> bool:
    """Whether the stamps are a uniform grid, to a ten-thousandth of a step."""
    grid = np.linspace(t[0], t[-1], len(t))
    return bool(np.max(np.abs(t - grid)) <= _UNEVEN * (t[-1] - t[0]) / (len(t) - 1))


def limit(fit: str, samples: int) -> int:
    """Highest degree for so many samples: 4 sqrt(N) for the projections of the paper (beyond, the ends explode), and
    four fifths of the samples for the penalised one.
    """
    if fit == "smooth":
        return max(4, int(0.8 * (samples - 1)))
    return max(0, min(samples - 1, int(4 * np.sqrt(samples))))


def _least_squares(tau: Array, x: Array, degree: int) -> Array:
    """Chebyshev coefficients (n + 1, J) of eq. 11 by the fast normal equations, safe up to `limit`."""
    out = np.zeros((degree + 1, x.shape[1]))
    for where, matrix, moments in normal_blocks(tau, x, degree):
        out[where] = scipy.linalg.cho_solve(scipy.linalg.cho_factor(matrix), moments)
    return out
