"""Writing results: a file appears whole or not at all, and replaces another only when asked to."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from chebid.errors import InputError, Place, UsageError


def write_with(path: str | Path, write: Callable[[Path], object], *, force: bool = False) -> None:
    """Call `write` with a path beside `path`, of the same suffix, then rename. Raises UsageError if `path` exists."""
    path = Path(path)
    refuse_existing(path, force)
    try:
        handle, beside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix="".join(path.suffixes[-2:]))
        os.close(handle)
    except OSError as err:
        raise InputError(
            f"cannot be written: {err.strerror}",
            hint="check that the folder exists and is writable",
            place=Place(str(path)),
        ) from None
    try:
        write(Path(beside))
        os.chmod(beside, 0o666 & ~_umask())
        os.replace(beside, path)
    finally:
        Path(beside).unlink(missing_ok=True)


def refuse_existing(path: str | Path, force: bool) -> None:
    """Raise UsageError when `path` exists and `force` is not set, or is a folder."""
    path = Path(path)
    if path.is_dir():
        raise UsageError("is a folder", hint="name a file in it", place=Place(str(path)))
    if path.exists() and not force:
        raise UsageError(
            "exists already", hint="choose another name, or replace it with --force", place=Place(str(path))
        )


def write_text(path: str | Path, text: str, *, force: bool = False) -> None:
    """Write UTF-8 text, whole or not at all."""
    write_with(path, lambda beside: beside.write_text(text, encoding="utf-8"), force=force)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
