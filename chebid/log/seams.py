"""Jumps of position that no velocity explains: turns of an angle, short excursions, and seams between records.

A jump is a step several times as fast as the log's fastest motion (the speed that one step in a thousand
exceeds), alone among its neighbours, and of more than a few encoder counts. By a whole turn of an angle that stays
within one turn it is a wrap, and undone. Out and back within a moment it is an excursion of the sensor, and left out.
Any other is a seam: what follows is another record.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.log.roughness import Array, Scale, scale_of

_COUNTS = 3.5  # encoder counts that a jump exceeds
_NOISE = 10.0  # deviations of noise that a jump exceeds
_MOMENT = 50  # samples of an excursion, unless it is flat
_CLEAR = 0.65  # of a period, from which a step is a turn; and what is left of it, below which it is none
_FEW = 20  # steps without which nothing is said
_END = 5  # samples beside an end that are an excursion rather than a record


@dataclass(frozen=True)
class Jumps:
    """Places in one column: `cuts` where a new record begins, `excursions` as (first, end) of samples to leave out."""

    cuts: tuple[int, ...]
    excursions: tuple[tuple[int, int], ...]


def find_jumps(t: Array, x: Array, faster: float, scale: Scale | None = None) -> Jumps:
    """The jumps of `x` (N,) at stamps `t` (N,): steps `faster` times as fast as its fastest motion.

    `scale` is that of the whole column when `x` is a part of it.
    """
    if len(x) < 2 * _END:
        return Jumps((), ())
    scale = scale or scale_of(t, x)
    speed = np.diff(x) / np.diff(t)
    limit = faster * scale.fastest
    least = np.maximum(_COUNTS * scale.fine[1:], _NOISE * scale.noise)
    fast = (np.abs(speed) > limit) & (np.abs(np.diff(x)) > least)
    places = [int(place) + 1 for place in np.flatnonzero(fast) if not _has_company(speed, fast, int(place))]
    cuts, excursions, done = [], [], 0
    for place in places:
        if place <= done:
            continue
        first, back = _excursion(t, x, place, places, limit, float(least[place - 1]))
        if back > first:
            excursions.append((first, back))
            done = back
        else:
            cuts.append(place)
    return Jumps(tuple(cut for cut in cuts if not any(a <= cut <= b for a, b in excursions)), tuple(excursions))


def _has_company(speed: Array, fast: NDArray[np.bool_], place: int) -> bool:
    """Whether the next step is as fast in the same direction: a real motion, however short."""
    near = [other for other in (place - 1, place + 1) if 0 <= other < len(speed)]
    return any(fast[other] and speed[other] * speed[place] > 0 for other in near)


def _excursion(t: Array, x: Array, place: int, places: Sequence[int], limit: float, least: float) -> tuple[int, int]:
    """The samples (first, end) that the jump at `place` leads out to or back from; empty when it does neither."""
    if place <= _END:
        return 0, place
    if len(x) - place <= _END:
        return place, len(x)
    near = _opposite(x, place)
    flat = [other for other in places if other > place and np.ptp(x[place:other]) == 0]
    for other in sorted([*near, *flat], key=lambda other: abs(other - place)):
        first, back = min(place, other), max(place, other)
        if abs(x[back] - x[first - 1]) <= limit * (t[back] - t[first - 1]) + least:
            return first, back
    return 0, 0


def _opposite(x: Array, place: int) -> list[int]:
    """Places within a moment of the jump at `place` where the value steps back by half of it at least."""
    low = max(place - _MOMENT, 1)
    step = np.diff(x[low - 1 : place + _MOMENT + 1])
    size = x[place] - x[place - 1]
    return [int(low + other) for other in np.flatnonzero(step * np.sign(size) < -0.5 * abs(size))]


def unwrap(x: Array, periods: Sequence[float]) -> tuple[Array, float, NDArray[np.intp]]:
    """Undo the turns of an angle: continuous values, the period (0 when there was none), the places of the turns."""
    step = np.diff(x)
    largest = float(np.abs(step).max()) if len(step) > _FEW else 0.0
    for period in periods:
        if np.ptp(x) <= 1.02 * period and _CLEAR * period < largest and _is_wrapped(x, step, period):
            turns = np.rint(step / period)
            return x - period * np.concatenate([[0.0], np.cumsum(turns)]), period, np.flatnonzero(turns) + 1
    return x, 0.0, np.array([], dtype=np.intp)


def _is_wrapped(x: Array, step: Array, period: float) -> bool:
    """Whether `x`, within one period, leaves it at one end and comes in at the other, by steps like all others.

    A torque that changes its sign jumps too, but not from its largest value to its smallest, by a whole turn.
    """
    places = np.flatnonzero(np.rint(step / period))
    inner = np.abs(step - np.rint(step / period) * period)
    if len(places) == 0 or inner.max() > (1.0 - _CLEAR) * period:
        return False
    near = 2.0 * float(np.quantile(np.delete(inner, places), 0.999)) + 1e-3 * period
    high, low = np.maximum(x[places], x[places + 1]), np.minimum(x[places], x[places + 1])
    return bool((inner[places] <= near).all() and (high >= x.max() - near).all() and (low <= x.min() + near).all())
