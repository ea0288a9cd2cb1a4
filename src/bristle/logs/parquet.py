"""Logs in Parquet, the table of data frames and of data lakes."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, table_of_series
from bristle.logs.words import distinct

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read(data: bytes, request: Request) -> Table:
    """Return the columns of a Parquet file; time stamps become seconds from the first one."""
    import pyarrow.parquet
    from pyarrow import types

    file = pyarrow.parquet.ParquetFile(io.BytesIO(data))
    names, notes = distinct(file.schema_arrow.names)
    # Columns of one name can only be read together.
    selection = None if notes else [name for name in names if request.choice(name)]
    count = len(names if selection is None else selection)
    refuse_larger(file.metadata.num_rows * NUMBER_BYTES * count, request.limit, request.source)
    content = file.read(columns=selection, use_threads=False)
    columns = dict(zip(names if selection is None else content.schema.names, content.columns, strict=True))
    series = []
    for name, part in zip(names, file.schema_arrow, strict=True):
        may_be_numbers = types.is_primitive(part.type) or types.is_decimal(part.type)
        values = _numbers(columns[name]) if may_be_numbers and request.choice(name) else None
        if request.choice(name) and values is None:
            notes.append(f"column {name!r} holds no numbers and was left out")
        elif may_be_numbers:
            metadata, is_time = part.metadata or {}, types.is_timestamp(part.type) or types.is_time(part.type)
            unit = next((metadata[key].decode("utf-8", "replace") for key in (b"unit", b"units") if key in metadata), "")
            series.append(Series(name, values, unit=unit or ("s" if is_time else "")))
    return table_of_series(series, request, "Parquet", notes=notes)


def _numbers(column: Any) -> np.ndarray | None:
    """Return a column as numbers, a missing one as NaN; None where it holds something else."""
    import pyarrow

    if pyarrow.types.is_time(column.type):
        counts = column.cast(pyarrow.int32() if pyarrow.types.is_time32(column.type) else pyarrow.int64())
        return counts.to_numpy().astype(float) * SECONDS[column.type.unit]
    values = (column.cast(pyarrow.float64()) if pyarrow.types.is_decimal(column.type) else column).to_numpy()
    if values.dtype.kind == "M":
        return (values - values[:1]) / np.timedelta64(1, "s")
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "s")
    if values.dtype == object:
        # Whole numbers and truth values with gaps arrive as objects.
        if not (pyarrow.types.is_integer(column.type) or pyarrow.types.is_boolean(column.type)):
            return None
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return values.astype(float) if values.dtype.kind in "fiub" else None
