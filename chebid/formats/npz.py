"""NPZ: a zip of numpy arrays, read without pickle and never larger than its directory says."""

import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from chebid.errors import InputError, Place
from chebid.formats.limits import check_size
from chebid.formats.table import Table, as_columns


def read(path: Path, shown: str) -> Table:
    """Every numeric array of the archive. Raises InputError for objects (pickles), bombs and damage."""
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
        if not members:
            raise InputError("is a zip without numpy arrays", hint="write it with numpy.savez", place=Place(file=shown))
        check_size(sum(info.file_size for info in members), shown)
        for info in members:
            values = _member(archive, info, shown)
            columns = as_columns(values)
            if columns is not None:
                arrays[info.filename.removesuffix(".npy")] = columns
    return Table(path, shown, "npz", arrays)


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo, shown: str) -> NDArray:
    """One array, its header checked against the size in the zip directory before anything is allocated."""
    name = info.filename.removesuffix(".npy")
    with archive.open(info) as file:
        shape, _, dtype = _header(file)
    if dtype.hasobject:
        raise InputError(
            "holds Python objects, which are not loaded",
            hint="save plain numbers: numpy.savez with float arrays",
            place=Place(file=shown, column=name),
        )
    count = 1
    for side in shape:
        count *= int(side)
    if count * dtype.itemsize > info.file_size:
        raise InputError(
            f"the array of shape {shape} is cut short",
            hint="check that the file is whole: copy or export it again",
            place=Place(file=shown, column=name),
        )
    with archive.open(info) as file:
        return np.asarray(npy.read_array(file, allow_pickle=False))


def _header(file) -> tuple[tuple[int, ...], bool, np.dtype]:  # type: ignore[no-untyped-def]
    version = npy.read_magic(file)
    if version == (1, 0):
        return npy.read_array_header_1_0(file)
    return npy.read_array_header_2_0(file)
