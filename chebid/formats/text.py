"""CSV, TSV and other text tables, plain or gzipped.

The fast way hands the bytes to pyarrow and is taken whenever the file is as regular as it looks. Whatever is odd
(comments between rows, ragged rows, text in cells, UTF-16) goes the slow way, line by line, which can name the row.
"""

import gzip
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
from numpy.typing import NDArray

from chebid.errors import InputError, Notice, Place
from chebid.formats.dialect import MISSING, Dialect, dialect_of, encoding_of, is_binary, is_comment, is_number, split
from chebid.formats.limits import LINE, check_size
from chebid.formats.table import Table, TextCells

_BLOCK = 2**20
_RAGGED = 0.01  # share of rows of another width that is bearable


def read(path: Path, shown: str) -> Table:
    """The columns of a text table. Raises InputError for binary, blank or hopelessly ragged files."""
    with _open(path) as file:
        head = _sniff(file, shown)
    whole = len(head) < _BLOCK
    encoding = encoding_of(head, shown)
    dialect = dialect_of(head.decode(encoding, errors="replace"), encoding, shown, whole)
    names, nameless = _names(dialect, shown)
    table = _fast(path, shown, dialect, names)
    arrays, text, first, lines, notices = table if table is not None else _slow(path, shown, dialect, names)
    for name in [name for name in nameless if not np.isfinite(arrays[name]).any() and name not in text]:
        del arrays[name]  # a separator at the end of every line
    if dialect.header and len(dialect.header) < dialect.width and names[-1] in arrays:
        raise _unequal(len(dialect.header), dialect, shown)
    arrays = _without_blank_tail(arrays)
    return Table(path, shown, "text", arrays, first, lines, text, tuple(notices), frozenset(nameless & set(arrays)))


def _open(path: Path) -> Any:
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    return gzip.open(path, "rb") if packed else path.open("rb")


def _sniff(file: Any, shown: str) -> bytes:
    """The first megabyte, which must not be blank."""
    head: bytes = file.read(_BLOCK)
    if not head.strip(b" \t\r\n\x00,;"):
        size = "the first MiB" if len(head) == _BLOCK else "the file"
        raise InputError(f"{size} is blank", hint="record or export the log again", place=Place(file=shown))
    return head


def _names(dialect: Dialect, shown: str) -> tuple[list[str], set[str]]:
    """One name per column; those without one are `column k`, counted from 1.

    Raises InputError when the header has more names than the rows have cells, or fewer by more than one.
    """
    header = list(dialect.header or [""] * dialect.width)
    while len(header) > dialect.width and not header[-1]:
        header.pop()
    if not dialect.width - 1 <= len(header) <= dialect.width:
        raise _unequal(len(header), dialect, shown)
    header += [""] * (dialect.width - len(header))
    names, nameless = [], set()
    for place, name in enumerate(header, 1):
        if not name:
            name = f"column {place}"
            nameless.add(name)
        names.append(name)
    return names, nameless


def _unequal(found: int, dialect: Dialect, shown: str) -> InputError:
    return InputError(
        f"the header has {found} names, the rows have {dialect.width} cells",
        hint="check the separator, and that no number has a decimal comma in a comma-separated file",
        place=Place(file=shown, row=dialect.first),
    )


