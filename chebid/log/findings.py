"""Collects the notices of one log, each with its place in the file."""

from dataclasses import dataclass, field

from chebid.errors import InputError, Notice, Place


@dataclass
class Findings:
    """The notices found so far in the file called `shown`."""

    shown: str
    notices: list[Notice] = field(default_factory=list)

    def note(
        self,
        kind: str,
        message: str,
        *,
        column: str | None = None,
        row: int | None = None,
        row_end: int | None = None,
        value: object = None,
    ) -> None:
        """Add a notice of the stable word `kind`."""
        self.notices.append(Notice(kind, message, self.place(column, row, value, row_end)))

    def error(
        self, message: str, hint: str, *, column: str | None = None, row: int | None = None, value: object = None
    ) -> InputError:
        """An InputError at a place of this file, to be raised by the caller."""
        return InputError(message, hint=hint, place=self.place(column, row, value))

    def place(self, column: str | None, row: int | None, value: object, row_end: int | None = None) -> Place:
        """A place in this file; numpy scalars become plain numbers, so that they print as such."""
        plain = value.item() if hasattr(value, "item") else value
        row = None if row is None else int(row)
        row_end = None if row_end is None else int(row_end)
        return Place(file=self.shown, column=column, row=row, row_end=row_end, value=plain)


def several(rows: list[int], most: int = 5) -> str:
    """`rows 3, 8, 11 and 4 more` for a message."""
    shown = ", ".join(str(row) for row in rows[:most])
    more = f" and {len(rows) - most} more" if len(rows) > most else ""
    return f"row{'s' if len(rows) > 1 else ''} {shown}{more}"
