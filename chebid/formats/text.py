"""CSV, TSV and other text tables, plain or gzipped.

The fast way hands the bytes to pyarrow and is taken whenever the file is as regular as it looks. Whatever is odd
(comments between rows, blanks as separators, ragged rows, UTF-16, a word in a cell) goes the careful way: line by
line into a regular table, with the number of every line, so that a message can name it.
"""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc
from numpy.typing import NDArray

from chebid.errors import InputError, Notice, Place
from chebid.formats.dialect import MISSING, Dialect, dialect_of, encoding_of, is_comment, is_number, split
from chebid.formats.stream import BLOCK, Guard, open_text, sniff, text_lines
from chebid.formats.table import Table, TextCells

_RAGGED = 0.01  # share of rows of another width that is bearable
_NULLS = sorted({form for word in MISSING for form in (word, word.upper(), word.capitalize())} | {"NaN"})

Columns = dict[str, NDArray[np.float64]]


@dataclass
class _Content:
    """What was read: columns, the number of each one's line (None: one after the other), text cells, notices."""

    columns: Columns
    lines: NDArray[np.int64] | None
    text: dict[str, TextCells]
    notices: list[Notice]


def read(path: Path, shown: str) -> Table:
    """The columns of a text table. Raises InputError for binary, blank or hopelessly ragged files."""
    head = sniff(path, shown)
    encoding = encoding_of(head, shown)
    dialect = dialect_of(head.decode(encoding, errors="replace"), encoding, shown, whole=len(head) < BLOCK)
    names, nameless = _names(dialect, shown)
    _refuse_twins(names, shown)
    content = _fast(path, shown, dialect, names) or _careful(path, shown, dialect, names)
    _drop_empty(content, nameless)
    if dialect.header and len(dialect.header) < dialect.width and names[-1] in content.columns:
        raise _unequal(len(dialect.header), dialect, shown)
    return Table(
        path,
        shown,
        "text",
        _without_blank_tail(content.columns),
        dialect.first,
        content.lines,
        content.text,
        tuple(content.notices),
        frozenset(nameless & set(content.columns)),
        dict(zip(names, dialect.units or (), strict=False)),
    )


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
    nameless = {f"column {place}" for place, name in enumerate(header, 1) if not name}
    return [name or f"column {place}" for place, name in enumerate(header, 1)], nameless


def _unequal(found: int, dialect: Dialect, shown: str) -> InputError:
    hint = "check the separator, and that no number has a decimal comma in a comma-separated file"
    if dialect.separator == "," and dialect.width == 2 * found:
        hint = "the numbers seem to have a decimal comma: export with ';' or tabs between them, or with decimal points"
    return InputError(
        f"the header has {found} names, the rows have {dialect.width} cells",
        hint=hint,
        place=Place(file=shown, row=dialect.first),
    )


def _refuse_twins(names: list[str], shown: str) -> None:
    twin = next((name for name in names if names.count(name) > 1), None)
    if twin is not None:
        place = Place(file=shown, column=twin)
        raise InputError("two columns have this name", hint="rename one of them in the first line", place=place)


def _drop_empty(content: _Content, nameless: set[str]) -> None:
    """Remove the empty columns without a name that a separator at the end of every line makes."""
    for name in nameless - set(content.text):
        if not np.isfinite(content.columns[name]).any():
            del content.columns[name]


def _without_blank_tail(columns: Columns) -> Columns:
    """Without the rows at the end in which every cell is missing, as spreadsheets append them."""
    ends = [np.flatnonzero(np.isfinite(values[-1000:])) for values in columns.values()]
    if any(len(end) and end[-1] == len(values[-1000:]) - 1 for end, values in zip(ends, columns.values(), strict=True)):
        return columns
    ends = [np.flatnonzero(np.isfinite(values)) for values in columns.values()]
    last = max((int(end[-1]) + 1 for end in ends if len(end)), default=None)
    return {name: values[:last] for name, values in columns.items()}


# --- the fast way ---------------------------------------------------------------------------------------------------


def _fast(path: Path, shown: str, dialect: Dialect, names: list[str]) -> _Content | None:
    """The whole table through pyarrow, None when anything is not as regular as the first lines are."""
    if dialect.encoding.startswith("utf-16"):
        return None
    words = dialect.words
    while True:
        with open_text(path) as file:
            for _ in range(dialect.first - 1):
                file.readline(BLOCK)
            guard = Guard(path, file, shown, len(names))
            try:
                data = _parse(pa.PythonFile(guard, mode="r"), names, dialect.separator, dialect.decimal, words)
                break
            except (pa.ArrowInvalid, pa.ArrowKeyError) as err:
                guard.check()
                more = _with_words(words, err)
                if more is None:
                    return None
                words = more
    guard.check()
    if data.num_rows != guard.lines or data.num_rows == 0:
        return None
    content = _content(data, dialect.first + np.arange(data.num_rows), dialect.decimal, regular=True)
    return None if any(is_comment(cells.value) for cells in content.text.values()) else content


def _with_words(words: frozenset[int], err: Exception) -> frozenset[int] | None:
    """The columns that hold words, with the one that pyarrow complains of; None when it complains of something else."""
    match = re.search(r"CSV column #(\d+): CSV conversion error", str(err))
    return words | {int(match[1])} if match and int(match[1]) not in words else None