def _without_blank_tail(arrays: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Without the rows at the end in which every cell is missing, as spreadsheets append them."""
    ends = [int(np.flatnonzero(np.isfinite(values))[-1]) + 1 for values in arrays.values() if np.isfinite(values).any()]
    end = max(ends, default=0)
    return {name: values[:end] for name, values in arrays.items()}


class _Guard(io.RawIOBase):
    """The bytes of a text file as pyarrow asks for them, counted and watched."""

    def __init__(self, file: Any, shown: str) -> None:
        self.file, self.shown, self.total, self.newlines, self.last = file, shown, 0, 0, b""
        self.since = 0

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        block: bytes = self.file.read(size if size > 0 else _BLOCK)
        self.watch(block)
        return block

    def watch(self, block: bytes) -> None:
        """Count, and refuse what is no table of numbers."""
        self.total += len(block)
        check_size(self.total, self.shown)
        if block and np.frombuffer(block, np.uint8).min() < 9 and is_binary(block):
            raise InputError(
                f"turns binary after line {self.newlines + 1}",
                hint="the recording was cut off: copy the file again, or cut the damaged end",
                place=Place(file=self.shown, row=self.newlines + 1),
            )
        count = block.count(b"\n") or block.count(b"\r")
        self.since = len(block) - max(block.rfind(b"\n"), block.rfind(b"\r")) if count else self.since + len(block)
        if self.since > LINE:
            raise InputError(
                f"line {self.newlines + count + 1} is longer than {LINE} bytes",
                hint="is it a text table? Export the log as CSV, one sample per line",
                place=Place(file=self.shown, row=self.newlines + count + 1),
            )
        self.newlines += count
        self.last = block[-1:] or self.last


def _fast(path: Path, shown: str, dialect: Dialect, names: list[str]) -> Any:
    """The whole table through pyarrow, None when anything is not as regular as the first lines are."""
    if dialect.encoding.startswith("utf-16") or len(set(names)) != len(names) or len(names) != dialect.width:
        return None
    with _open(path) as file:
        skipped = _skip(file, dialect.first - 1)
        guard = _Guard(file, shown)
        try:
            data = pc.read_csv(
                pa.PythonFile(guard, mode="r"),
                read_options=pc.ReadOptions(column_names=names, block_size=4 * _BLOCK),
                parse_options=pc.ParseOptions(delimiter=dialect.separator, ignore_empty_lines=True),
                convert_options=pc.ConvertOptions(
                    column_types=dict.fromkeys(names, pa.float64()),
                    decimal_point=dialect.decimal,
                    null_values=_nulls(),
                ),
            )
        except (pa.ArrowInvalid, pa.ArrowKeyError, OSError):
            return None
    lines = guard.newlines + (guard.last not in (b"\n", b"\r", b""))
    if data.num_rows != lines or data.num_rows == 0:
        return None
    arrays = {
        name: np.require(column.to_numpy(), requirements="W") for name, column in zip(names, data.columns, strict=True)
    }
    return arrays, {}, skipped + 1, None, []


def _skip(file: Any, count: int) -> int:
    for _ in range(count):
        file.readline(LINE)
    return count


def _nulls() -> list[str]:
    return sorted(
        {form for word in MISSING for form in (word, word.upper(), word.capitalize())} | {"NaN", "#N/A", "N/A"}
    )


def _lines(path: Path, shown: str, encoding: str) -> Iterator[tuple[int, str, bool]]:
    """Lines that hold something: number, text, whether a line end follows."""
    with _open(path) as file:
        guard = _Guard(file, shown) if not encoding.startswith("utf-16") else None
        raw: Any = io.BufferedReader(_Reader(guard), _BLOCK) if guard else file
        total = 0
        for number, line in enumerate(io.TextIOWrapper(raw, encoding=encoding, errors="replace", newline=None), 1):
            total += len(line)
            check_size(total, shown)
            if line.strip():
                yield number, line.rstrip("\n"), line.endswith("\n")


class _Reader(io.RawIOBase):
    """A `_Guard` as the raw layer below Python's own decoding."""

    def __init__(self, guard: _Guard) -> None:
        self.guard = guard

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        block = self.guard.read(len(buffer))
        buffer[: len(block)] = block
        return len(block)


def _slow(path: Path, shown: str, dialect: Dialect, names: list[str]) -> Any:
    """The table line by line: ragged rows become missing, cells of text are counted."""
    width = max(dialect.width, len(names) if dialect.header else 0)
    rows, numbers, ragged, finished = [], [], [], True
    for number, line, ended in _lines(path, shown, dialect.encoding):
        if number < dialect.first or is_comment(line):
            continue
        cells = split(line, dialect.separator)
        if len(cells) > width and not any(cells[width:]):
            cells = cells[:width]
        if len(cells) != width:
            ragged.append((number, len(cells)))
            cells = [""] * width
        rows.append(cells)
        numbers.append(number)
        finished = ended
    if not rows:
        raise InputError("holds a header and no data", hint="record or export the log again", place=Place(file=shown))
    notices = _ragged(rows, numbers, ragged, width, finished, shown)
    _refuse_twins(names, shown)
    arrays: dict[str, NDArray[np.float64]] = {}
    text: dict[str, TextCells] = {}
    lines = np.asarray(numbers, dtype=np.int64)
    for place, name in enumerate(names):
        column = [row[place] for row in rows]
        arrays[name], bad = _numbers(column, lines, dialect.decimal)
        if bad:
            text[name] = bad
    return arrays, text, int(lines[0]), lines, notices


def _numbers(column: list[str], lines: NDArray[np.int64], decimal: str) -> tuple[NDArray[np.float64], TextCells | None]:
    """Cells as float64; missing ones and text are NaN, and the first text is told."""
    if decimal == ",":
        column = [cell.replace(",", ".") for cell in column]
    try:
        return np.array(column, dtype=np.float64), None
    except ValueError:
        pass
    values = np.full(len(column), np.nan)
    bad: list[int] = []
    for place, cell in enumerate(column):
        if is_number(cell, "."):
            values[place] = float(cell)
        elif cell.lower() not in MISSING:
            bad.append(place)
    if not bad:
        return values, None
    return values, TextCells(len(bad), int(lines[bad[0]]), column[bad[0]])


def _ragged(
    rows: list[list[str]], numbers: list[int], ragged: list[tuple[int, int]], width: int, finished: bool, shown: str
) -> list[Notice]:
    """Notices about rows of another width, or an InputError when they are many. Drops a last line cut short."""
    notices = []
    if ragged and ragged[-1][0] == numbers[-1] and ragged[-1][1] < width:
        number, found = ragged.pop()
        rows.pop()
        numbers.pop()
        message = f"the last line has {found} of {width} cells: the recording was cut off; the row is left out"
        notices.append(Notice("truncated", message, Place(file=shown, row=number)))
    if not ragged:
        return notices
    number, found = ragged[0]
    place = Place(file=shown, row=number)
    if len(ragged) > max(3, _RAGGED * len(rows)):
        raise InputError(
            f"the row has {found} cells where others have {width} ({len(ragged)} such rows)",
            hint="check the separator, and that no number has a decimal comma in a comma-separated file",
            place=place,
        )
    message = f"the row has {found} cells where others have {width}: taken as missing ({len(ragged)} such rows)"
    return [Notice("ragged", message, place), *notices]


def _refuse_twins(names: list[str], shown: str) -> None:
    twin = next((name for name in names if names.count(name) > 1), None)
    if twin is not None:
        place = Place(file=shown, column=twin)
        raise InputError("two columns have this name", hint="rename one of them in the first line", place=place)
