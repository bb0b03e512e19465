"""Files to columns: one reader per file format behind one door, `read_table`.

The format is told by the content where it has a signature and by the suffix where it has none. A `Table` holds what
the file holds, unit conversions and checks of the motion come later (`chebid.log`).
"""

import gzip
import zlib
from collections.abc import Callable
from pathlib import Path

from chebid.errors import ChebidError, InputError, Place
from chebid.formats.table import Table, TextCells, base_name, header_unit

__all__ = ["Table", "TextCells", "base_name", "header_unit", "read_table"]

READABLE = "CSV, TSV (also .gz), Parquet, MAT (v5, v7.3), NPZ, HDF5, ROS 1 and 2 bags, MCAP"
SUFFIXES = {
    ".csv": "text",
    ".tsv": "text",
    ".txt": "text",
    ".dat": "text",
    ".tab": "text",
    ".asc": "text",
    ".parquet": "parquet",
    ".pq": "parquet",
    ".mat": "mat",
    ".npz": "npz",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".hdf": "hdf5",
    ".he5": "hdf5",
    ".bag": "ros",
    ".db3": "ros",
    ".mcap": "ros",
}
SIGNATURES = (
    (b"\x89HDF\r\n\x1a\n", "hdf5"),
    (b"MATLAB 5.0 MAT-file", "mat"),
    (b"MATLAB 7.3 MAT-file", "hdf5"),
    (b"PAR1", "parquet"),
    (b"PK\x03\x04", "npz"),
    (b"PK\x05\x06", "npz"),
    (b"\x1f\x8b", "text"),
    (b"SQLite format 3", "ros"),
    (b"#ROSBAG", "ros"),
    (b"\x89MCAP", "ros"),
)


def read_table(path: str | Path, *, name: str | None = None) -> Table:
    """Read all columns of the file `path`; messages call it `name` (default: the path as given).

    Raises InputError, and nothing else, whatever the file holds.
    """
    path = Path(path)
    shown = name or str(path)
    kind = _kind(path, shown)
    try:
        return _reader(kind)(path, shown)
    except ChebidError:
        raise
    except MemoryError:
        raise InputError(
            "the file asks for more memory than there is",
            hint="check that the file is whole, or cut the log into shorter ones",
            place=Place(file=shown),
        ) from None
    except Exception as err:  # a parser's own exceptions are of any type; none of them may reach the user
        raise _unreadable(shown, kind, err) from err


def _reader(kind: str) -> Callable[[Path, str], Table]:
    """The reading function of one format; its library is imported only now."""
    if kind == "text":
        from chebid.formats.text import read
    elif kind == "parquet":
        from chebid.formats.parquet import read
    elif kind == "mat":
        from chebid.formats.mat import read
    elif kind == "npz":
        from chebid.formats.npz import read
    elif kind == "ros":
        from chebid.formats.ros import read
    else:
        from chebid.formats.hdf5 import read
    return read


def _kind(path: Path, shown: str) -> str:
    """Name of the format, by signature first, then by suffix."""
    head = _head(path, shown)
    kind = next((kind for mark, kind in SIGNATURES if head.startswith(mark)), None)
    if kind is None and head[512:520] == SIGNATURES[0][0]:
        kind = "hdf5"  # HDF5 behind a user block, as MATLAB v7.3 writes it
    suffix = _suffix(path)
    if kind is None and suffix not in SUFFIXES:
        raise InputError(
            f"unknown kind of file (suffix '{suffix}')",
            hint=f"a log is one of {READABLE}; rename a text file to .csv",
            place=Place(file=shown),
        )
    return kind or SUFFIXES[suffix]


def named_like_a_log(path: Path) -> bool:
    """Whether the suffix is that of a format."""
    return _suffix(path) in SUFFIXES


def _suffix(path: Path) -> str:
    """The suffix that tells the format, `.gz` looked through."""
    suffix = path.suffix.lower()
    return Path(path.stem).suffix.lower() if suffix == ".gz" else suffix


def _head(path: Path, shown: str) -> bytes:
    """The first kilobyte, with the errors of the file system put into words."""
    place = Place(file=shown)
    try:
        if path.is_dir():
            raise InputError("is a folder", hint="name the log file inside it", place=place)
        if path.exists() and not path.is_file():
            raise InputError("is not a regular file", hint="copy its content to a file first", place=place)
        with path.open("rb") as file:
            head = file.read(1024)
    except FileNotFoundError:
        raise InputError("no such file", hint=_similar(path), place=place) from None
    except PermissionError:
        raise InputError("permission denied", hint=f"make it readable: chmod u+r {shown}", place=place) from None
    except (OSError, ValueError) as err:
        raise InputError(f"cannot be opened: {err}", hint="check the path", place=place) from None
    if not head:
        raise InputError("the file is empty", hint="record or export the log again", place=place)
    return head


def _similar(path: Path) -> str:
    """A hint with files of a similar name beside `path`."""
    from difflib import get_close_matches

    folder = path.parent
    if not folder.is_dir():
        return f"there is no folder '{folder}'"
    names = [entry.name for entry in folder.iterdir() if named_like_a_log(entry)]
    close = get_close_matches(path.name, names, n=3, cutoff=0.5) or sorted(names)[:3]
    return f"did you mean {', '.join(close)}?" if close else f"there is no log in '{folder}'"


def _unreadable(shown: str, kind: str, err: Exception) -> InputError:
    """An exception of a format library as an InputError."""
    cause = " ".join(str(err).split())[:200] or type(err).__name__
    damaged = isinstance(err, EOFError | zlib.error | gzip.BadGzipFile)
    what = "is damaged or cut short" if damaged else f"cannot be read as {kind.upper()}"
    return InputError(
        f"{what}: {cause}", hint="check that the file is whole: copy or export it again", place=Place(file=shown)
    )
