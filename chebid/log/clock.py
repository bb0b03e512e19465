"""The clock of a log: which samples have a usable stamp, and where the recording was interrupted."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError
from chebid.formats import base_name
from chebid.log.findings import Findings, several
from chebid.log.record import stamp_resolution

Array = NDArray[np.float64]
Places = NDArray[np.int64]
Same = Callable[[int, int], bool]

_UNITS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
_GAP = 5.0  # median steps that a gap is longer than
_OFTEN = 0.01  # share of long steps from which they are usual for the log, and no gaps
_BACK = 0.02  # share of steps back from which the column is no clock
_BLOCKS = 0.2  # share of repeated stamps from which the clock is coarser than the sampling
_FEW = 1e-3  # share of repeated stamps up to which each is a seam
_SAME_RATE = 0.02
_RARELY = 0.02  # share of longer steps that are lost samples rather than the rounding of the stamps
_EVEN = 0.01  # spread of the steps, in steps, that is not worth a word


@dataclass(frozen=True)
class Clock:
    """Stamps `t` (n,) of the samples `keep` (n,) of the file, and the places in `t` where a new record begins."""

    t: Array
    keep: Places
    cuts: tuple[int, ...] = ()


@dataclass(frozen=True)
class _Column:
    """The time column under examination, with what its messages need."""

    name: str
    rows: Places
    findings: Findings

    def note(self, kind: str, message: str, place: int, value: object) -> None:
        self.findings.note(kind, message, column=self.name, row=self.rows[place], value=value)

    def error(self, message: str, hint: str, place: int, value: object = None) -> InputError:
        return self.findings.error(message, hint, column=self.name, row=self.rows[place], value=value)


def even_clock(count: int, rate: float) -> Clock:
    """The clock of a log without a time column: sample k at k / rate."""
    return Clock(np.arange(count) / rate, np.arange(count))


def read_clock(
    stamps: Array, name: str, unit: str | None, rate: float | None, same: Same, rows: Places, findings: Findings
) -> Clock:
    """Check the stamps (N,) of the column `name` against each other and against the `rate` (Hz) that was given.

    `unit` is the one that the file gives, s when it gives none.
    `same` tells whether two samples are equal in all other columns, so that one of them was written twice.
    Raises InputError when the column is no clock, is in another unit, or contradicts `rate`.
    """
    column = _Column(name, rows, findings)
    keep = _present(stamps, column)
    t = stamps[keep] * _written_unit(unit, column, keep)
    _refuse_disorder(t, keep, column)
    t = t * _guessed_unit(t, rate, keep, column)
    keep, t = _without_outliers(t, keep, column)
    if np.mean(np.diff(t) == 0) > _BLOCKS:
        return _coarse(t, keep, rate, column)
    clock = _seams(*_without_repeats(t, keep, same, column), column)
    _check_rate(clock, rate, column)
    return _judge_steps(clock, rate, column)


def _present(stamps: Array, column: _Column) -> Places:
    """The samples that have a stamp at all."""
    good = np.isfinite(stamps)
    lost = np.flatnonzero(~good)
    if len(lost) > len(stamps) / 2:
        raise column.error(f"{len(lost)} of {len(stamps)} stamps are missing", "name another time column", lost[0])
    if len(lost):
        rows = several(list(column.rows[lost]))
        column.note("missing_time", f"no stamp in {rows}: left out", lost[0], stamps[lost[0]])
    return np.flatnonzero(good)


def _written_unit(unit: str | None, column: _Column, keep: Places) -> float:
    """Seconds per unit of the stamps, when the file tells it: by `unit`, or as in `stamp_ns`."""
    ending = re.search(r"_(ms|us|ns)$", base_name(column.name).lower())
    unit = unit or (ending[1] if ending else "s")
    factor = _UNITS.get(unit.lower(), 1.0)
    if factor != 1.0:
        column.note("time_unit", f"the file says {unit}: taken as such", int(keep[0]), None)
    return factor


def _guessed_unit(t: Array, rate: float | None, keep: Places, column: _Column) -> float:
    """1, or the unit in which the stamps fit the given rate. Raises InputError for stamps that cannot be seconds."""
    forward = np.diff(t)
    forward = forward[forward > 0]
    if len(forward) == 0:
        raise column.error("the time never advances", "name the column that holds the time", int(keep[0]), t[0])
    usual = float(np.median(forward))
    if usual < 1.0 and usual > 1e-6:
        return 1.0
    for unit in ("s", "ms", "us", "ns"):
        if rate is not None and abs(usual * _UNITS[unit] * rate - 1.0) < _SAME_RATE:
            if unit != "s":
                column.note("time_unit", f"at {rate:g} Hz the stamps are in {unit}: taken as such", int(keep[0]), None)
            return _UNITS[unit]
    if usual <= 1e-6:
        message, hint = f"the usual step is {usual:.3g} s", "convert the column to seconds; are they days or hours?"
    else:
        unit = "ms" if usual < 500 else "us" if usual < 5e5 else "ns"
        message = f"the usual step is {usual:g}, too long for seconds: {unit}?"
        hint = (
            f"convert it to seconds, or give 'rate: {1 / (usual * _UNITS[unit]):.6g}' in the model file's log: section"
        )
    raise column.error(message, hint, int(keep[1]), t[1])


def _refuse_disorder(t: Array, keep: Places, column: _Column) -> None:
    back = np.flatnonzero(np.diff(t) < 0) + 1
    if len(back) > max(3, _BACK * len(t)):
        message = (
            f"goes back in {len(back)} of {len(t)} rows, first by {t[back[0] - 1] - t[back[0]]:.6g}: it is no clock"
        )
        raise column.error(
            message, "name the column that holds the time, or sort the rows", int(keep[back[0]]), t[back[0]]
        )


def _without_outliers(t: Array, keep: Places, column: _Column) -> tuple[Places, Array]:
    """Leave out single stamps that are not between their neighbours, which are a step or two apart."""
    step = np.diff(t)
    usual = float(np.median(step[step > 0]))
    across = t[2:] - t[:-2]
    outside = (t[1:-1] < t[:-2]) | (t[1:-1] > t[2:])
    bad = np.flatnonzero(outside & (across > 0) & (across <= 3.0 * usual)) + 1
    bad = bad[np.diff(bad, prepend=-2) > 1]
    if len(bad):
        rows = several(list(column.rows[keep[bad]]))
        column.note("time_outlier", f"stamp out of line in {rows}: left out", int(keep[bad[0]]), t[bad[0]])
    return np.delete(keep, bad), np.delete(t, bad)


def _coarse(t: Array, keep: Places, rate: float | None, column: _Column) -> Clock:
    """A clock that stands still for several samples: only a given rate can tell the samples apart."""
    repeat = int(np.flatnonzero(np.diff(t) == 0)[0]) + 1
    block = len(t) / (np.count_nonzero(np.diff(t)) + 1)
    step = np.diff(t)
    tick = float(np.median(step[step > 0]))
    mean = 1.0 / float(np.mean(step[(step >= 0) & (step <= _GAP * tick)]))
    message = f"stamps repeat in blocks of {block:.3g}: the clock ({tick:g} s) is coarser than the sampling"
    if rate is None:
        hint = f"give 'rate: {mean:.4g}' (Hz) in the model file's log: section"
        raise column.error(message, hint, int(keep[repeat]), t[repeat])
    if abs(mean / rate - 1.0) > _SAME_RATE:
        raise _contradiction(mean, rate, int(keep[0]), column)
    column.note("time_rounded", f"{message}; the given {rate:g} Hz are used", int(keep[repeat]), t[repeat])
    cuts = np.flatnonzero((step < 0) | (step > _GAP * tick)) + 1
    _tell_cuts(t, cuts, keep, column)
    clock = Clock(t, keep, tuple(int(cut) for cut in cuts))
    return _evened(clock, rate)


def _without_repeats(t: Array, keep: Places, same: Same, column: _Column) -> tuple[Array, Places]:
    """Leave out rows written twice and stamps that stood still for one step; other repeats stay, as seams."""
    repeats = np.flatnonzero(np.diff(t) == 0) + 1
    if len(repeats) == 0:
        return t, keep
    usual = float(np.median(np.diff(t)))
    twice = np.array([same(int(keep[place]), int(keep[place - 1])) for place in repeats])
    following = np.append(t, np.inf)[repeats + 1] - t[repeats]
    stuck = ~twice & ((np.abs(following / usual - 2.0) < 0.5) | (len(repeats) > max(3, _FEW * len(t))))
    for kind, chosen, message in (
        ("repeated_row", repeats[twice], "the row before is written again in {}: left out"),
        ("repeated_time", repeats[stuck], "the stamp of the row before is repeated in {}: left out"),
    ):
        if len(chosen):
            rows = several(list(column.rows[keep[chosen]]))
            column.note(kind, message.format(rows), int(keep[chosen[0]]), t[chosen[0]])
    out = repeats[twice | stuck]
    return np.delete(t, out), np.delete(keep, out)


def _seams(t: Array, keep: Places, column: _Column) -> Clock:
    """Cut where the time goes back, stands still, or leaps."""
    step = np.diff(t)
    usual = float(np.median(step))
    longest = _GAP * usual
    if np.mean(step > longest) > _OFTEN:
        longest = max(longest, 3.0 * float(np.quantile(step, 0.99)))
    cuts = np.flatnonzero((step <= 0) | (step > longest)) + 1
    _tell_cuts(t, cuts, keep, column)
    return Clock(t, keep, tuple(int(cut) for cut in cuts))


def _tell_cuts(t: Array, cuts: Places, keep: Places, column: _Column) -> None:
    for cut in cuts[:20]:
        step = t[cut] - t[cut - 1]
        if step > 0:
            kind, what = "gap", f"gap of {step:.6g} s"
        elif step < 0:
            kind, what = "time_back", f"the time goes back by {-step:.6g} s"
        else:
            kind, what = "repeated_time", "the stamp is repeated with other values"
        column.note(kind, f"{what}: a new record begins", int(keep[cut]), t[cut])
    if len(cuts) > 20:
        column.note("seams", f"{len(cuts) - 20} more interruptions", int(keep[cuts[20]]), t[cuts[20]])


def _steps(clock: Clock) -> tuple[Array, Places]:
    """The steps within records, and the places they lead to, but for those over samples that were left out."""
    inside = np.diff(clock.keep, prepend=-1) == 1
    inside[[0, *clock.cuts]] = False
    places = np.flatnonzero(inside)
    return clock.t[places] - clock.t[places - 1], places


def _check_rate(clock: Clock, rate: float | None, column: _Column) -> None:
    """Raise InputError when the stamps and the given rate contradict each other."""
    step, _ = _steps(clock)
    if rate is None or len(step) == 0:
        return
    found = (1.0 / float(np.median(step)), 1.0 / float(np.mean(step)))
    if all(abs(one / rate - 1.0) > _SAME_RATE for one in found):
        raise _contradiction(found[0], rate, int(clock.keep[0]), column)


def _contradiction(found: float, rate: float, place: int, column: _Column) -> InputError:
    message = f"the stamps come at {found:.6g} Hz, the model file's log: section says rate: {rate:g}"
    return column.error(message, "correct or remove 'rate' in the log: section", place)


def _judge_steps(clock: Clock, rate: float | None, column: _Column) -> Clock:
    """Say so when the steps differ; use a given rate in place of stamps that are rounded."""
    step, places = _steps(clock)
    if len(step) == 0 or np.ptp(step) <= _EVEN * np.median(step):
        return clock
    lost = np.rint(step / np.median(step)).astype(np.int64) - 1 if _are_multiples(step) else np.zeros(len(step), int)
    if 0 < np.count_nonzero(lost) <= _RARELY * len(step):
        _tell_lost(clock, lost, places, column)
    elif np.ptp(step) <= 1.01 * stamp_resolution(clock.t):
        _tell_rounded(clock, step, rate, int(places[0]), column)
        return _evened(clock, rate) if rate else clock
    elif lost.any():
        _tell_lost(clock, lost, places, column)
    else:
        longest = int(places[np.argmax(step)])
        span = f"{step.min():.4g} to {step.max():.4g} s, usually {np.median(step):.4g} s"
        message = f"steps are uneven, {span}: the stamps are used as they are"
        column.note("uneven", message, int(clock.keep[longest]), clock.t[longest])
    return clock


def _are_multiples(step: Array) -> bool:
    """Whether all steps are the usual one or whole multiples of it."""
    ratio = step / np.median(step)
    return bool((ratio > 0.5).all() and (np.abs(ratio - np.rint(ratio)) <= _EVEN * ratio).all())


def _tell_lost(clock: Clock, lost: Places, places: Places, column: _Column) -> None:
    after = clock.keep[places[lost > 0]]
    rows = several([int(row) for row in column.rows[after]])
    message = f"{int(lost.sum())} samples were lost, before {rows}: the stamps are used as they are"
    column.note("lost_samples", message, int(after[0]), clock.t[places[lost > 0][0]])


def _tell_rounded(clock: Clock, step: Array, rate: float | None, place: int, column: _Column) -> None:
    used = f"the given {rate:g} Hz are used" if rate else "give 'rate' in the log: section if the sampling is even"
    what = f"stamps are rounded to {stamp_resolution(clock.t):g} s, steps are {step.min():.6g} or {step.max():.6g} s"
    column.note("time_rounded", f"{what}: {used}", int(clock.keep[place]), None)


def _evened(clock: Clock, rate: float) -> Clock:
    """The same records with even steps of 1 / rate from the first stamp of each."""
    t = clock.t.copy()
    for low, high in pairwise([0, *clock.cuts, len(t)]):
        t[low:high] = t[low] + np.arange(high - low) / rate
    return Clock(t, clock.keep, clock.cuts)
