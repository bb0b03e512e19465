"""From the records of a log to the motion of the joints: q, dq, ddq at the instants of the torque samples."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.effects import Motion
from chebid.errors import InputError, NoAnswerError, Place
from chebid.log import Log, Record
from chebid.projection import Plan, Projection, Setting, project
from chebid.projection.quality import TOLERATED_SHARE

Mask = NDArray[np.bool_]
_MOST_CUT = 0.2  # of a record at each end, when the trim is automatic


@dataclass(frozen=True)
class Used:
    """A plan and the duration in s of the record that it was made for."""

    plan: Plan
    duration: float


@dataclass(frozen=True)
class Track:
    """One record, projected: the motion at its instants, shifted by the torque's delay.

    `valid` (N,) is False near the ends and where a sample is missing; `tau` (N, J) measured torque or None. `signs`:
    for each joint those others the direction of whose motion enters its equation; empty when there are none.
    """

    log: Log
    record: Record
    projections: tuple[Projection, ...]
    motion: Motion
    valid: Mask
    tau: Array | None
    signs: tuple[tuple[int, ...], ...] = ()
    left_out: Mask | None = None
    trim: float = 0.0  # s that were cut at each end

    @property
    def torque(self) -> Array:
        """Measured torque (N, J); for tracks of logs that have one."""
        assert self.tau is not None, "require_torque comes first"
        return self.tau

    @property
    def rate(self) -> float:
        return (len(self.motion.t) - 1) / float(self.motion.t[-1] - self.motion.t[0])

    @property
    def used(self) -> tuple[Used, ...]:
        """The plans, for other records of the same robot."""
        return tuple(Used(p.plan, float(p.t[-1] - p.t[0])) for p in self.projections)

    @cached_property
    def whole(self) -> bool:
        """Whether the projections leave out no more of the accelerations than an identification tolerates."""
        return all(p.energy_left_out <= TOLERATED_SHARE for p in self.projections)

    @property
    def bandwidth(self) -> float:
        """Hz up to which all joints are passed."""
        return min(p.plan.bandwidth for p in self.projections)


def make_track(
    log: Log,
    record: Record,
    setting: Setting,
    *,
    plans: tuple[Used, ...] | None = None,
    delay: float = 0.0,
    trim: float | None = None,
    least: float = 0.0,
) -> Track:
    """Project every joint of a record. `plans` of an earlier fit replace the choice; `delay` s by which torque lags.

    `trim` s is cut at each end; None: the end effect of the accelerations, at least one period of the bandwidth and
    `least` s, at most a fifth of the record. Where positions lack for longer than the projection can bridge, that is an
    end as well.
    """
    projections = project_record(log, record, plans or setting)
    at = record.t - delay if delay else record.t
    q, dq, ddq = (np.column_stack([p.at(at, order) for p in projections]) for order in (0, 1, 2))
    cut = trim if trim is not None else _end(projections, record.duration, least)
    inside = (at >= record.t[0] + cut) & (at <= record.t[-1] - cut)
    for projection in projections:
        inside &= _bridged(projection, at, cut)
    known = np.isfinite(record.tau).all(axis=1) if record.tau is not None else True
    return Track(log, record, projections, Motion(at, q, dq, ddq), inside & known, record.tau, trim=cut)


def _end(projections: tuple[Projection, ...], duration: float, least: float) -> float:
    """Seconds at each end where accelerations cannot be trusted: of all joints, but never the better part of a record
    (a joint that rests has next to no bandwidth, and no accelerations either).
    """
    needed = max(max(p.end_length(), 1 / p.plan.bandwidth) for p in projections)
    return min(max(needed, least), _MOST_CUT * duration)


def _bridged(projection: Projection, at: Array, cut: float) -> Mask:
    """Which instants (N,) lie outside, by `cut` s, every stretch without samples that lasts half a period or more."""
    longest = max(0.5 / projection.plan.bandwidth, 3 * float(np.median(np.diff(projection.t))))
    t = np.concatenate([[min(at[0], projection.t[0])], projection.t, [max(at[-1], projection.t[-1])]])
    out = np.ones(len(at), dtype=bool)
    for gap in np.flatnonzero(np.diff(t) > longest):
        out &= (at <= t[gap] - cut) | (at >= t[gap + 1] + cut)
    return out


def project_record(log: Log, record: Record, how: Setting | tuple[Used, ...]) -> tuple[Projection, ...]:
    """Every signal of a record, projected: by one setting, or by the plans of an earlier fit."""
    each = how if isinstance(how, tuple) else (how,) * len(log.names)
    return tuple(_project(log, record, j, each[j], name) for j, name in enumerate(log.names))


def _project(log: Log, record: Record, joint: int, setting: Setting | Used, name: str) -> Projection:
    chosen = adapt(setting, record.t) if isinstance(setting, Used) else setting
    try:
        return project(record.t, record.q[:, joint], chosen, name)
    except NoAnswerError as err:
        place = replace(
            err.place, file=str(log.path), column=name, row=int(record.rows[0]), row_end=int(record.rows[-1])
        )
        raise NoAnswerError(err.message, hint=err.hint, place=place) from None


def adapt(used: "Used", t: Array) -> Plan:
    """The plan of an earlier projection for a record at t (N,) s: same degree per second, window and penalty."""
    span, plan = float(t[-1] - t[0]), used.plan
    window = plan.window or used.duration
    if abs(span - used.duration) <= 1e-3 * span:
        return plan
    if span > 1.5 * window:
        return replace(plan, window=window)
    return replace(plan, window=None, degree=max(4, round(plan.degree * span / window)))


def require_torque(log: Log) -> None:
    """Raise InputError when a log has no torque."""
    for record in log.records:
        if record.tau is None:
            continue
        for joint, column in zip(log.names, record.tau.T, strict=True):
            if np.nanmax(column) == np.nanmin(column) and np.isfinite(column).any():
                raise InputError(
                    f"the torque of joint {joint} never changes: it cannot have been measured",
                    hint="name the right column in the model file, under log: torque:",
                    place=Place(file=str(log.path), row=int(record.rows[0]), value=float(np.nanmax(column))),
                )
    if any(record.tau is None for record in log.records):
        raise InputError(
            "has no torque columns",
            hint="name them in the model file, under log: torque:",
            place=Place(file=str(log.path)),
        )
