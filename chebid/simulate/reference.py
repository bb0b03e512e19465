"""The motion that the controller is asked to follow: positions and velocities at any instant."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from chebid.errors import InputError, Place
from chebid.formats import Table, read_table
from chebid.log import Log, Record, read_log
from chebid.log.choice import guess_time
from chebid.log.clock import even_clock
from chebid.model import Model
from chebid.motion import project_record
from chebid.projection import Setting
from chebid.robots import Array


@dataclass(frozen=True)
class Reference:
    """A reference motion sampled at t (N,) s, from 0; q, dq (N, J) and, when known, ddq (N, J): rad or m, and s.

    In between: the polynomial that has these values at both ends, of degree 3, or 5 with ddq.
    """

    t: Array
    q: Array
    dq: Array
    ddq: Array | None = None

    @property
    def duration(self) -> float:
        """s."""
        return float(self.t[-1])

    @property
    def rate(self) -> float:
        """Hz."""
        return (len(self.t) - 1) / self.duration

    def at(self, t: Array) -> Array:
        """Positions and velocities (2, K, J) at instants t (K,) s within the motion."""
        curve = CubicHermiteSpline(self.t, self.q, self.dq) if self.ddq is None else self._quintic(self.ddq)
        inside = np.clip(t, self.t[0], self.t[-1])
        return np.stack([curve(inside), curve.derivative()(inside)])

    def _quintic(self, ddq: Array) -> PPoly:
        """Degree 5 between samples, from position, velocity and acceleration at both ends; all intervals at once."""
        h = np.diff(self.t)[:, None]
        # what is left at the end of an interval of a motion with the acceleration of its start
        a = np.diff(ddq, axis=0)
        v = np.diff(self.dq, axis=0) - h * ddq[:-1]
        q = np.diff(self.q, axis=0) - h * self.dq[:-1] - h**2 / 2 * ddq[:-1]
        cubic = (10 * q / h**2 - 4 * v / h + a / 2) / h
        quartic = (-15 * q / h**2 + 7 * v / h - a) / h**2
        quintic = (6 * q / h**2 - 3 * v / h + a / 2) / h**3
        return PPoly(np.stack([quintic, quartic, cubic, ddq[:-1] / 2, self.dq[:-1], self.q[:-1]]), self.t)


def read_reference(path: str | Path, model: Model) -> Reference:
    """The reference in a file: t, q1..qN, and dq1..dqN, ddq1..ddqN when it has them, in SI units.

    Joint names may stand in place of the numbers. Without velocities they come from the projection of the positions.
    A file without such columns is read as a log of the robot, by the model file's `log:` section: its reference
    columns, else its positions. Raises InputError for what cannot be a motion.
    """
    table = read_table(path)
    names = _names(table, "", model.joints)
    if names is None:
        return _from_log(read_log(path, model.log, model.joints), str(path))
    t = _time(table, names, model)
    q, dq, ddq = (_columns(table, _names(table, order, model.joints), t) for order in ("", "d", "dd"))
    assert q is not None
    if dq is None:
        rows = table.rows(len(t))
        return _projected(Log(Path(path), "", model.joints, (Record(t, q, None, None, rows),), ()))
    return Reference(t - t[0], q, dq, ddq)


def _names(table: Table, order: str, joints: tuple[str, ...]) -> tuple[str, ...] | None:
    """Columns of all joints, by number or by name; None without them."""
    for names in (tuple(f"{order}q{j}" for j in range(1, len(joints) + 1)), tuple(order + name for name in joints)):
        if all(table.find(name) for name in names):
            return names
    return None


def _time(table: Table, names: tuple[str, ...], model: Model) -> Array:
    name = model.log.time if model.log.time and table.find(model.log.time) else guess_time(table)
    if name is None and model.log.rate is not None:
        return even_clock(len(table.column(names[0])), model.log.rate).t
    if name is None:
        raise InputError("no time column", hint="a trajectory has the columns t, q1, q2, ...", place=Place(table.shown))
    t = table.column(name)
    where = Place(table.shown, column=name)
    if len(t) < 2:
        raise InputError(f"holds {len(t)} samples", hint="a trajectory has at least 2", place=where)
    bad = np.flatnonzero(~(np.diff(t, prepend=-np.inf) > 0))
    if len(bad):
        place = replace(where, row=int(table.rows(len(t))[bad[0]]), value=float(t[bad[0]]))
        raise InputError("time does not increase", hint="sort the rows and remove what is there twice", place=place)
    return t


def _columns(table: Table, names: tuple[str, ...] | None, t: Array) -> Array | None:
    if names is None:
        return None
    for name in names:
        column = table.column(name)
        place = Place(table.shown, column=name)
        if len(column) != len(t):
            raise InputError(f"has {len(column)} samples, the time {len(t)}", hint="make them equal", place=place)
        bad = np.flatnonzero(~(np.abs(column) < 1e6))
        if len(bad):
            place = replace(place, row=int(table.rows(len(t))[bad[0]]), value=float(column[bad[0]]))
            raise InputError("is no position of a motion", hint="fill in or remove that row", place=place)
    return np.stack([table.column(name) for name in names], axis=1)


def _from_log(log: Log, shown: str) -> Reference:
    record = max(log.records, key=lambda one: one.duration)
    if len(log.records) > 1:
        raise InputError(
            f"is cut into {len(log.records)} records: no single motion",
            hint=f"keep only the longest, rows {record.rows[0]}-{record.rows[-1]}",
            place=Place(shown),
        )
    if record.reference is not None:
        record = replace(record, q=record.reference)
    return _projected(replace(log, records=(record,)))


def _projected(log: Log) -> Reference:
    """Positions as they are, velocities of their projection."""
    (record,) = log.records
    dq = np.column_stack([p.at(record.t, 1) for p in project_record(log, record, Setting())])
    return Reference(record.t - record.t[0], record.q, dq)
