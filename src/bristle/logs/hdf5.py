"""Logs in HDF5, those that MATLAB saves as version 7.3 among them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError, MissingExtraError
from bristle.logs.table import Table
from bristle.logs.tables import Arrays, table_from

__all__ = ["MAT_73", "read_hdf5"]

MAT_73 = b"MATLAB 7.3"
UNIT_ATTRIBUTES = ("unit", "units")


def read_hdf5(data: bytes, source: Path, table: str | None = None) -> Table:
    """Return the columns of a group, or of a matrix, of an HDF5 file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    source : Path
        The file.
    table : str, optional
        Name of the group or matrix; where not given, all columns are named ``group/column`` (``structure.field`` in
        a file of MATLAB), unless there is one group only.

    Raises
    ------
    MissingExtraError
        If the reader of HDF5 files is not installed.
    InputError
        If the file is truncated or damaged, or holds no such table.
    """
    try:
        import h5py
    except ImportError:
        raise MissingExtraError.of(f"{source}: reading HDF5", "io") from None
    separator = "." if data.startswith(MAT_73) else "/"
    values: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    notes: list[str] = []

    def visit(name: str, one: Any) -> None:
        if not isinstance(one, h5py.Dataset) or name.startswith("#"):
            return
        name = name.replace("/", separator)
        if one.dtype.kind not in "fiubV" or one.ndim > 2 or not one.size or _is_text(one):
            notes.append(f"{name} holds no column of numbers and was left out")
            return
        values[name] = np.asarray(one[()])
        if unit := next((text for key in UNIT_ATTRIBUTES if (text := _text(one.attrs.get(key)))), ""):
            units[name] = unit

    try:
        with h5py.File(io.BytesIO(data), "r") as content:
            content.visititems(visit)
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        raise InputError(
            f"is truncated or damaged, or no HDF5 file ({error})", path=str(source), mend="Copy or save it again"
        ) from None
    return table_from(Arrays(values, units, separator, tuple(notes)), table, source, "HDF5")


def _is_text(one: Any) -> bool:
    return _text(one.attrs.get("MATLAB_class")) in ("char", "cell", "function_handle")


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else value if isinstance(value, str) else ""
