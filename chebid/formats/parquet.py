"""Parquet: one column each; time stamps of the calendar become seconds from the first one."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq
from numpy.typing import NDArray

from chebid.formats.limits import check_size
from chebid.formats.table import Table, TextCells


def read(path: Path, shown: str) -> Table:
    """Every column of numbers; null is missing. Columns of text are kept in name, to say so when they are asked for."""
    with pq.ParquetFile(path) as file:
        check_size(file.metadata.num_rows * file.metadata.num_columns * 8, shown)
        data = file.read()
    arrays: dict[str, NDArray[np.float64]] = {}
    text: dict[str, TextCells] = {}
    for name, column in zip(data.column_names, data.columns, strict=True):
        if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
            arrays[name] = np.full(len(column), np.nan)
            text[name] = TextCells(len(column), 1, str(column[0]) if len(column) else "")
        else:
            values = _numbers(column)
            if values is not None and not name.startswith("__index_level_"):
                arrays[name] = values
    return Table(path, shown, "parquet", arrays, text=text)


def _numbers(column: pa.ChunkedArray) -> NDArray[np.float64] | None:
    """The column as float64, None when it is of another kind."""
    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        ticks = column.cast(pa.int64())
        first = next((tick.as_py() for tick in ticks if tick.is_valid), 0)
        values = pa.compute.subtract(ticks, first).cast(pa.float64(), safe=False)
        return _numpy(values) / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[kind.unit]
    if pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind):
        return _numpy(column.cast(pa.float64(), safe=False))
    return None


def _numpy(column: pa.ChunkedArray) -> NDArray[np.float64]:
    return np.array(column.to_numpy(zero_copy_only=False), dtype=np.float64)
