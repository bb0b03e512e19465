"""Encoders that hung: a value that stands for long while other channels, or the motion around it, say it cannot.

A robot at rest repeats its positions for as long as it likes, comes to rest and leaves it by accelerations that it
shows elsewhere, and its torque rests too. A sensor that hangs

- stops at a pace that no acceleration of the log explains, or catches up by a step that the motion does not go on at;
- catches up by a leap while the other joints move on without a break (a seam breaks them all); or
- stands while its own torque goes up and down as it does in motion.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.log.roughness import Array, Scale

_LONG = 20  # repeats from which a stretch is judged here
_KINK = 6.0  # times the change of pace that one sample in a hundred exceeds
_COUNTS = 3.5  # of the encoder, beyond which a change of pace means something
_ON = 2.0  # times the pace at which the motion goes on, beyond which a step catches up
_LEAP = 3.0  # times the fastest motion: what is left to the search for seams
_TORQUE_LONG = 50  # repeats from which the torque has its say
_TORQUE = 0.5  # of its range in motion
_RETURNS = 1.3  # times its range: what it travels when it does not only rise or fall
_MOVES = 0.05  # of the fastest motion
_BLOCKS = 20


@dataclass(frozen=True)
class Stuck:
    """Samples `first` to before `end` that repeat the one before, and what speaks against it."""

    first: int
    end: int
    reason: str


def find_stuck(t: Array, x: Array, scale: Scale, others: Array, torque: Array | None) -> Iterator[Stuck]:
    """Stretches of x (N,) at t (N,) s in which its encoder hung; `others` (N, K) are the other positions.

    `torque` (N,) is that of the joint, None when it is not known. Both may hold NaN.
    """
    first = np.flatnonzero(np.concatenate([[True], np.diff(x) != 0]))
    end = np.append(first[1:], len(x))  # x[first] to x[end - 1] are equal
    long = end - first > _LONG
    first, end = first[long], end[long]
    if len(first) == 0 or scale.fastest == 0:
        return
    pace = np.diff(x) / np.diff(t)
    usual = _KINK * float(np.quantile(np.abs(np.diff(pace)), 0.99))
    active = _Torque.of(torque, np.abs(pace) > _MOVES * scale.fastest) if torque is not None else None
    for a, b in zip(first.tolist(), end.tolist(), strict=True):
        before, after = _beside(pace, a, b)
        limit = usual + _COUNTS * float(scale.fine[a]) / float(np.median(np.diff(t[a:b])))
        leap = _LEAP * scale.fastest
        reason = "its torque goes up and down as in motion" if active is not None and active.moves(a, b) else ""
        if before > leap:
            continue  # an excursion
        if after > leap:
            go_on, moving = _unbroken(t, others, b)
            if go_on and moving:
                reason = "catches up by a leap, the other joints moving without a break"
            elif go_on and before > limit:
                reason = "stops at full pace, catches up by a leap"
        elif max(before, after) > limit:
            reason = "stops at full pace" if before > limit else "catches up by a step"
        if reason:
            yield Stuck(a + 1, b, reason)


def _beside(pace: Array, first: int, end: int) -> tuple[float, float]:
    """Pace of the step into the stretch and of a step out of it that catches up; 0 where there is none."""
    before = abs(float(pace[first - 1])) if first > 0 else 0.0
    after, goes_on = abs(float(pace[end - 1 : end].sum())), np.abs(pace[end : end + 3])
    return before, after if len(goes_on) and after > _ON * float(goes_on.max()) else 0.0


def _unbroken(t: Array, others: Array, place: int) -> tuple[bool, bool]:
    """Whether there are other joints and none leaps at `place`, and whether one moves there."""
    near = slice(max(place - 4, 0), place + 4)
    pace = np.abs(np.diff(others[near], axis=0)) / np.diff(t[near])[:, None]
    here, usual = pace[place - 1 - near.start], np.median(pace, axis=0)
    return others.shape[1] > 0 and bool((here <= 3 * usual + 1e-12).all()), bool((usual > 0).any())


@dataclass(frozen=True)
class _Torque:
    """A joint's torque (N,) and how far it ranges while the joint moves."""

    values: Array
    range: float

    @classmethod
    def of(cls, values: Array, moving: NDArray[np.bool_]) -> "_Torque":
        some = values[1:][moving & np.isfinite(values[1:])]
        return cls(values, float(np.ptp(np.quantile(some, [0.05, 0.95]))) if len(some) else np.inf)

    def moves(self, first: int, end: int) -> bool:
        """Whether it goes up and down between these samples as it does in motion; noise is averaged out."""
        part = self.values[first:end]
        if len(part) < _TORQUE_LONG:
            return False
        means = np.array([block.mean() for block in np.array_split(part, _BLOCKS)])[2:-2]
        spread = float(np.ptp(means))
        return spread > _TORQUE * self.range and float(np.abs(np.diff(means)).sum()) > _RETURNS * spread
