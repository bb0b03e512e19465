"""`project`: one signal of one record, from samples to a `Series` with its quality."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.errors import NoAnswerError, Notice, Place
from chebid.projection.choose import Setting, plan
from chebid.projection.clock import rate_of
from chebid.projection.operator import Operator
from chebid.projection.plan import Plan
from chebid.projection.quality import (
    TOLERATED_SHARE,
    end_length,
    energy_beyond,
    energy_left_out,
    inside,
    lag1_autocorrelation,
    noise_floor,
)
from chebid.projection.series import Series

_LIMIT = 0.35  # of the rate: a bandwidth above leaves nothing to tell motion from noise by
_UPPER = 0.2  # of the rate: where no motion that a log resolves has much of its accelerations


@dataclass(frozen=True)
class Projection:
    """A projected signal: `t`, `x` (N,) the samples that were used, the operator that was applied, and the result."""

    name: str
    t: Array
    x: Array
    operator: Operator
    series: Series

    @property
    def plan(self) -> Plan:
        return self.operator.plan

    def at(self, t: Array, order: int = 0) -> Array:
        """The derivative (N,) at times t (N,); fast at the instants of the samples themselves."""
        if t is self.t or (len(t) == len(self.t) and np.array_equal(t, self.t)):
            return self.operator.at_samples(self.series, order)[:, 0]
        return self.series(t, order)[:, 0]

    @cached_property
    def residual(self) -> Array:
        """Samples less projection (N,)."""
        return self.x - self.at(self.t)

    @cached_property
    def _inside(self) -> slice:
        """Samples where no end effect disturbs the positions."""
        return inside(self.operator, 0)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the noise on the samples: residual over its degrees of freedom, inside the ends."""
        residual, freedom = self.residual[self._inside], min(self.operator.freedom, 1 - 1 / len(self.t))
        scale = float(np.max(np.abs(residual))) or 1.0  # squares of very small units underflow
        return scale * float(np.sqrt(np.mean((residual / scale) ** 2) / (1 - freedom)))

    @cached_property
    def lag1_autocorrelation(self) -> float:
        return lag1_autocorrelation(self.residual[self._inside])

    @cached_property
    def energy_left_out(self) -> float:
        """Share of the acceleration's energy above the bandwidth, noise removed."""
        where = inside(self.operator, 2)
        parts = self.t[where], self.at(self.t, 2)[where], self.residual[where]
        return energy_left_out(*parts, self.plan.bandwidth, noise_floor(self.x, rate_of(self.t)))

    @property
    def rate(self) -> float:
        """Hz."""
        return rate_of(self.t)

    @cached_property
    def at_the_limit(self) -> bool:
        """Whether the bandwidth is next to half the rate, and accelerations go up there (a log free of noise may have
        such a bandwidth without).
        """
        if self.plan.bandwidth <= _LIMIT * self.rate:
            return False
        where = inside(self.operator, 2)
        return energy_beyond(self.t[where], self.at(self.t, 2)[where], _UPPER * self.rate) > TOLERATED_SHARE

    def end_length(self, order: int = 2) -> float:
        """Seconds at each end where the noise of the derivative is beyond twice its median."""
        return end_length(self.operator, order)

    def valid(self, order: int = 2) -> NDArray[np.bool_]:
        """Which samples (N,) lie outside the ends."""
        out = np.zeros(len(self.t), dtype=bool)
        out[inside(self.operator, order)] = True
        return out

    def notices(self) -> list[Notice]:
        """Warnings that predict a bad identification (paper, introduction, on Pacheco and Steffen)."""
        out = []
        if self.energy_left_out > TOLERATED_SHARE:
            out.append(
                Notice(
                    "wide_band",
                    f"{100 * self.energy_left_out:.2g} % of the acceleration's energy lies above the bandwidth of "
                    f"{self.plan.bandwidth:.3g} Hz: inertias will be biased; raise the bandwidth or excite more slowly",
                    Place(column=self.name),
                )
            )
        if self.at_the_limit:
            out.append(
                Notice(
                    "wide_band",
                    f"the bandwidth of {self.plan.bandwidth:.3g} Hz is next to half the rate of {self.rate:.4g} Hz: "
                    "the signal has accelerations up to there, faster than the log can tell, and inertias will be "
                    "biased; record at a higher rate, excite more slowly, or set a bandwidth",
                    Place(column=self.name),
                )
            )
        duration = float(self.t[-1] - self.t[0])
        if self.end_length() > 0.1 * duration:
            out.append(
                Notice(
                    "ends",
                    f"accelerations are noisy within {self.end_length():.3g} s of the ends, {duration:.3g} s in all; "
                    "those samples are marked invalid (a lower degree or fit 'smooth' keeps more)",
                    Place(column=self.name),
                )
            )
        return out


def project(t: Array, x: Array, setting: Setting | Plan, name: str = "x") -> Projection:
    """Project the samples x (N,) at t (N,) s; NaN samples are left out. `setting` may be a `Plan` already made.

    Raises NoAnswerError when too few samples are left, and what `plan` raises.
    """
    good = np.isfinite(x)
    if good.sum() < 4:
        raise NoAnswerError(
            f"only {int(good.sum())} usable samples",
            hint="check the column for missing values",
            place=Place(column=name),
        )
    if not good.all():
        t, x = t[good], x[good]
    chosen = setting if isinstance(setting, Plan) else plan(t, x, setting)
    operator = Operator(t, chosen)
    return Projection(name, t, x, operator, operator.fit(x))
