"""The bytes and the lines of a text file, plain or gzipped, watched while they pass: bounded, and text throughout."""

import gzip
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from chebid.errors import InputError, Place
from chebid.formats.dialect import is_binary
from chebid.formats.limits import LINE, check_text

BLOCK = 2**20
_BLANK = 2**16  # bytes in a row without any content that no table has


def open_text(path: Path) -> Any:
    """The file as bytes, unpacked when its first two bytes say gzip."""
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    return gzip.open(path, "rb") if packed else path.open("rb")


def sniff(path: Path, shown: str) -> bytes:
    """The first megabyte. Raises InputError when it is blank."""
    with open_text(path) as file:
        head: bytes = file.read(BLOCK)
    if not head.strip(b" \t\r\n\x00,;"):
        size = "the first MiB" if len(head) == BLOCK else "the file"
        raise InputError(f"{size} is blank", hint="record or export the log again", place=Place(file=shown))
    return head


class Guard(io.RawIOBase):
    """Passes on the bytes of `file`, counts its lines, and finds what is no text, or too much.

    What it finds ends the file, and `check` raises it afterwards: an exception inside a thread of pyarrow, which
    reads through this, can block it for good.
    `path` is the file on disk, `width` the number of columns; `wide` text has two bytes per character.
    """

    def __init__(self, path: Path, file: Any, shown: str, width: int, *, wide: bool = False) -> None:
        self.file, self.shown, self.width, self.wide = file, shown, width, wide
        self.packed = path.stat().st_size if isinstance(file, gzip.GzipFile) else None
        self.total, self.newlines, self.since, self.last = 0, 0, 0, b""
        self.fault: Exception | None = None

    def readable(self) -> bool:
        """Always."""
        return True

    def read(self, size: int = -1) -> bytes:
        """The next `size` bytes, as pyarrow asks for them."""
        if self.fault is not None:
            return b""
        try:
            block: bytes = self.file.read(size if size > 0 else BLOCK)
            self._watch(block)
        except Exception as err:
            self.fault = err
            return b""
        return block

    def check(self) -> None:
        """Raise what was found while the bytes passed."""
        if self.fault is not None:
            raise self.fault

    def readinto(self, buffer: Any) -> int:
        """The next bytes, as Python's own decoding asks for them."""
        block = self.read(len(buffer))
        buffer[: len(block)] = block
        return len(block)

    @property
    def lines(self) -> int:
        """Lines that have passed, the last one whether it was ended or not."""
        return self.newlines + (self.last not in (b"\n", b"\r", b""))

    def _watch(self, block: bytes) -> None:
        self.total += len(block)
        check_text(self.total, self.packed, self.newlines * self.width, self.shown)
        if not self.wide and block and np.frombuffer(block, np.uint8).min() < 9 and is_binary(block):
            hint = "the recording was cut off: copy the file again, or remove the damaged end"
            raise self._error(f"turns binary after line {self.newlines + 1}", hint, self.newlines + 1)
        if len(block) >= _BLANK and block.isspace():
            hint = "the recording was cut off: remove the blank end of the file"
            raise self._error(f"nothing but blanks after line {self.newlines + 1}", hint, self.newlines + 1)
        count = block.count(b"\n") or block.count(b"\r")
        self.since = len(block) - max(block.rfind(b"\n"), block.rfind(b"\r")) if count else self.since + len(block)
        if self.since > LINE:
            hint = "is it a text table? Export the log as CSV, one sample per line"
            line = self.newlines + count + 1
            raise self._error(f"line {line} is longer than {LINE} bytes", hint, line)
        self.newlines += count
        self.last = block[-1:] or self.last

    def _error(self, message: str, hint: str, row: int) -> InputError:
        return InputError(message, hint=hint, place=Place(file=self.shown, row=row))


def text_lines(path: Path, shown: str, encoding: str, width: int) -> Iterator[tuple[int, str]]:
    """The lines that hold something, with their numbers from 1 and without their ends."""
    with open_text(path) as file:
        raw: Any = Guard(path, file, shown, width, wide=encoding.startswith("utf-16"))
        buffered = io.BufferedReader(raw, BLOCK)
        for number, line in enumerate(io.TextIOWrapper(buffered, encoding=encoding, errors="replace", newline=None), 1):
            if line.strip():
                yield number, line.rstrip("\n")
        raw.check()
