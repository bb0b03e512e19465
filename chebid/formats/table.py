"""Columns of a file as they are: names, float64 values, row numbers, and the cells that are no numbers."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Notice, Place

_UNIT = re.compile(r"^(?P<name>.*?\S)\s*[\[(](?P<unit>[^\[\]():,]*)[\])]$")
_PART = re.compile(r"^(?P<name>.+)\[\s*(?:(?P<row>\d+)\s*,\s*:|:\s*,\s*(?P<column>\d+))\s*\]$")

_EITHER = re.compile(r"[+-]?\d*[.,]\d+(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class TextCells:
    """Cells of a column that are neither numbers nor missing: how many, and the first one."""

    count: int
    row: int
    value: str


@dataclass(frozen=True)
class Table:
    """What a file holds.

    `arrays`: variables by name, float64, (N,) or 2-D; NaN where a cell is missing or holds text.
    `first_row`, `lines`: row numbers as `errors.Place` counts them; `lines` only when lines were skipped in between.
    `text`: the columns with cells that are no numbers. `notices`: what was odd in reading. `nameless`: the columns that
    the file does not name. `units`: those of a line of units below the header.
    """

    path: Path
    shown: str
    format: str
    arrays: Mapping[str, NDArray[np.float64]]
    first_row: int = 1
    lines: NDArray[np.int64] | None = None
    text: Mapping[str, TextCells] = field(default_factory=dict)
    notices: tuple[Notice, ...] = ()
    nameless: frozenset[str] = frozenset()
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def headless(self) -> bool:
        """Whether no column has a name of its own."""
        return bool(self.arrays) and len(self.nameless) == len(self.arrays)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Every column by the name to refer to it, those of matrices as `name[:,k]` or `name[k,:]`."""
        return tuple(name for key, array in self.arrays.items() for name in _column_names(key, array))

    def rows(self, count: int) -> NDArray[np.int64]:
        """Row numbers of the first `count` samples."""
        if self.lines is not None:
            return self.lines[:count]
        return np.arange(self.first_row, self.first_row + count, dtype=np.int64)

    def unit(self, name: str) -> str | None:
        """The unit that the file gives for a column, in brackets after the name or in a line of units."""
        found = self.units.get(name) or header_unit(name)
        return found.strip(" []()") if found else None

    def find(self, name: str) -> str | None:
        """The column that `name` means: exactly so called, or so called but for a unit in brackets."""
        if name in self.arrays or self._part(name) is not None:
            return name
        bare = [known for known in self.names if base_name(known) == name.strip()]
        if len(bare) > 1:
            raise InputError(
                f"'{name}' may be any of {', '.join(bare)}",
                hint="write the whole name in the model file's log: section",
                place=Place(file=self.shown, column=name),
            )
        return bare[0] if bare else None

    def column(self, name: str) -> NDArray[np.float64]:
        """Values (N,) of the column `name`, NaN where missing.

        Raises InputError when there is no such column, when it holds text, or when it is a matrix.
        """
        found = self.find(name)
        if found is None:
            raise InputError(f"no column '{name}'", hint=self._offer(name), place=Place(file=self.shown, column=name))
        if found in self.text:
            raise self._not_numeric(found)
        part = self._part(found)
        array = self.arrays[found] if part is None else part
        if array.ndim == 2:
            if 1 not in array.shape:
                raise InputError(
                    f"is a matrix of {array.shape[0]} x {array.shape[1]}",
                    hint=f"name one column of it, such as '{_column_names(found, array)[0]}'",
                    place=Place(file=self.shown, column=name),
                )
            array = array.reshape(-1)
        return array

    def _part(self, name: str) -> NDArray[np.float64] | None:
        match = _PART.match(name)
        if match is None:
            return None
        array = self.arrays.get(match["name"])
        if array is None or array.ndim != 2:
            return None
        axis, index = (0, int(match["row"])) if match["row"] is not None else (1, int(match["column"]))
        return np.take(array, index, axis=axis) if index < array.shape[axis] else None

    def _offer(self, name: str) -> str:
        close = get_close_matches(name, self.names, n=3, cutoff=0.6)
        if close:
            return f"did you mean {', '.join(close)}?"
        if self.headless:
            return (
                "the file has no header line: write the names above the data, or refer to 'column 1', 'column 2', ..."
            )
        some = ", ".join(self.names[:8]) + (", ..." if len(self.names) > 8 else "")
        return f"name one in the log: section; the columns are {some}" if some else "the file holds no numeric column"

    def _not_numeric(self, name: str) -> InputError:
        cells = self.text[name]
        place = Place(file=self.shown, column=name, row=cells.row, value=cells.value)
        more = f" ({cells.count} such cells)" if cells.count > 1 else ""
        hint = "correct it, or leave it empty to mark it missing"
        if _EITHER.fullmatch(cells.value.strip()):
            hint = "decimal commas and points are mixed: write all numbers of the file alike"
        return InputError(f"the cell is not a number{more}", hint=hint, place=place)


def base_name(name: str) -> str:
    """The name of a column without the unit in brackets: `q1 [rad]` is `q1`."""
    match = _UNIT.match(name.strip())
    return match["name"] if match and not _PART.match(name) else name.strip()


def header_unit(name: str) -> str | None:
    """The unit in brackets at the end of a column name, None when there is none."""
    match = _UNIT.match(name.strip())
    return match["unit"].strip() if match and not _PART.match(name) else None


def _column_names(name: str, array: NDArray[np.float64]) -> list[str]:
    """Names of the columns of one variable; the longer side of a matrix is that of the samples."""
    if array.ndim == 1 or 1 in array.shape:
        return [name]
    if array.shape[1] > array.shape[0]:
        return [f"{name}[{k},:]" for k in range(array.shape[0])]
    return [f"{name}[:,{k}]" for k in range(array.shape[1])]


def as_columns(values: NDArray) -> NDArray[np.float64] | None:
    """A variable as float64 columns, None when it holds none: text, complex, scalar, more than two sides."""
    if values.dtype.kind not in "fiub" or values.ndim not in (1, 2) or max(values.shape, default=0) < 2:
        return None
    if values.dtype.kind == "b":
        return None
    return np.ascontiguousarray(values, dtype=np.float64)
