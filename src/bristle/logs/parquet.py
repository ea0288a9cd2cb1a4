"""Logs in Parquet, the table of data frames and of data lakes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError, MissingExtraError
from bristle.logs.table import Table

__all__ = ["read_parquet"]

UNIT_KEYS = (b"unit", b"units")


def read_parquet(data: bytes, source: Path, table: str | None = None) -> Table:
    """Return the columns of a Parquet file; time stamps become seconds from the first one.

    Parameters
    ----------
    data : bytes
        Content of the file.
    source : Path
        The file.
    table : str, optional
        Not used: such a file is one table.

    Raises
    ------
    MissingExtraError
        If the reader of Parquet files is not installed.
    InputError
        If the file is truncated or damaged, or holds no column of numbers.
    """
    try:
        import pyarrow.parquet
    except ImportError:
        raise MissingExtraError.of(f"{source}: reading Parquet", "io") from None
    try:
        content = pyarrow.parquet.read_table(io.BytesIO(data))
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        raise InputError(
            f"is truncated or damaged ({error})", path=str(source), mend="Copy or export it again"
        ) from None
    columns, units, notes = {}, {}, []
    for part in content.schema:
        values = _numbers(content.column(part.name))
        if values is None:
            notes.append(f"column {part.name!r} holds no numbers and was left out")
            continue
        columns[part.name] = values
        metadata = part.metadata or {}
        if unit := next((metadata[key].decode() for key in UNIT_KEYS if key in metadata), ""):
            units[part.name] = unit
        elif pyarrow.types.is_timestamp(part.type):
            units[part.name] = "s"
    if not columns:
        raise InputError("holds no column of numbers", path=str(source))
    return Table(columns, units, notes=tuple(notes), format="Parquet")


def _numbers(column: Any) -> np.ndarray | None:
    """Return a column as numbers, a missing one as NaN; None where it holds something else."""
    values = column.to_numpy()
    if values.dtype.kind == "M":
        return (values - values[:1]) / np.timedelta64(1, "s")
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "s")
    if values.dtype == object:
        # Whole numbers and truth values with gaps arrive as objects.
        import pyarrow

        if not (pyarrow.types.is_integer(column.type) or pyarrow.types.is_boolean(column.type)):
            return None
        return np.array([np.nan if one is None else one for one in values], dtype=float)
    return values.astype(float) if values.dtype.kind in "fiub" else None
