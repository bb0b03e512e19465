"""MATLAB v4 to v7 (not v7.3, which is HDF5): variables by name, fields of structures after a dot."""

import struct
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from chebid.formats.limits import check_size
from chebid.formats.table import Table, as_columns

_DEPTH = 8
_COMPRESSED = 15  # the type number of a deflated element


def read(path: Path, shown: str) -> Table:
    """Every numeric variable, `rec.q` for the field q of the structure rec; not function handles and objects."""
    check_size(sum(_sizes(path)), shown)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about variables of one name: the last one counts, as in MATLAB
        content = loadmat(str(path), struct_as_record=False, squeeze_me=False, chars_as_strings=False)
    arrays: dict[str, NDArray[np.float64]] = {}
    for name, value in content.items():
        if isinstance(name, str) and not name.startswith("__"):
            _collect(name, value, arrays, _DEPTH)
    return Table(path, shown, "mat", arrays)


def _collect(name: str, value: Any, found: dict[str, NDArray[np.float64]], depth: int) -> None:
    """The columns of one variable, or of the fields of a structure."""
    if isinstance(value, np.ndarray) and value.dtype == object and value.size == 1:
        value = value.reshape(-1)[0]
    if hasattr(value, "_fieldnames"):
        for key in value._fieldnames if depth > 0 else ():
            _collect(f"{name}.{key}", getattr(value, key), found, depth - 1)
    elif isinstance(value, np.ndarray):
        columns = as_columns(value)
        if columns is not None:
            found[name] = columns


def _sizes(path: Path) -> Iterator[int]:
    """Bytes of each variable once inflated, as its own first tag declares them (v5 files; nothing for v4)."""
    with path.open("rb") as file:
        header = file.read(128)
        order = {b"IM": "<", b"MI": ">"}.get(header[126:128])
        while order and len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(order + "II", tag)
            body = file.tell()
            if kind == _COMPRESSED:
                inner = zlib.decompressobj().decompress(file.read(min(size, 512)), 8)
                yield struct.unpack(order + "II", inner)[1] if len(inner) == 8 else 0
            else:
                yield size
            file.seek(body + size)
