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
    arrays: dict[str, NDArray[np.float64]] = {}
    text: dict[str, TextCells] = {}
    with pq.ParquetFile(path) as file:
        count = file.metadata.num_rows
        check_size(count * file.metadata.num_columns * 8, shown)
        for field in file.schema_arrow:
            if pa.types.is_string(field.type) or pa.types.is_large_string(field.type):
                arrays[field.name] = np.full(count, np.nan)
                text[field.name] = TextCells(count, 1, _first(file, field.name))
            elif _is_numeric(field.type) and not field.name.startswith("__index_level_"):
                arrays[field.name] = _numbers(file.read(columns=[field.name]).column(0))
    return Table(path, shown, "parquet", arrays, text=text)


def _first(file: pq.ParquetFile, name: str) -> str:
    batch = next(file.iter_batches(batch_size=1, columns=[name]), None)
    return str(batch.column(0)[0]) if batch is not None and batch.num_rows else ""


def _is_numeric(kind: pa.DataType) -> bool:
    types = pa.types
    tests = (types.is_floating, types.is_integer, types.is_decimal, types.is_timestamp, types.is_duration)
    return any(test(kind) for test in tests)


def _numbers(column: pa.ChunkedArray) -> NDArray[np.float64]:
    """The column as float64; stamps of the calendar as seconds from the first."""
    kind = column.type
    if not (pa.types.is_timestamp(kind) or pa.types.is_duration(kind)):
        return _numpy(column.cast(pa.float64(), safe=False))
    ticks = column.cast(pa.int64())
    first = next((tick.as_py() for tick in ticks if tick.is_valid), 0)
    values = pa.compute.subtract(ticks, first).cast(pa.float64(), safe=False)
    return _numpy(values) / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[kind.unit]


def _numpy(column: pa.ChunkedArray) -> NDArray[np.float64]:
    return np.array(column.to_numpy(zero_copy_only=False), dtype=np.float64)
