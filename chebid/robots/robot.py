"""What a robot is to the rest of chebid: named parameters and a regressor."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """One parameter of a model: `name` is unique, `joint` None for one of the whole arm."""

    name: str
    joint: str | None
    unit: str


class Robot(Protocol):
    """A rigid mechanism of J joints whose torques are linear in `parameters` (eq. 17)."""

    @property
    def joints(self) -> tuple[str, ...]: ...

    @property
    def rotary(self) -> tuple[bool, ...]:
        """Which joints turn (rad, N.m) rather than slide (m, N)."""
        ...

    @property
    def positive(self) -> tuple[str, ...]:
        """Names of parameters that no real robot has below zero."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]: ...

    def regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """D_S of eq. 17 at N samples: q, dq, ddq (N, J) -> (N, J, P)."""
        ...
