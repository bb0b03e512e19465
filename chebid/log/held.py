"""Held samples: a sensor slower than the logger, and stretches in which it stood still while the joint moved on.

A value that repeats is held, rather than at rest, when the joint moves on both sides of it, the same way, and the next
step makes up for the ones that are missing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.log.roughness import Array, Scale, roughness, scale_of, usual_noise

_REACH = 8  # samples on either side over which the joint's pace is taken; more for longer stretches
_LEAST = 4  # samples on either side without which nothing is said
_COUNTS = 3.0  # counts per sample from which a joint must change from sample to sample
_PACE = 0.02  # of the log's fastest motion, below which nothing is said
_MADE_UP = 0.6  # share of the missing steps that the next one makes up for
_SHORTEST = 3  # repeats of a frozen stretch
_SLOW = 0.2  # share of repeats from which the sensor is called slower than the logger
_SOME = 0.05  # share of repeats worth a word
_STEPS = 6  # different steps after repeats that a slow sensor makes; a coarse count makes one or two
_BESIDE = 0.3  # share of repeats beside a frozen stretch, above which the values merely count in large steps
_MANY = 100_000  # samples from which noise is told
_ENOUGH = 50  # moving samples from which a share means something


@dataclass(frozen=True)
class Held:
    """Repeats of a moving joint.

    `share` of its samples that repeat the one before, `example` the first of these; `frozen` as (first, end) of the
    samples to leave out.
    """

    share: float = 0.0
    example: int = 0
    frozen: tuple[tuple[int, int], ...] = ()

    @property
    def slow(self) -> bool:
        """Whether the sensor is slower than the logger."""
        return self.share >= _SLOW

    @property
    def notable(self) -> bool:
        """Whether the repeats are worth a word."""
        return self.share >= _SOME


def find_held(t: Array, x: Array, scale: Scale | None = None) -> Held:
    """Repeats in `x` (N,) at stamps `t` (N,) where the joint moves too fast for them.

    `scale` is that of the whole column when `x` is a part of it.
    """
    if len(x) < 4 * _REACH:
        return Held()
    first, end = _runs(np.diff(x) == 0)
    if len(first) == 0:
        return Held()
    least = _least_pace(t, x, scale or scale_of(t, x))
    held = _is_held(x, first, end, least)
    first, end = first[held], end[held]
    if len(first) == 0:
        return Held()
    share = _share(x, first, end, least)
    if share >= _SLOW:
        frozen = end - first > 4 * np.median(end - first) + _SHORTEST
    else:
        frozen = (end - first >= _SHORTEST) & (_repeats_beside(x, first, end) <= _BESIDE)
    spans = zip((first + 1)[frozen].tolist(), (end + 1)[frozen].tolist(), strict=True)
    return Held(share, int(first[0]) + 1, tuple(spans))


def _share(x: Array, first: NDArray[np.intp], end: NDArray[np.intp], least: Array) -> float:
    """Share of repeats among the samples of a moving joint; 0 where the values merely count in large steps."""
    steps = np.abs(x[end + 1] - x[end])
    if len(np.unique(np.rint(steps / (1e-9 * np.ptp(x))))) < _STEPS:
        return 0.0
    moving = int((np.abs(x[_REACH:] - x[:-_REACH]) / _REACH > least[_REACH:]).sum())
    return float((end - first).sum() / max(moving, _ENOUGH))


def _repeats_beside(x: Array, first: NDArray[np.intp], end: NDArray[np.intp]) -> Array:
    """Share of repeats among the steps just before and just after each stretch."""
    same = np.concatenate([[0], np.cumsum(np.diff(x) == 0)])
    low, high = np.maximum(first - _REACH, 0), np.minimum(end + 1 + _REACH, len(same) - 1)
    count = same[first] - same[low] + same[high] - same[end + 1]
    return np.asarray(count / (first - low + high - end - 1))


def stale_before(x: Array, cut: int, longest: float) -> int:
    """The first of the repeats just before the jump at `cut` when the joint stopped dead for them; else `cut`.

    A joint that comes to rest slows down; a sensor that stands still stops at full pace. `longest` is that of its
    column's `Scale`.
    """
    first = cut - 1
    while first > 0 and x[first - 1] == x[cut - 1]:
        first -= 1
    if cut - 1 - first < _SHORTEST or first < _REACH:
        return cut
    pace = abs(x[first] - x[first - _REACH]) / _REACH
    last = abs(x[first] - x[first - 2]) / 2
    return first + 1 if last > 0.7 * pace > 5 * _PACE * longest else cut


def _least_pace(t: Array, x: Array, scale: Scale) -> Array:
    """Change per sample (N,) from which a moving joint cannot repeat a value."""
    new = np.flatnonzero(np.diff(x, prepend=np.inf) != 0)[:_MANY]  # repeats would pass for noise
    noise = usual_noise(roughness(t[new], x[new])) if len(new) > 4 else 0.0
    return np.maximum(_COUNTS * np.maximum(scale.fine, noise), _PACE * scale.longest)


def _runs(same: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Stretches of steps in which `same` holds: their firsts and their ends."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2]


def _is_held(x: Array, first: NDArray[np.intp], end: NDArray[np.intp], least: Array) -> NDArray[np.bool_]:
    """Which stretches of repeats the joint moved on in: x[first] to x[end] are equal, the next step makes up.

    The pace is taken over a fixed reach, and over three such stretches for a sensor that is slower still.
    """
    held = np.zeros(len(first), dtype=bool)
    inside = (first >= _LEAST) & (end + 1 + _LEAST < len(x))
    first, end = first[inside], end[inside]
    near = np.full(len(first), _REACH)
    far = np.maximum(_REACH, 3 * (end - first + 1))
    held[inside] = _moved_on(x, first, end, near, least[first]) | _moved_on(x, first, end, far, least[first])
    return held


def _moved_on(
    x: Array, first: NDArray[np.intp], end: NDArray[np.intp], reach: NDArray[np.intp], least: Array
) -> NDArray[np.bool_]:
    """Whether the pace before and after, over `reach` samples, and the next step all go the same way, far enough."""
    back, ahead = np.minimum(reach, first), np.minimum(reach, len(x) - 2 - end)
    before = (x[first] - x[first - back]) / back
    after = (x[end + 1 + ahead] - x[end + 1]) / ahead
    made_up = x[end + 1] - x[end]
    pace = np.minimum(np.abs(before), np.abs(after))
    same_way = (np.sign(before) == np.sign(made_up)) & (np.sign(after) == np.sign(made_up))
    return np.asarray(same_way & (pace > least) & (np.abs(made_up) >= _MADE_UP * (end - first + 1) * pace))
