"""How a text file is written: encoding, separator, decimal mark, header, comments. Told from its first lines."""

import re
from dataclasses import dataclass

from chebid.errors import InputError, Place

MISSING = frozenset(
    {"", "nan", "-nan", "+nan", "null", "#n/a", "n/a", "na", "none", "#nv", "?", "-", "nil", "nan(ind)"}
)
COMMENTS = ("#", "%", "//")
_SEPARATORS = ("\t", ";", ",", "|", " ")
_SAMPLE = 60
_NUMBER = {
    ".": re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf(?:inity)?", re.IGNORECASE),
    ",": re.compile(r"[+-]?(?:\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?|[+-]?inf(?:inity)?", re.IGNORECASE),
}


@dataclass(frozen=True)
class Dialect:
    """`separator` is ' ' for any run of blanks; `first` is the number of the first data line, from 1; `header` the
    names as written, None when the first line already holds numbers; `words` the places of columns that hold text.
    """

    encoding: str
    separator: str
    decimal: str
    header: tuple[str, ...] | None
    units: tuple[str, ...] | None
    first: int
    width: int
    words: frozenset[int]


def encoding_of(head: bytes, shown: str) -> str:
    """The encoding by byte-order mark, by the zeros of UTF-16, else UTF-8 or Latin-1. Raises InputError for binary."""
    for mark, name in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if head.startswith(mark):
            return name
    even, odd = head[0::2].count(0), head[1::2].count(0)
    half = max(len(head) // 2, 1)
    if odd > 0.7 * half and even < 0.05 * half:
        return "utf-16-le"
    if even > 0.7 * half and odd < 0.05 * half:
        return "utf-16-be"
    if is_binary(head):
        raise InputError(
            "is not a text file", hint="give the file its true suffix, or export it as CSV", place=Place(file=shown)
        )
    try:
        head[: len(head) - 4].decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def is_binary(block: bytes) -> bool:
    """Whether bytes occur that no text has."""
    controls = bytes(set(range(32)) - {9, 10, 11, 12, 13, 26, 27}) + b"\x7f"
    return len(block) != len(block.translate(None, controls))


def is_comment(line: str) -> bool:
    """Whether a line is a remark rather than data."""
    return line.lstrip().startswith(COMMENTS) and not line.lstrip().lower().startswith("#n/a")


def split(line: str, separator: str) -> list[str]:
    """The cells of one line, quotes honoured, blanks around cells dropped."""
    if separator == " ":
        return line.split() if '"' not in line else [cell.strip('"') for cell in re.findall(r'"[^"]*"|\S+', line)]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    mark = re.escape(separator)
    cells = re.findall(rf'(?:^|{mark})\s*(?:"((?:[^"]|"")*)"[^{mark}]*|([^{mark}]*))', line)
    return [(quoted.replace('""', '"') or bare).strip() for quoted, bare in cells]


def is_number(cell: str, decimal: str) -> bool:
    """Whether the cell reads as a number."""
    return _NUMBER[decimal].fullmatch(cell) is not None


def dialect_of(text: str, encoding: str, shown: str, whole: bool) -> Dialect:
    """Read the dialect off the first lines of a file; `whole` tells that `text` is all of it."""
    lines = text.splitlines() if whole else text.splitlines()[:-1] or [text]
    kept = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    data = [(number, line) for number, line in kept if not is_comment(line)]
    if not data:
        raise InputError("holds no data", hint="record or export the log again", place=Place(file=shown))
    tail = [line for _, line in data[-_SAMPLE:]]
    separator, decimal, width = _separator([line for _, line in data[:_SAMPLE]] if len(data) < 4 else tail)
    return _with_header(kept, data, encoding, separator, decimal, width)


def _separator(lines: list[str]) -> tuple[str, str, int]:
    """The separator and decimal mark that make the most cells of most lines numbers, and the usual number of cells."""
    best = (-1.0, 0, ",", ".", 1)
    for separator in _SEPARATORS:
        rows = [split(line, separator) for line in lines]
        counts = [len(row) for row in rows]
        width = max(set(counts), key=lambda count: (counts.count(count), count))
        usual = [row for row in rows if len(row) == width]
        marks = (".", ",") if separator != "," or any('"' in line for line in lines) else (".",)  # "0,5","1,5"
        for decimal in marks:
            good = sum(is_number(cell, decimal) for row in usual for cell in row)
            score = good / (width * len(usual)) * len(usual) / len(rows) + 0.2 * (width > 1)
            if score > best[0] + 1e-9:
                best = (score, 0, separator, decimal, width)
    return best[2], best[3], best[4]


def _with_header(
    kept: list[tuple[int, str]], data: list[tuple[int, str]], encoding: str, separator: str, decimal: str, width: int
) -> Dialect:
    """Find the header: the last line of words as wide as the data before the first line of numbers."""
    header, units, first = None, None, data[0][0]
    words = _words([line for _, line in data[-_SAMPLE:]], separator, decimal, width)
    for number, line in data:
        cells = split(line, separator)
        if any(is_number(cell, decimal) for cell in cells) and (header or not _names_columns(cells, decimal, words)):
            first = number
            break
        if header is not None and len(header) == len(cells) and _looks_like_units(cells):
            units = tuple(cells)
        elif len(cells) in (width, width - 1, width + 1) or header is None:
            header, units = tuple(cells), None
        first = number + 1
    if header is None:
        header = _commented_header(kept, first, separator, width)
    return Dialect(encoding, separator, decimal, header, units, first, width, words)


def _words(lines: list[str], separator: str, decimal: str, width: int) -> frozenset[int]:
    """Places of the columns in which most cells are neither numbers nor missing."""
    rows = [row for row in (split(line, separator) for line in lines) if len(row) == width]
    counts = [sum(_is_word(cell, decimal) for cell in cells) for cells in zip(*rows, strict=True)]
    return frozenset(place for place, count in enumerate(counts) if 2 * count > len(rows))


def _is_word(cell: str, decimal: str) -> bool:
    return cell.lower() not in MISSING and not is_number(cell, decimal)


def _names_columns(cells: list[str], decimal: str, words: frozenset[int]) -> bool:
    """Whether a line with numbers in it (`t,1,2`) is a header all the same: with words where the data have numbers."""
    return any(_is_word(cell, decimal) and place not in words for place, cell in enumerate(cells))


def _looks_like_units(cells: list[str]) -> bool:
    return all(re.fullmatch(r"[\[(]?[A-Za-zµ°/*^.\-\d²%]{0,10}[\])]?", cell) for cell in cells)


def _commented_header(kept: list[tuple[int, str]], first: int, separator: str, width: int) -> tuple[str, ...] | None:
    """Names in the comment line just above the data (`# t q1 q2`), as numpy.savetxt writes them."""
    before = [line for number, line in kept if number < first and is_comment(line)]
    if not before:
        return None
    cells = split(before[-1].lstrip(" #%/\t"), separator)
    if len(cells) != width or any(is_number(cell, ".") for cell in cells):
        return None
    return tuple(cells)
