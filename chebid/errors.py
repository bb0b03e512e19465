"""Everything chebid says when something is wrong: where, what, and what to do.

An error stops the command: one ``error:`` line, one ``hint:`` line and the exit status of its class.
A `Notice` does not stop anything: it is a warning that travels with the result it concerns.
"""

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Place:
    """Where in the user's files: any of file, column (of a log), key (of a model file), row, value.

    `row` counts as a person does in an editor or spreadsheet: the first data row of a table with a header line is
    row 2; in a binary file it is the sample number, from 1. `row_end`, when given, closes a range of rows.
    """

    file: str | None = None
    column: str | None = None
    key: str | None = None
    row: int | None = None
    row_end: int | None = None
    value: object = None

    def __str__(self) -> str:
        rows = None
        if self.row is not None:
            more = self.row_end is not None and self.row_end != self.row
            rows = f"rows {self.row}-{self.row_end}" if more else f"row {self.row}"
        parts = [
            self.file,
            f"column '{self.column}'" if self.column is not None else None,
            f"key '{self.key}'" if self.key is not None else None,
            rows,
            f"value {self.value!r}" if self.value is not None else None,
        ]
        return ", ".join(part for part in parts if part)


class ChebidError(Exception):
    """Base of all errors raised on purpose. `place` says where, `hint` what to do next."""

    status: ClassVar[int] = 1

    def __init__(self, message: str, *, hint: str, place: Place | None = None) -> None:
        self.message = message
        self.hint = hint
        self.place = place or Place()
        super().__init__(message)

    def __str__(self) -> str:
        where = str(self.place)
        return f"{where}: {self.message}" if where else self.message


class NoAnswerError(ChebidError):
    """The numbers do not allow an answer: rank loss, no convergence, nothing left after the gate."""

    status = 1


class UsageError(ChebidError):
    """The command line asks for something that does not exist or does not fit together."""

    status = 2


class InputError(ChebidError):
    """A log or a model file cannot be used as it is."""

    status = 3


@dataclass(frozen=True)
class Notice:
    """A warning that travels with a result. `kind` is a stable word for programs and tests."""

    kind: str
    message: str
    place: Place = Place()

    def __str__(self) -> str:
        where = str(self.place)
        return f"{where}: {self.message}" if where else self.message
