"""What a single column, or two side by side, tell about the log: missing samples, absurd values, units, mix-ups."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chebid.log.findings import Findings
from chebid.log.roughness import quantum

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

ABSURD_POSITION = 1e6  # rad or m
ABSURD_TORQUE = 1e9  # N.m or N
ABSURD_SIGNAL = 1e30  # of a signal of unknown unit; single precision writes 3e38 for "no value"
_FLAT = 2.0  # encoder counts within which a joint does not move
_LEVELS = 20  # different values that a torque has at least, for a plateau to mean anything
_PLATEAU = 3  # samples in a row at the limit
_SATURATED = 0.002  # share of samples at the limit
_SMOOTHER = 10.0  # times as smooth as the position, for a torque column to be suspected to be one
_TURN = 4 * np.pi
_IN_DEGREES = "write 'position_gain: 0.0174532925' in the log: section of the model file"


def check_missing(values: Array, names: Sequence[str], rows: Rows, findings: Findings) -> Array:
    """A copy of `values` (N, columns) with NaN for every missing sample; infinities count as such.

    Raises InputError for a column of which more than half is missing.
    """
    clean = np.where(np.isfinite(values), values, np.nan)
    for name, column, bare in zip(names, values.T, clean.T, strict=True):
        lost = np.flatnonzero(np.isnan(bare))
        if len(lost) == 0:
            continue
        where = {"column": name, "row": rows[lost[0]], "value": column[lost[0]]}
        if len(lost) > len(column) / 2:
            message = f"{len(lost)} of {len(column)} samples are missing"
            raise findings.error(message, "name another column, or record the log again", **where)
        findings.note("missing", f"{len(lost)} of {len(column)} samples are missing: left out", **where)
    return clean


def check_magnitude(
    values: Array, names: Sequence[str], gain: Array, limit: float, rows: Rows, findings: Findings
) -> None:
    """Raise InputError for a value (N, columns) that `gain` (joints, columns) turns into more than `limit`."""
    for place, name in enumerate(names):
        largest = float(np.abs(gain[:, place]).max())
        size = np.abs(np.nan_to_num(values[:, place])) * largest
        bad = np.flatnonzero(size > limit)
        if len(bad):
            also = f", and {len(bad) - 1} more like it" if len(bad) > 1 else ""
            message = f"no sensor gives such a value{also} (the limit is {limit:g} after the gain)"
            hint = "leave the cell empty to mark it missing, or correct the gain in the model file's log: section"
            raise findings.error(message, hint, column=name, row=rows[bad[0]], value=values[bad[0], place])


def check_motion(values: Array, names: Sequence[str], rows: Rows, findings: Findings, *, needed: bool) -> None:
    """Notices for columns (N, columns) that never move; an InputError when motion is `needed` and there is none."""
    still = [name for name, column in zip(names, values.T, strict=True) if _is_flat(column[np.isfinite(column)])]
    if needed and len(still) == len(names):
        message = "no joint moves" if len(names) > 1 else "the joint does not move"
        hint = "record a motion, or name the columns of the positions in the model file's log: section"
        raise findings.error(message, hint, column=still[0], row=rows[0], value=values[0, names.index(still[0])])
    for name in still:
        value = values[0, names.index(name)]
        findings.note("constant", "never moves", column=name, row=rows[0], row_end=rows[-1], value=value)


def _is_flat(column: Array) -> bool:
    reach = float(np.ptp(column)) if len(column) else 0.0
    return reach == 0.0 or (reach <= _FLAT * 1.01 * quantum(column) and reach < 0.05 * abs(float(column[0])) + 1e-2)


def check_saturation(values: Array, names: Sequence[str], rows: Rows, findings: Findings) -> None:
    """Notices for torques (N, columns) that stay at exactly their largest or smallest value."""
    for name, column in zip(names, values.T, strict=True):
        finite = column[np.isfinite(column)]
        if len(np.unique(finite[:: max(len(finite) // 2000, 1)])) < _LEVELS:
            continue
        for limit in (float(finite.max()), float(finite.min())):
            at = column == limit
            run = at[_PLATEAU - 1 :].copy()
            for shift in range(_PLATEAU - 1):
                run &= at[shift : len(at) - _PLATEAU + 1 + shift]
            count = int(at.sum())
            if run.any() and count >= max(2 * _PLATEAU, _SATURATED * len(at)):
                first = int(np.flatnonzero(run)[0])
                message = f"{count} samples stand at exactly this limit: the drive or the sensor is saturated"
                findings.note("saturation", message, column=name, row=rows[first], value=limit)


def check_units(
    position: Array, names: Sequence[str], units: Sequence[str | None], gain: Array, rows: Rows, findings: Findings
) -> None:
    """Notices for positions that look like degrees while the gain takes them as radians."""
    for place, name in enumerate(names):
        unit = (units[place] or "").lower()
        if not (gain[:, place] == 1.0).any() and (gain[:, place] != 0).any():
            continue
        size = np.abs(np.nan_to_num(position[:, place]))
        if unit in ("deg", "°", "degree", "degrees"):
            message = f"the name says degrees, the gain takes it as radians: {_IN_DEGREES}"
        elif _TURN < size.max() <= 1e4 and unit not in ("rad", "m"):
            message = f"reaches a value large for radians; if the log is in degrees, {_IN_DEGREES}"
        else:
            continue
        worst = int(np.argmax(size))
        findings.note("degrees", message, column=name, row=rows[worst], value=position[worst, place])


def check_equal(
    position: Array, position_names: Sequence[str], torque: Array, torque_names: Sequence[str], findings: Findings
) -> None:
    """Notices for columns (N, columns) with the same numbers; an InputError when a torque equals a position."""
    found: list[tuple[str, str, Array]] = []
    for role, names, values in (("position", position_names, position), ("torque", torque_names, torque)):
        for name, column in zip(names, values.T, strict=True):
            twin = next(((known, other) for known, other, earlier in found if _same(column, earlier)), None)
            found.append((role, name, column))
            if twin is None or _is_flat(column[np.isfinite(column)]):
                continue
            if twin[0] != role:
                hint = "name the columns of the torques in the model file's log: section"
                raise findings.error(f"holds the same numbers as the position column '{twin[1]}'", hint, column=name)
            findings.note("duplicate", f"holds the same numbers as '{twin[1]}'", column=name)


def check_exchanged(
    position: Array, position_names: Sequence[str], torque: Array, torque_names: Sequence[str], findings: Findings
) -> bool:
    """Whether most torque columns (N, columns) are much smoother than the positions; says so in a notice."""
    rough = [_wildness(column) for column in position.T]
    smooth = [_wildness(column) for column in torque.T]
    suspects = [place for place in range(min(len(rough), len(smooth))) if rough[place] > _SMOOTHER * smooth[place] > 0]
    if not suspects or 2 * len(suspects) <= len(rough):
        return False
    one, other = position_names[suspects[0]], torque_names[suspects[0]]
    message = f"is much rougher than the torque column '{other}': are positions and torques exchanged?"
    findings.note("swapped", message, column=one)
    return True


def _same(one: Array, other: Array) -> bool:
    few = slice(None, None, max(len(one) // 100, 1))  # enough to tell almost all pairs apart
    return all(np.array_equal(one[part], other[part], equal_nan=True) for part in (few, slice(None)))


def _wildness(column: Array) -> float:
    """Second differences per deviation: next to nothing for a position, much for a torque."""
    finite = column[np.isfinite(column)]
    spread = float(np.std(finite)) if len(finite) > 3 else 0.0
    return float(np.median(np.abs(np.diff(finite, 2)))) / spread if spread > 0 else 0.0