def _parse(source: Any, names: Sequence[str], separator: str, decimal: str, words: frozenset[int]) -> pa.Table:
    """The rows as pyarrow reads them: numbers, but for the columns at the places `words`."""
    kinds = [pa.binary() if place in words else pa.float64() for place in range(len(names))]
    return pc.read_csv(
        source,
        read_options=pc.ReadOptions(column_names=list(names), block_size=4 * BLOCK),
        parse_options=pc.ParseOptions(delimiter=separator),
        convert_options=pc.ConvertOptions(
            column_types=dict(zip(names, kinds, strict=True)), decimal_point=decimal, null_values=_NULLS
        ),
    )


def _content(data: pa.Table, lines: NDArray[np.int64], decimal: str, *, regular: bool) -> _Content:
    content = _Content({}, None if regular else lines, {}, [])
    for name, column in zip(data.column_names, data.columns, strict=True):
        if pa.types.is_floating(column.type):
            content.columns[name] = np.require(column.to_numpy(), requirements="W")
            continue
        content.columns[name], cells = _numbers(column, lines, decimal)
        if cells is not None:
            content.text[name] = cells
    return content


def _numbers(column: pa.ChunkedArray, lines: NDArray[np.int64], decimal: str) -> tuple[NDArray, TextCells | None]:
    """Cells of a column with words in it: numbers where they are numbers; the first of the others, and how many."""
    values = np.full(len(column), np.nan)
    words: list[int] = []
    cells = [cell.decode("utf-8", "replace").strip() for cell in column.to_pylist()]
    for place, cell in enumerate(cells):
        if is_number(cell, decimal):
            values[place] = float(cell.replace(",", "."))
        elif cell.lower() not in MISSING:
            words.append(place)
    if not words:
        return values, None
    return values, TextCells(len(words), int(lines[words[0]]), cells[words[0]])


# --- the careful way ------------------------------------------------------------------------------------------------


def _careful(path: Path, shown: str, dialect: Dialect, names: list[str]) -> _Content:
    """The table line by line: rows of another width become missing, lines keep their numbers."""
    table = _Regular(dialect.separator, len(names))
    for number, line in text_lines(path, shown, dialect.encoding, len(names)):
        if number >= dialect.first and not is_comment(line):
            table.add(number, line)
    if not table.numbers:
        raise InputError("holds a header and no data", hint="record or export the log again", place=Place(file=shown))
    notices = table.judge(shown)
    text = "\n".join(table.rows).encode()
    separator = "\t" if dialect.separator == " " else dialect.separator
    words: frozenset[int] | None = dialect.words
    while words is not None:
        try:
            data = _parse(io.BytesIO(text), names, separator, dialect.decimal, words)
            break
        except pa.ArrowInvalid as err:
            words = _with_words(words, err)
            if words is None:
                raise
    content = _content(data, np.asarray(table.numbers, dtype=np.int64), dialect.decimal, regular=False)
    content.notices = notices
    return content


class _Regular:
    """Rows made equal in width, with the numbers of their lines and a list of those that were not."""

    def __init__(self, separator: str, width: int) -> None:
        self.separator, self.width = separator, width
        self.rows: list[str] = []
        self.numbers: list[int] = []
        self.ragged: list[tuple[int, int]] = []

    def add(self, number: int, line: str) -> None:
        """One more line of data."""
        if self.separator == " ":
            line = "\t".join(split(line, " "))
        mark = "\t" if self.separator == " " else self.separator
        if '"' in line or line.count(mark) != self.width - 1:
            line = self._mended(number, split(line, mark), mark)
        self.rows.append(line)
        self.numbers.append(number)

    def _mended(self, number: int, cells: list[str], mark: str) -> str:
        if len(cells) > self.width and not any(cells[self.width :]):
            cells = cells[: self.width]
        if len(cells) != self.width:
            self.ragged.append((number, len(cells)))
            cells = ["nan"] * self.width
        return mark.join('"' + cell.replace('"', '""') + '"' if mark in cell or '"' in cell else cell for cell in cells)

    def judge(self, shown: str) -> list[Notice]:
        """Notices about rows of another width; drops a last row cut short. Raises InputError when there are many."""
        notices = []
        if self.ragged and self.ragged[-1][0] == self.numbers[-1] and self.ragged[-1][1] < self.width:
            number, found = self.ragged.pop()
            self.rows.pop()
            self.numbers.pop()
            message = f"the last line has {found} of {self.width} cells: the recording was cut off; it is left out"
            notices.append(Notice("truncated", message, Place(file=shown, row=number)))
        if not self.ragged:
            return notices
        number, found = self.ragged[0]
        many = f" ({len(self.ragged)} such rows)" if len(self.ragged) > 1 else ""
        message = f"the row has {found} cells where others have {self.width}{many}"
        place = Place(file=shown, row=number)
        if len(self.ragged) > max(3, _RAGGED * len(self.rows)):
            hint = "check the separator, and that no number has a decimal comma in a comma-separated file"
            raise InputError(message, hint=hint, place=place)
        return [Notice("ragged", f"{message}: taken as missing", place), *notices]
