"""`Operator`: the linear map from the samples of a record to a `Series`, for one `Plan` and one set of instants.

Every command goes through it: project, derive, identify and the critique apply it to signals, freqresp to sines.
On a uniform grid all windows are alike: they are fitted, and evaluated at the samples, as one matrix product.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chebid.basis import CHEBYSHEV, Array, Family, chebyshev_points, convert, family, interpolate
from chebid.errors import NoAnswerError, UsageError
from chebid.projection.clock import is_uniform
from chebid.projection.comb import Comb
from chebid.projection.fold import symmetric_grid
from chebid.projection.layout import Layout, divide, samples_in
from chebid.projection.local import Local, make_locals
from chebid.projection.normal import least_squares
from chebid.projection.plan import FITS, Plan, limit
from chebid.projection.quadrature import quadrature_coefficients
from chebid.projection.series import Series
from chebid.projection.threads import single

_FEWEST = 12  # samples of a window among several that has polynomials of its own


class Operator:
    """Projection of signals sampled at times `t` (N,) s, strictly increasing, according to `plan`."""

    def __init__(self, t: Array, plan: Plan) -> None:
        self.t = np.asarray(t, dtype=float)
        self.plan = plan
        self.layout = divide(self.t, plan.window) if plan.window else Layout(self.t[:1].copy(), self.t[-1:].copy())
        self.family: Family = family(plan.basis)
        self._made: dict[int, tuple[Local, ...]] = {}
        self._gains: dict[int, Array] = {}
        self._check()

    def _check(self) -> None:
        if self.plan.fit not in FITS:
            raise UsageError(f"unknown fit {self.plan.fit!r}", hint=f"choose one of: {', '.join(FITS)}")
        first, last = self._bounds
        usual = int(np.median(last - first))
        most = limit(self.plan.fit, usual)
        if self.plan.degree > most:
            raise NoAnswerError(
                f"degree {self.plan.degree} is too high for {usual} samples: at most {most} with fit {self.plan.fit}",
                hint="take a lower degree, a longer record or a higher rate; or let chebid choose (no degree)",
            )

    @cached_property
    def uniform(self) -> bool:
        return is_uniform(self.t)

    @property
    def freedom(self) -> float:
        """Degrees of freedom that the fit takes from each sample: trace of H over the samples of a window."""
        smooth = self.plan.fit == "smooth"
        taken = sum(local.trace for local in self._locals(0)) if smooth else self.plan.degree + 1.0
        return taken / len(self._tau(0))

    @single
    def fit(self, x: Array) -> Series:
        """Series of the signals x (N,) or (N, J)."""
        signals = np.ascontiguousarray(np.asarray(x, dtype=float).reshape(len(self.t), -1).T)
        level = signals.mean(axis=1, keepdims=True)  # taken out: a large offset would cost digits of the motion
        coefficients = self._coefficients(signals - level)
        coefficients[:, 0] += level[:, 0]
        return Series(self.family, self.layout, coefficients)

    def _coefficients(self, x: Array) -> Array:
        """(W, n + 1, J) of signals (J, N)."""
        out = np.zeros((self.layout.count, self.plan.degree + 1, len(x)))
        if self.plan.fit == "quadrature" or (self.plan.fit == "lsq" and self.layout.count == 1):
            for window in range(self.layout.count):
                out[window] = self._whole(self._tau(window), x[:, self._slice(window)].T)
        elif self._comb is not None:
            views = self._comb.views(x)
            for windows in self._comb.batches(len(x)):
                self._fill(out[windows], views[:, windows], 0)
        else:
            for window in range(self.layout.count):
                self._fill(out[window : window + 1], x[:, None, self._slice(window)], window)
        return out

    def _whole(self, tau: Array, x: Array) -> Array:
        """The fits that need no matrix (N, n): coefficients (n + 1, J) of samples (N, J)."""
        if self.plan.fit == "quadrature":
            return quadrature_coefficients(tau, x, self.plan.degree, self.family)
        return convert(least_squares(tau, x, self.plan.degree), CHEBYSHEV, self.family)

    def _fill(self, out: Array, x: Array, window: int) -> None:
        """Coefficients (W_b, n + 1, J) of samples (J, W_b, N_w) of windows that share the operator of `window`."""
        for local in self._locals(window):
            out[:, local.degrees] = local.fit(x).transpose(1, 2, 0)

    @single
    def at_samples(self, series: Series, order: int = 0) -> Array:
        """Values (N, J) of a derivative at the operator's own instants: `series(t, order)`, fast on uniform grids."""
        comb = self._comb
        if comb is None or comb.count == 1:
            return series(self.t, order)
        where, signals = comb.blended, series.coefficients.shape[2]
        out = np.empty((signals, len(self.t)))
        out[:, : where.start] = series(self.t[: where.start], order).T
        out[:, where] = comb.blend(lambda windows: self._middles(series, windows, order), signals)
        out[:, where.stop :] = series(self.t[where.stop :], order).T
        return out.T

    def _middles(self, series: Series, windows: slice, order: int) -> Array:
        """Values (J, W_b, N_w - 2 skip) of a derivative in the middle of windows, from even and odd polynomials."""
        assert self._comb is not None
        size, skip = self._comb.size, self._comb.skip
        c = series.family.differentiate(series.coefficients[windows].transpose(1, 2, 0), order)
        c = c * float(self.layout.half[0]) ** -order
        even, odd = (np.tensordot(c[p::2], self._left[p::2, skip:], (0, 0)) for p in (0, 1))
        right = (even - odd)[..., : size // 2 - skip]
        return np.concatenate([even + odd, right[..., ::-1]], axis=-1)

    @cached_property
    def _left(self) -> Array:
        """Polynomials (n + 1, (N_w + 1) / 2) on the left half of a window, its middle included."""
        tau = self._tau(0)
        return np.ascontiguousarray(self.family.values(tau[: (len(tau) + 1) // 2], self.plan.degree).T)

    @single
    def noise_gain(self, order: int) -> Array:
        """Standard deviation (N,) of a derivative at the samples per unit of white noise on them.

        In blends that of both windows, blended: an upper bound, as their noises are not quite the same.
        """
        if order not in self._gains:
            orders = (order,) if self._comb else (*{0, 1, 2, order},)  # uneven: every window is made anew
            self._gains.update(zip(orders, self._noise_gains(orders), strict=True))
        return self._gains[order]

    def _noise_gains(self, orders: tuple[int, ...]) -> Array:
        if self._comb is not None:
            return np.stack([self._comb.repeat(gain) for gain in self._window_gains(0, orders)])
        out = np.zeros((len(orders), len(self.t)))
        for w in range(self.layout.count):
            where, first = self.layout.active(w, self.t), self._slice(w).start
            gains = self._window_gains(w, orders)[:, where.start - first : where.stop - first]
            out[:, where] += self.layout.weight(w, self.t[where]) * gains
        return out

    def _window_gains(self, window: int, orders: tuple[int, ...]) -> Array:
        """(K, N_w) at the samples of a window. The squares are polynomials of degree 2 n: fewer points tell them."""
        tau, count = self._tau(window), 2 * self.plan.degree + 1
        if len(tau) <= 2 * count:
            return np.sqrt(self._squared_gains(window, tau, orders))
        nodes = chebyshev_points(count)
        square = CHEBYSHEV.evaluate(tau, interpolate(self._squared_gains(window, nodes, orders).T)).T
        return np.sqrt(np.maximum(square, 0.0))

    def _squared_gains(self, window: int, tau: Array, orders: tuple[int, ...]) -> Array:
        """(K, M) at tau (M,): norms of the rows of P D^k synthesis, those of Q being orthonormal."""
        values, out = self.family.values(tau, self.plan.degree), np.zeros((len(orders), len(tau)))
        for local in self._locals(window):
            whole = np.zeros((self.plan.degree + 1, local.synthesis.shape[1]))
            whole[local.degrees] = local.synthesis
            for square, order in zip(out, orders, strict=True):
                derivative = self.family.differentiate(whole, order) * float(self.layout.half[window]) ** -order
                square += np.sum((values @ derivative) ** 2, axis=1)
        return out

    # --- windows

    @cached_property
    def _bounds(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        return samples_in(self.t, self.layout)

    def _slice(self, window: int) -> slice:
        return slice(int(self._bounds[0][window]), int(self._bounds[1][window]))

    @cached_property
    def _comb(self) -> Comb | None:
        """The windows, where all of them hold the same local grid."""
        first, last = self._bounds
        if not self.uniform:
            return None
        return Comb(int(last[0]), int(first[1]) if len(first) > 1 else int(last[0]), len(first))

    def _tau(self, window: int) -> Array:
        """Local times of the samples of a window; exactly symmetric where the grid is uniform."""
        where = self._slice(window)
        if self.uniform:
            return symmetric_grid(where.stop - where.start)
        return np.clip(self.layout.tau(window, self.t[where]), -1.0, 1.0)

    def _locals(self, window: int) -> tuple[Local, ...]:
        key = 0 if self._comb else window
        if key not in self._made:
            self._made.clear()  # on uneven stamps every window has its own: one is kept
            tau, half = self._tau(key), float(self.layout.half[key])
            # a gap leaves fewer samples to some windows, or none: they bear a lower degree, or stay at the mean
            starved = self.layout.count > 1 and len(tau) < _FEWEST
            plan = replace(self.plan, degree=min(self.plan.degree, limit(self.plan.fit, len(tau))))
            self._made[key] = () if starved else make_locals(tau, half, plan, self.family)
        return self._made[key]
