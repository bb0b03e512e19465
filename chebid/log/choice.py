"""Which column of a file is what: time, position, torque, reference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Place
from chebid.formats import Table, base_name
from chebid.log.findings import Findings
from chebid.log.record import LogSpec

TIMES = (
    "t",
    "time",
    "t_s",
    "time_s",
    "timestamp",
    "timestamps",
    "stamp",
    "times",
    "seconds",
    "sec",
    "t_sec",
    "time_sec",
)


@dataclass(frozen=True)
class Choice:
    """Names of the columns, as they are in the file, and their units. `time` is None for a log on a given rate."""

    time: str | None
    position: tuple[str, ...]
    torque: tuple[str, ...] | None
    reference: tuple[str, ...] | None
    units: Mapping[str, str | None]


def choose(
    table: Table,
    spec: LogSpec,
    joints: Sequence[str] | None,
    signals: Sequence[str] | None,
    need_torque: bool,
    findings: Findings,
) -> Choice:
    """Pick the columns for a model with `joints`, or all signals without one.

    Raises InputError for columns that are missing, used twice, or of which too few are named.
    """
    time = _time(table, spec)
    if joints is None:
        names = _named(table, signals) if signals else _all(table, time, findings)
        return Choice(time, names, None, None, _units(table, time, names))
    position = _named(table, spec.position or _default(table, joints, "q", ""))
    torque = _torque(table, spec, joints, need_torque)
    reference = _named(table, spec.reference) if spec.reference else None
    _refuse_twins(table, position, torque or (), time)
    return Choice(time, position, torque, reference, _units(table, time, position))


def _units(table: Table, time: str | None, names: Sequence[str]) -> dict[str, str | None]:
    return {name: table.unit(name) for name in (*names, *([time] if time else []))}


def _time(table: Table, spec: LogSpec) -> str | None:
    """The time column, None when the log has none and its rate is given."""
    found = guess_time(table) if spec.time is None else table.find(spec.time)
    if found in table.text and spec.time is None and spec.rate is not None:
        return None
    if found is not None and found in table.text:
        cells = table.text[found]
        raise InputError(
            "the time is not a number",
            hint="write it in seconds, or give 'rate:' in Hz in place of 'time:' in the model file's log: section",
            place=Place(file=table.shown, column=found, row=cells.row, value=cells.value),
        )
    if spec.time is not None:
        return _named(table, (spec.time,))[0]
    if found is not None or spec.rate is not None:
        return found
    if table.headless:
        table.column("t")  # raises, with the way out for a file without a header
    raise InputError(
        "no time column",
        hint=f"name it in the model file's log: section as 'time:'{_clock_like(table)}, or give 'rate:' in Hz there",
        place=Place(file=table.shown),
    )


def guess_time(table: Table) -> str | None:
    """The column that is called as time is called, None without one."""
    known = {_plain(name): name for name in reversed(table.names)}
    return next((known[name] for name in TIMES if name in known), None)


def _plain(name: str) -> str:
    return base_name(name).lower()


def _clock_like(table: Table) -> str:
    """A guess for the hint: the columns that only ever grow."""
    growing = [name for name in table.names if name not in table.text and _grows(table.column(name))]
    return f" ({', '.join(growing[:3])} only ever grows)" if growing else ""


def _grows(values: NDArray[np.float64]) -> bool:
    return len(values) > 2 and bool((values[1:] > values[:-1]).all())  # no difference: infinities have none


def _all(table: Table, time: str | None, findings: Findings) -> tuple[str, ...]:
    """Every numeric column as long as the time column (or as the longest one) but the time."""
    columns = {name: table.column(name) for name in table.names if name not in table.text}
    length = len(columns[time]) if time in columns else max((len(column) for column in columns.values()), default=0)
    names = []
    for name, column in columns.items():
        if len(column) != length or name == time or (name in table.nameless and not table.headless):
            continue
        if np.isfinite(column).mean() < 0.5:
            findings.note("left_out", "more than half of this column is missing: left out", column=name)
        else:
            names.append(name)
    if not names:
        place = Place(file=table.shown)
        raise InputError("no numeric column besides the time", hint="export the signals too", place=place)
    return tuple(names)


def _named(table: Table, names: Sequence[str]) -> tuple[str, ...]:
    """The columns by their names in the file. Raises InputError for the first that is missing or holds text."""
    found = []
    for name in names:
        table.column(name)
        found.append(table.find(name) or name)
    return tuple(found)


def _default(table: Table, joints: Sequence[str], letter: str, prefix: str) -> tuple[str, ...]:
    """`q1..qN` when they are there, else the names of the joints."""
    numbered = tuple(f"{letter}{place}" for place in range(1, len(joints) + 1))
    named = tuple(prefix + joint for joint in joints)
    return named if all(table.find(name) for name in named) else numbered


def _torque(table: Table, spec: LogSpec, joints: Sequence[str], need: bool) -> tuple[str, ...] | None:
    names = spec.torque or _default(table, joints, "tau", "tau_")
    if not need and any(table.find(name) is None for name in names):
        return None
    return _named(table, names)


def _refuse_twins(table: Table, position: tuple[str, ...], torque: tuple[str, ...], time: str | None) -> None:
    used: dict[str, str] = {} if time is None else {time: "time"}
    for role, names in (("position", position), ("torque", torque)):
        for name in names:
            if name in used:
                raise InputError(
                    f"is named both as {used[name]} and as {role}",
                    hint="name each column once in the model file's log: section",
                    place=Place(file=table.shown, column=name),
                )
            used[name] = role
