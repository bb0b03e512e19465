"""`Estimate`: what every estimator returns."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from chebid.basis import Array
from chebid.errors import Notice
from chebid.robots import Parameter


@dataclass(frozen=True)
class JointResidual:
    """Fit of one joint on the rows that identification uses, in N.m or N; `relative_raw` takes every sample as logged.

    `floor`: rms that noise alone would leave on these rows; `ratio` = rms / floor.
    """

    rms: float
    relative: float
    relative_raw: float | None
    floor: float | None
    floor_kind: str

    @property
    def ratio(self) -> float | None:
        return self.rms / self.floor if self.floor else None


@dataclass(frozen=True)
class Lag:
    """Lag in s of the torque behind the positions, beyond the model file's `torque_delay`, and its deviation."""

    value: float
    sd: float


@dataclass(frozen=True)
class Estimate:
    """Parameters theta (P,) with their covariances, and how they came about.

    `covariance` is the honest one (correlation and frequency dependence of the residuals counted), `white` that of
    eq. 25, which takes the residuals for white noise.
    """

    method: str
    parameters: tuple[Parameter, ...]
    theta: Array
    covariance: Array
    white: Array
    condition: float
    residual: dict[str, JointResidual]
    weights: Array
    lag: Lag | None = None
    record: dict[str, Any] = field(default_factory=dict)
    notices: tuple[Notice, ...] = ()

    @property
    def sd(self) -> Array:
        """Honest standard deviations (P,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def sd_white(self) -> Array:
        """Standard deviations (P,) of eq. 25."""
        return np.sqrt(np.diag(self.white))

    def relative(self, sd: Array) -> Array:
        """Relative deviations (P,) in percent (eq. 26); infinite where the value is zero."""
        with np.errstate(divide="ignore"):
            return 100 * sd / np.abs(self.theta)
