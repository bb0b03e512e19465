"""The checks that need continuous time: wraps, seams, held samples and spikes, stretch by stretch.

Each check looks at one column between two interruptions, without the samples that are missing, and its findings are
told once per column.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from chebid.log.findings import Findings, several
from chebid.log.held import Held, find_held, stale_before
from chebid.log.roughness import Scale, scale_of
from chebid.log.seams import find_jumps, unwrap
from chebid.log.spikes import find_spikes
from chebid.log.stuck import find_stuck

Array = NDArray[np.float64]
SHORTEST = 20  # samples of a stretch that can be judged


@dataclass(frozen=True)
class Manner:
    """How strictly a column is judged: deviations of a spike, least share of the range of one, speed of a jump."""

    spike: float
    share: float
    jump: float


POSITION = Manner(spike=5.7, share=0.0, jump=3.0)  # measured on clean logs: spikes reach 5.2, jumps 1.0
TORQUE = Manner(spike=20.0, share=0.1, jump=math.inf)  # friction and controllers make real spikes (17) and steps
SIGNAL = Manner(spike=20.0, share=0.0, jump=15.0)  # unknown: may be a torque, whose steps reach 4.8


@dataclass
class Column:
    """One logged column on the clock of its log: `x` (n,), changed in place, NaN for what is left out."""

    name: str
    t: Array
    x: Array
    rows: NDArray[np.int64]
    findings: Findings

    def note(self, kind: str, message: str, place: int, end: int | None = None, value: object = None) -> None:
        """A notice at the sample `place`, or at the samples from `place` to before `end`."""
        row_end = None if end is None else self.rows[end - 1]
        value = self.x[place] if value is None else value
        self.findings.note(kind, message, column=self.name, row=self.rows[place], row_end=row_end, value=value)

    def scale(self, cuts: Sequence[int]) -> Scale:
        """What is usual in this column between `cuts`; the values at missing samples mean nothing."""
        places = np.flatnonzero(np.isfinite(self.x))
        known = scale_of(self.t[places], self.x[places], sorted(set(np.searchsorted(places, cuts).tolist())))
        fine = np.zeros_like(self.x)
        fine[places] = known.fine
        return replace(known, fine=fine)


@dataclass(frozen=True)
class Beside:
    """What was logged beside a position: the other positions (n, K), and the joint's torque (n,) if it is known."""

    others: Array
    torque: Array | None


def check_column(
    column: Column, cuts: Sequence[int], manner: Manner, periods: Sequence[float] = (), beside: Beside | None = None
) -> list[int]:
    """Clean one column between `cuts`; the places of further cuts are returned."""
    stretches = list(pairwise([0, *cuts, len(column.x)]))
    if np.count_nonzero(np.isfinite(column.x)) < SHORTEST:
        return []
    _undo_turns(column, stretches, periods)
    scale = column.scale(cuts)
    if beside is not None:
        _leave_out_stuck(column, stretches, scale, beside)
    if manner is POSITION:
        _leave_out_held(column, stretches, scale)
    _leave_out_spikes(column, stretches, manner, scale)
    return _cut_jumps(column, stretches, manner, scale) if math.isfinite(manner.jump) else []


def _present(column: Column, low: int, high: int) -> NDArray[np.intp]:
    """Places between `low` and `high` that hold a value."""
    return low + np.flatnonzero(np.isfinite(column.x[low:high]))


def _undo_turns(column: Column, stretches: Sequence[tuple[int, int]], periods: Sequence[float]) -> None:
    for low, high in stretches:
        places = _present(column, low, high)
        if len(places) < SHORTEST or not periods:
            continue
        values, period, turns = unwrap(column.x[places], periods)
        if len(turns):
            rows = several([int(row) for row in column.rows[places[turns]]])
            message = f"jumps by a whole turn ({period:.6g}) in {rows} and moves on: unwrapped to a continuous angle"
            column.note("wrapped", message, int(places[turns[0]]))
            column.x[places] = values


def _leave_out_stuck(column: Column, stretches: Sequence[tuple[int, int]], scale: Scale, beside: Beside) -> None:
    for low, high in stretches:
        places = _present(column, low, high)
        if len(places) < SHORTEST:
            continue
        torque = None if beside.torque is None else beside.torque[places]
        found = find_stuck(column.t[places], column.x[places], scale.at(places), beside.others[places], torque)
        for stuck in list(found):
            _leave_out_frozen(column, places[stuck.first : stuck.end], stuck.reason)


def _leave_out_held(column: Column, stretches: Sequence[tuple[int, int]], scale: Scale) -> None:
    notable: tuple[int, Held] | None = None
    for low, high in stretches:
        places = _present(column, low, high)
        if len(places) < SHORTEST:
            continue
        held = find_held(column.t[places], column.x[places], scale.at(places))
        if held.notable and notable is None:
            notable = (int(places[held.example]), held)
        for first, end in held.frozen:
            _leave_out_frozen(column, places[first:end])
    if notable is not None:
        _tell_held(column, *notable)


def _leave_out_frozen(column: Column, places: NDArray[np.intp], reason: str = "") -> None:
    if len(places):
        because = f" ({reason})" if reason else ""
        message = f"stands still for {len(places)} samples while the joint moves on{because}: left out"
        column.note("frozen", message, int(places[0]), int(places[-1]) + 1)
        column.x[places] = np.nan


def _tell_seam(column: Column, before: int, after: int) -> None:
    size, time = column.x[after] - column.x[before], column.t[after] - column.t[before]
    message = f"jumps by {size:.6g} in {time:.4g} s, which no velocity explains: a new record begins"
    column.note("seam", message, after)


def _tell_held(column: Column, place: int, held: Held) -> None:
    rate = 1.0 / float(np.median(np.diff(column.t)))
    effective = f"the sensor gives about {(1.0 - held.share) * rate:.3g} values per second, the log {rate:.4g}"
    message = f"{100 * held.share:.0f} % of the samples repeat the one before while the joint moves: {effective}"
    column.note("held", message, place)


def _cut_jumps(column: Column, stretches: Sequence[tuple[int, int]], manner: Manner, scale: Scale) -> list[int]:
    seams: list[int] = []
    for low, high in stretches:
        places = _present(column, low, high)
        if len(places) < SHORTEST:
            continue
        jumps = find_jumps(column.t[places], column.x[places], manner.jump, scale.at(places))
        for cut in jumps.cuts:
            _tell_seam(column, int(places[cut - 1]), int(places[cut]))
            seams.append(int(places[cut]))
            _leave_out_frozen(column, places[stale_before(column.x[places], cut, scale.longest) : cut])
        for first, end in jumps.excursions:
            message = f"{end - first} samples away from the curve, and back: left out"
            column.note("spike", message, int(places[first]), int(places[end - 1]) + 1)
            column.x[places[first:end]] = np.nan
    return seams


def _leave_out_spikes(column: Column, stretches: Sequence[tuple[int, int]], manner: Manner, scale: Scale) -> None:
    least = manner.share * float(np.nanmax(column.x) - np.nanmin(column.x)) if np.isfinite(column.x).any() else 0.0
    found: list[int] = []
    for low, high in stretches:
        places = _present(column, low, high)
        if len(places) >= SHORTEST:
            spikes = find_spikes(column.t[places], column.x[places], manner.spike, least, scale.at(places))
            found += places[spikes].tolist()
    if found:
        rows = several([int(row) for row in column.rows[found]])
        count = f"{len(found)} samples lie" if len(found) > 1 else "lies"
        message = f"{count} off the smooth curve of the neighbours ({rows}): left out"
        column.note("spike", message, found[0])
        column.x[found] = np.nan
