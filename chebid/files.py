"""Writing results: a file appears whole or not at all, replaces another only when asked to, and never an input."""

import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

from chebid.errors import Place, UsageError


def write_with(path: str | Path, write: Callable[[Path], object], *, force: bool = False) -> None:
    """Call `write` with a path beside `path`, of the same suffix, then rename.

    Raises UsageError if `path` exists (unless `force`), is a folder or device, or cannot be written.
    """
    path = Path(path)
    refuse_existing(path, force)
    beside = None
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".chebid-", suffix="".join(path.suffixes[-2:]))
        os.close(handle)
        beside = Path(name)
        write(beside)
        os.chmod(beside, 0o666 & ~_umask())
        os.replace(beside, path)
    except OSError as err:
        raise UsageError(
            f"cannot be written: {err.strerror or err}",
            hint="check that the folder exists, is writable and has room",
            place=Place(str(path)),
        ) from None
    finally:
        if beside is not None:
            beside.unlink(missing_ok=True)


def refuse_existing(path: str | Path, force: bool) -> None:
    """Raise UsageError when `path` exists and `force` is not set, or is no regular file."""
    where = Place(str(path))
    if os.path.isdir(path):
        raise UsageError("is a folder", hint="name a file in it", place=where)
    if os.path.exists(path) and not os.path.isfile(path):
        raise UsageError("is a device, not a file", hint="leave it out to print on stdout", place=where)
    if os.path.exists(path) and not force:
        raise UsageError("exists already", hint="choose another name, or replace it with --force", place=where)


def check_outputs(outputs: Iterable[Path], inputs: Iterable[Path], force: bool) -> None:
    """Before any work: raise UsageError for an output that could not be written, is named twice, or is an input."""
    seen: list[Path] = []
    for path in outputs:
        where = Place(str(path))
        if any(_same(path, other) for other in inputs):
            raise UsageError("is an input: it would be lost", hint="name another file for the result", place=where)
        if any(_same(path, other) for other in seen):
            raise UsageError("is named for two results", hint="give each its own file", place=where)
        refuse_existing(path, force)
        if not os.path.isdir(path.parent):
            raise UsageError("cannot be written: there is no such folder", hint="make the folder first", place=where)
        seen.append(path)


def _same(one: Path, other: Path) -> bool:
    """Whether two paths are one file, by whatever names."""
    if os.path.exists(one) and os.path.exists(other):
        return os.path.samefile(one, other)
    return os.path.realpath(one) == os.path.realpath(other)


def write_text(path: str | Path, text: str, *, force: bool = False) -> None:
    """Write UTF-8 text, whole or not at all."""
    write_with(path, lambda beside: beside.write_text(text, encoding="utf-8"), force=force)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
