"""`read_log`: a file to a checked Log."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Place, UsageError
from chebid.formats import Table, read_table
from chebid.log import channels
from chebid.log.average import at_instants
from chebid.log.choice import Choice, choose
from chebid.log.clock import Clock, even_clock, read_clock
from chebid.log.findings import Findings
from chebid.log.gains import apply_gain, gain_matrix
from chebid.log.record import Log, LogSpec, Record
from chebid.log.stretches import POSITION, SHORTEST, SIGNAL, TORQUE, Beside, Column, Manner, check_column

Array = NDArray[np.float64]


def read_log(
    path: str | Path,
    spec: LogSpec | None = None,
    joints: Sequence[str] | None = None,
    *,
    signals: Sequence[str] | None = None,
    need_torque: bool = False,
    name: str | None = None,
) -> Log:
    """Read the log `path` for a model with `joints`, or, without `joints`, all its signals (or those named).

    `name` is what messages call the file (default: its path as given). Torque is None when the log has none, unless
    it is needed. Raises InputError when the file cannot be used, with the place of the first reason.
    """
    path = Path(path)
    spec = spec or LogSpec()
    table = read_table(path, name=name)
    findings = Findings(table.shown, list(table.notices))
    choice = choose(table, spec, joints, signals, need_torque, findings)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # damaged files hold numbers of any size
        logged = _take(table, choice)
        clock = _clock(table, choice, spec, logged, findings)
        logged = logged.only(clock.keep)
        gains = _Gains.of(spec, None if joints is None else len(joints), logged)
        cuts = _check(logged, choice, clock, gains, findings)
        records = _records(logged, replace(clock, cuts=cuts), gains, findings)
    names = tuple(joints) if joints is not None else choice.position
    return Log(path, file_sha256(path), names, records, tuple(findings.notices))


def read_logs(
    paths: Sequence[str | Path], spec: LogSpec, joints: Sequence[str], *, need_torque: bool = True
) -> list[Log]:
    """Several logs of one robot, each a set of records of its own. Raises UsageError for one that is given twice."""
    logs: list[Log] = []
    for path in paths:
        log = read_log(path, spec, tuple(joints), need_torque=need_torque)
        twin = next((other for other in logs if other.sha256 == log.sha256), None)
        if twin is not None:
            hint = "give it once: twice the same data are no more data"
            raise UsageError(f"is the same log as {twin.path}", hint=hint, place=Place(str(path)))
        logs.append(log)
    return logs


@dataclass(frozen=True)
class _Logged:
    """Columns as logged, (N, columns) each, and the rows (N,) they stand in."""

    position: Array
    torque: Array | None
    reference: Array | None
    rows: NDArray[np.int64]

    def only(self, keep: NDArray[np.int64]) -> "_Logged":
        """Some of the samples."""
        parts = (self.position, self.torque, self.reference)
        position, torque, reference = (None if part is None else part[keep] for part in parts)
        assert position is not None
        return _Logged(position, torque, reference, self.rows[keep])

    def same(self, one: int, other: int) -> bool:
        """Whether two samples are equal in every column."""
        parts = [part for part in (self.position, self.torque, self.reference) if part is not None]
        return all(np.array_equal(part[one], part[other], equal_nan=True) for part in parts)


@dataclass(frozen=True)
class _Gains:
    """Matrices (joints, columns) from logged to SI units; `joints` is None when nothing is known of the columns.

    `average`: s over which each torque is a mean.
    """

    joints: int | None
    position: Array
    torque: Array | None
    offset: float | tuple[float, ...]
    average: float = 0.0

    @classmethod
    def of(cls, spec: LogSpec, joints: int | None, logged: _Logged) -> "_Gains":
        count = logged.position.shape[1]
        if joints is None:
            return cls(None, np.eye(count), None, 0.0)
        if np.size(spec.position_offset) not in (1, joints):
            raise InputError(
                f"holds {np.size(spec.position_offset)} numbers for {joints} joints",
                hint="give one number, or one per joint",
                place=Place(key="log: position_offset"),
            )
        torque = None
        if logged.torque is not None:
            torque = gain_matrix(spec.torque_gain, joints, logged.torque.shape[1], "torque_gain")
        position = gain_matrix(spec.position_gain, joints, count, "position_gain")
        return cls(joints, position, torque, spec.position_offset, spec.torque_average)


def _take(table: Table, choice: Choice) -> _Logged:
    """The chosen columns side by side. Raises InputError when they differ in length."""
    first = choice.time or choice.position[0]
    length = len(table.column(first))

    def beside(names: tuple[str, ...] | None) -> Array | None:
        if names is None:
            return None
        for name in names:
            if len(table.column(name)) != length:
                raise InputError(
                    f"has {len(table.column(name))} samples where '{first}' has {length}",
                    hint="name columns of one length in the model file's log: section",
                    place=Place(file=table.shown, column=name),
                )
        return np.stack([table.column(name) for name in names], axis=1)

    position = beside(choice.position)
    assert position is not None
    return _Logged(position, beside(choice.torque), beside(choice.reference), table.rows(length))


def _clock(table: Table, choice: Choice, spec: LogSpec, logged: _Logged, findings: Findings) -> Clock:
    if choice.time is None:
        assert spec.rate is not None
        return even_clock(len(logged.rows), spec.rate)
    stamps = table.column(choice.time)
    return read_clock(stamps, choice.time, choice.units[choice.time], spec.rate, logged.same, logged.rows, findings)


def _check(logged: _Logged, choice: Choice, clock: Clock, gains: _Gains, findings: Findings) -> tuple[int, ...]:
    """All checks of the columns, which are cleaned in place; returns every place where a record begins."""
    rows = logged.rows
    if len(rows) < SHORTEST:
        message = f"holds {len(rows)} samples, fewer than {SHORTEST}"
        raise findings.error(message, "record a longer log", row=rows[-1] if len(rows) else None)
    model = gains.joints is not None
    limit = channels.ABSURD_POSITION if model else channels.ABSURD_SIGNAL
    logged.position[:] = channels.check_missing(logged.position, choice.position, rows, findings)
    channels.check_magnitude(logged.position, choice.position, gains.position, limit, rows, findings)
    channels.check_motion(logged.position, choice.position, rows, findings, needed=model)
    if logged.reference is not None and choice.reference is not None:
        logged.reference[:] = channels.check_missing(logged.reference, choice.reference, rows, findings)
    exchanged = _check_torque(logged, choice, gains, findings)
    if model and not exchanged:
        units = [choice.units[name] for name in choice.position]
        channels.check_units(logged.position, choice.position, units, gains.position, rows, findings)
    return _check_in_time(logged, choice, clock, gains, findings)


def _check_torque(logged: _Logged, choice: Choice, gains: _Gains, findings: Findings) -> bool:
    """The checks of the torque columns; whether they seem to be exchanged with the positions."""
    if logged.torque is None or choice.torque is None or gains.torque is None:
        return False
    rows = logged.rows
    logged.torque[:] = channels.check_missing(logged.torque, choice.torque, rows, findings)
    channels.check_magnitude(logged.torque, choice.torque, gains.torque, channels.ABSURD_TORQUE, rows, findings)
    channels.check_motion(logged.torque, choice.torque, rows, findings, needed=False)
    channels.check_saturation(logged.torque, choice.torque, rows, findings)
    channels.check_equal(logged.position, choice.position, logged.torque, choice.torque, findings)
    return channels.check_exchanged(logged.position, choice.position, logged.torque, choice.torque, findings)


def _check_in_time(logged: _Logged, choice: Choice, clock: Clock, gains: _Gains, findings: Findings) -> tuple[int, ...]:
    """The checks along time: positions first, for their seams, then torques."""
    cuts = set(clock.cuts)

    def check(values: Array, names: tuple[str, ...], manner: Manner, gain: Array | None) -> None:
        for place, name in enumerate(names):
            column = Column(name, clock.t, values[:, place].copy(), logged.rows, findings)
            turn = [2 * np.pi, 360.0]
            if gain is not None and np.count_nonzero(gain[:, place]) == 1:
                turn.append(2 * np.pi / float(np.abs(gain[:, place]).max()))
            beside = _beside(logged, gains, place) if manner is POSITION else None
            found = check_column(column, sorted(clock.cuts), manner, turn if manner is not TORQUE else (), beside)
            values[:, place] = column.x
            cuts.update(found)

    check(logged.position, choice.position, POSITION if gains.joints is not None else SIGNAL, gains.position)
    if logged.torque is not None and choice.torque is not None:
        check(logged.torque, choice.torque, TORQUE, None)
    return tuple(sorted(cuts))


def _beside(logged: _Logged, gains: _Gains, place: int) -> Beside:
    """What stands beside a position column; its torque is known where every joint has a column of each to itself."""
    others = np.delete(logged.position, place, axis=1)
    alone = logged.torque is not None and gains.torque is not None and _diagonal(gains.position, gains.torque)
    return Beside(others, logged.torque[:, place] if alone and logged.torque is not None else None)


def _diagonal(*gains: Array) -> bool:
    return all(g.shape[0] == g.shape[1] and not (g - np.diag(np.diagonal(g))).any() for g in gains)


def _records(logged: _Logged, clock: Clock, gains: _Gains, findings: Findings) -> tuple[Record, ...]:
    """Cut at the seams, leave out what is too short, convert to SI units."""
    records = []
    for low, high in pairwise([0, *clock.cuts, len(clock.t)]):
        if high - low >= SHORTEST:
            records.append(_record(logged.only(np.arange(low, high)), clock.t[low:high], gains))
        else:
            ends = logged.rows[low], logged.rows[high - 1]
            message = f"a record of {high - low} samples, too short to use: left out"
            findings.note("short_record", message, row=ends[0], row_end=ends[1])
    if not records:
        message = f"no stretch of {SHORTEST} samples without interruption"
        raise findings.error(message, "look at the warnings about the time column; record a longer log")
    return tuple(records)


def _record(logged: _Logged, t: Array, gains: _Gains) -> Record:
    if gains.joints is None:
        return Record(t, logged.position, None, None, logged.rows)
    q = apply_gain(logged.position, gains.position, gains.offset)
    tau = None
    if logged.torque is not None and gains.torque is not None:
        tau = at_instants(t, apply_gain(logged.torque, gains.torque), gains.average)
    reference = None if logged.reference is None else apply_gain(logged.reference, gains.position, gains.offset)
    return Record(t, q, tau, reference, logged.rows)


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, read a piece at a time."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
