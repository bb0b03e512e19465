"""`read_log`: a file to a checked Log."""

import hashlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Place
from chebid.formats import Table, read_table
from chebid.log.choice import Choice, choose
from chebid.log.clock import Clock, even_clock, read_clock
from chebid.log.findings import Findings
from chebid.log.gains import apply_gain, gain_matrix
from chebid.log.record import Log, LogSpec, Record

SHORTEST = 20  # samples of a record that anything can be learnt from


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
    it is needed. Raises InputError when the file cannot be used.
    """
    path = Path(path)
    spec = spec or LogSpec()
    table = read_table(path, name=name)
    findings = Findings(table.shown, list(table.notices))
    choice = choose(table, spec, joints, signals, need_torque)
    logged = _take(table, choice)
    clock = _clock(table, choice, spec, len(logged.position), findings)
    records = _records(logged, clock, spec, joints, table, findings)
    names = tuple(joints) if joints is not None else choice.position
    return Log(path, _sha256(path), names, records, tuple(findings.notices))


@dataclass
class Logged:
    """Columns as logged, (N, columns) each."""

    position: NDArray[np.float64]
    torque: NDArray[np.float64] | None
    reference: NDArray[np.float64] | None


def _take(table: Table, choice: Choice) -> Logged:
    """The chosen columns side by side. Raises InputError when they differ in length."""
    length = len(table.column(choice.time or choice.position[0]))

    def beside(names: tuple[str, ...] | None) -> NDArray[np.float64] | None:
        if names is None:
            return None
        for name in names:
            if len(table.column(name)) != length:
                raise InputError(
                    f"has {len(table.column(name))} samples where '{choice.time or choice.position[0]}' has {length}",
                    hint="name columns of one length in the model file's log: section",
                    place=Place(file=table.shown, column=name),
                )
        return np.stack([table.column(name) for name in names], axis=1)

    position = beside(choice.position)
    assert position is not None
    return Logged(position, beside(choice.torque), beside(choice.reference))


def _clock(table: Table, choice: Choice, spec: LogSpec, count: int, findings: Findings) -> Clock:
    if choice.time is None:
        assert spec.rate is not None
        return even_clock(count, spec.rate)
    return read_clock(table.column(choice.time), choice.time, table.rows(count), findings)


def _records(
    logged: Logged, clock: Clock, spec: LogSpec, joints: Sequence[str] | None, table: Table, findings: Findings
) -> tuple[Record, ...]:
    """Cut at the seams and convert to SI units."""
    rows = table.rows(len(logged.position))
    edges = [0, *clock.cuts, len(clock.t)]
    records = []
    for low, high in itertools.pairwise(edges):
        keep = clock.keep[low:high]
        if len(keep) < SHORTEST:
            continue
        q = logged.position[keep]
        tau = None if logged.torque is None else logged.torque[keep]
        reference = None if logged.reference is None else logged.reference[keep]
        if joints is not None:
            count = len(joints)
            gain = gain_matrix(spec.position_gain, count, q.shape[1], "position_gain")
            q = apply_gain(q, gain, spec.position_offset)
            if tau is not None:
                tau = apply_gain(tau, gain_matrix(spec.torque_gain, count, tau.shape[1], "torque_gain"))
            if reference is not None:
                reference = apply_gain(reference, gain, spec.position_offset)
        records.append(Record(clock.t[low:high], q, tau, reference, rows[keep]))
    if not records:
        raise findings.error(f"no stretch of {SHORTEST} samples without interruption", "record a longer log")
    return tuple(records)


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
