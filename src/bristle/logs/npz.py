"""Logs that NumPy saved: NPZ archives of named arrays, and single arrays (NPY)."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Table
from bristle.logs.tables import Arrays, table_from

__all__ = ["ARRAY", "holds_arrays", "read_npz"]

ARRAY = b"\x93NUMPY"


def holds_arrays(data: bytes) -> bool:
    """Return whether an archive is one of arrays: each of its files is named so, the first one at its very start."""
    return b".npy" in data[26:4096]


def read_npz(data: bytes, source: Path, table: str | None = None) -> Table:
    """Return the columns of an array with several of them, or of an archive of single columns.

    Parameters
    ----------
    data : bytes
        Content of the file.
    source : Path
        The file.
    table : str, optional
        Name of the array whose columns are taken; where not given, all columns are named ``array/column``, unless there
        is one array only. Columns without a name are ``column_1`` and so on.

    Raises
    ------
    InputError
        If the file is truncated or damaged, or holds no such array.
    """
    values: dict[str, np.ndarray] = {}
    notes: list[str] = []
    try:
        found = np.load(io.BytesIO(data), allow_pickle=False)
        if isinstance(found, np.ndarray):
            found = {source.stem: found}
        for name in found:
            one = np.asarray(found[name])
            if one.dtype.kind not in "fiubV" or one.ndim > 2 or not one.size:
                notes.append(f"{name} holds no column of numbers and was left out")
            else:
                values[name] = one
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        raise InputError(
            f"is truncated or damaged, or holds objects of Python ({error})",
            path=str(source),
            mend="Copy it again, or save arrays of numbers",
        ) from None
    return table_from(Arrays(values, notes=tuple(notes)), table, source, "NPZ")
