"""How much a file may ask for before it is refused."""

from chebid.errors import InputError, Place

NUMBERS = 2 * 2**30  # bytes of numbers: some 2.7e8 of them, far beyond a robot log
TEXT = 4 * 2**30  # bytes of text once unpacked
LINE = 2**20  # bytes of one line of text
RATIO = 100  # times the packed size that text may unpack to, beyond the first
BULK = 2**28  # bytes


def check_size(count: int, shown: str, *, limit: int = NUMBERS) -> None:
    """Raise InputError when `count` bytes of numbers are more than a log may hold."""
    if count > limit:
        message = f"holds more than the {limit // 2**30} GiB that are read at once"
        raise _too_much(message, shown)


def check_text(count: int, packed: int | None, cells: int, shown: str) -> None:
    """Raise InputError for too much text: `count` bytes and `cells` so far, unpacked from `packed` bytes if at all."""
    check_size(count, shown, limit=TEXT)
    check_size(8 * cells, shown)
    if packed is not None and count > BULK and count > RATIO * packed:
        message = f"unpacks to more than {RATIO} times its size, and more than {BULK // 2**20} MiB"
        hint = "if it is sound, unpack it first and give the unpacked file"
        raise InputError(message, hint=hint, place=Place(file=shown))


def _too_much(message: str, shown: str) -> InputError:
    hint = "cut the log into shorter ones, or keep only the columns that are needed"
    return InputError(message, hint=hint, place=Place(file=shown))
