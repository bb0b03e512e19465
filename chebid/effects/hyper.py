"""Hyper-parameters: numbers of an effect that its torque is not linear in, with their meaning, unit and range.

An effect has them as fields: `vs: float = setting("Stribeck velocity", "velocity", above=0)`.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.effects.units import Units
from chebid.robots import Array

REQUIRED = dataclasses.MISSING


@dataclass(frozen=True)
class Hyper:
    """`unit` is a name of `Units` (velocity, position, wave ...), a unit (s, 1), or `joint` for another joint.

    The range is low <= value <= high, without its ends where `open_low` and `open_high` say so; `choices` are the
    only values where given.
    """

    meaning: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    choices: tuple[float, ...] = ()
    whole: bool = False

    @property
    def continuous(self) -> bool:
        """Whether it can be refined between the values of a grid."""
        return not self.choices and not self.whole and self.unit != "joint"

    def check(self, given: Any) -> float | int:
        """The value as a number. Raises ValueError that says what is wrong with it."""
        value = number(given)
        if self.whole and value != int(value):
            raise ValueError("is not a whole number")
        if not self.allows(value):
            raise ValueError("is out of range")
        return int(value) if self.whole else value

    def allows(self, value: float) -> bool:
        if self.choices:
            return value in self.choices
        above = value > self.low if self.open_low else value >= self.low
        below = value < self.high if self.open_high else value <= self.high
        return above and below

    def range(self) -> str:
        """The range in words."""
        if self.unit == "joint":
            return "the name of another joint"
        if self.choices:
            return " or ".join(f"{choice:g}" for choice in self.choices)
        kind = "a whole number" if self.whole else ""
        low = "" if math.isinf(self.low) else f"{'above' if self.open_low else 'from'} {self.low:g}"
        high = "" if math.isinf(self.high) else f"{'below' if self.open_high else 'up to'} {self.high:g}"
        return " ".join(part for part in (kind, low, high) if part) or "any number"

    def describe(self, units: Units) -> str:
        """Meaning, unit and range."""
        unit = units.named(self.unit)
        shown = "" if unit in ("1", "joint") else f" [{unit}]"
        return f"{self.meaning}{shown}; {self.range()}"

    def clip(self, low: float, high: float) -> tuple[float, float]:
        """The part of an interval that lies in the range."""
        margin = 1e-6 * (high - low)
        low = max(low, self.low + (margin if self.open_low else 0.0))
        return low, min(high, self.high - (margin if self.open_high else 0.0))


def setting(
    meaning: str,
    unit: str,
    default: Any = REQUIRED,
    *,
    above: float | None = None,
    below: float | None = None,
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[float, ...] = (),
    whole: bool = False,
) -> Any:
    """A dataclass field for a hyper-parameter; without a default it must be given."""
    least = low if above is None else above
    most = high if below is None else below
    hyper = Hyper(meaning, unit, least, most, above is not None, below is not None, choices, whole)
    return dataclasses.field(default=default, metadata={"hyper": hyper})


def number(given: Any) -> float:
    """A finite float from what YAML gives: 1e-3 is text there. Raises ValueError."""
    if isinstance(given, bool) or not isinstance(given, int | float | str | np.number):
        raise ValueError("is not a number")
    try:
        value = float(given)
    except (ValueError, OverflowError):
        raise ValueError("is not a number") from None
    if not math.isfinite(value):
        raise ValueError("is not a finite number")
    return value


@dataclass(frozen=True)
class Extent:
    """What a motion covers on one joint: positions low to high, usual top speed, gate, instants, rate."""

    low: float
    high: float
    top: float
    gate: float
    start: float
    end: float
    rate: float

    @property
    def span(self) -> float:
        return max(self.high - self.low, np.finfo(float).tiny)

    @property
    def duration(self) -> float:
        return max(self.end - self.start, np.finfo(float).tiny)


def extent(t: Array, q: Array, dq: Array, gate: float = 0.0) -> Extent:
    """Of a joint's t, q, dq (N,); top is the 95th percentile of speed, a gate of zero becomes 2 % of it."""
    top = max(float(np.percentile(np.abs(dq), 95)), float(np.finfo(float).tiny))
    rate = (len(t) - 1) / max(float(t[-1] - t[0]), np.finfo(float).tiny)
    return Extent(float(q.min()), float(q.max()), top, gate or 0.02 * top, float(t[0]), float(t[-1]), rate)
