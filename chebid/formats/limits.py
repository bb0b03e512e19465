"""How much a file may ask for before it is refused."""

from chebid.errors import InputError, Place

BYTES = 4 * 2**30  # of numbers, or of text once unpacked: some 5e8 cells, far beyond a robot log
LINE = 2**20  # bytes of one line of text


def check_size(count: int, shown: str, column: str | None = None) -> None:
    """Raise InputError when `count` bytes are more than a log may hold."""
    if count > BYTES:
        raise InputError(
            f"holds {count / 2**30:.1f} GiB once unpacked, more than the {BYTES // 2**30} GiB that are read at once",
            hint="cut the log into shorter ones, or keep only the columns that are needed",
            place=Place(file=shown, column=column),
        )
