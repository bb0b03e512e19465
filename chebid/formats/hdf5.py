"""HDF5 and MATLAB v7.3: datasets by their path, groups as dots. Nothing outside the file is ever opened."""

from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from chebid.formats.limits import check_size
from chebid.formats.table import Table, as_columns

_DEPTH = 8


def read(path: Path, shown: str) -> Table:
    """Every numeric dataset, `group/name` as `group.name`. MATLAB's are turned to MATLAB's own shape.

    Soft and external links, external storage and virtual datasets are left alone: they can point out of the file.
    """
    arrays: dict[str, NDArray[np.float64]] = {}
    with h5py.File(path, "r") as file:
        datasets: dict[str, h5py.Dataset] = {}
        _collect(file, "", datasets, _DEPTH, set())
        check_size(sum(_bytes(item) for item in datasets.values()), shown)
        for name, item in datasets.items():
            matlab = "MATLAB_class" in item.attrs
            values = as_columns(np.asarray(item[()]).T if matlab else np.asarray(item[()]))
            if values is not None:
                arrays[name] = values
    return Table(path, shown, "hdf5", arrays)


def _collect(group: h5py.Group, prefix: str, found: dict[str, h5py.Dataset], depth: int, seen: set[int]) -> None:
    """Datasets below `group`, through hard links only, each group once."""
    for key in group:
        if key.startswith("#") or not isinstance(group.get(key, getlink=True), h5py.HardLink):
            continue  # '#refs#' and the like are MATLAB's own
        item = group[key]
        if isinstance(item, h5py.Dataset) and _plain(item):
            found[prefix + key] = item
        elif isinstance(item, h5py.Group) and depth > 0:
            address = h5py.h5o.get_info(item.id).addr
            if address not in seen:
                _collect(item, f"{prefix}{key}.", found, depth - 1, seen | {address})


def _plain(item: h5py.Dataset) -> bool:
    """Numbers of one or two sides that are stored in this very file."""
    if item.shape is None or item.ndim not in (1, 2) or item.dtype.kind not in "fiu":
        return False
    if item.attrs.get("MATLAB_class") in (b"char", "char"):
        return False
    return not item.is_virtual and item.id.get_create_plist().get_external_count() == 0


def _bytes(item: h5py.Dataset) -> int:
    return int(item.size) * max(item.dtype.itemsize, 8)
