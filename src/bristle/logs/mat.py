"""Logs that MATLAB saved, version 5 to 7.2."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Table

__all__ = ["read_mat"]

HEADER_BYTES, TAG_BYTES = 128, 8


def read_mat(data: bytes, source: Path) -> Table:
    """Return the columns of a MAT file; fields of structures are named ``structure.field``.

    Raises
    ------
    InputError
        If the file is truncated or damaged, or holds no column of numbers.
    """
    if data.startswith(b"MATLAB 5.0"):
        _refuse_truncated(data, source)
    import scipy.io

    try:
        content = scipy.io.loadmat(io.BytesIO(data), simplify_cells=True)
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        raise InputError(
            f"is truncated or damaged, or no MAT file ({error})",
            path=str(source),
            mend="Copy or save it again",
        ) from None
    columns: dict[str, np.ndarray] = {}
    constants: dict[str, float] = {}
    notes: list[str] = []
    for name, value in content.items():
        for full, values in _numbers(name, value) if not name.startswith("__") else ():
            if values.size == 1:
                constants[full] = float(values.reshape(()))
            elif values.ndim == 1 or 1 in values.shape:
                columns[full] = values.reshape(-1).astype(float)
            elif values.ndim == 2:
                columns |= _columns_of(full, values)
            else:
                notes.append(f"{full} has {values.ndim} dimensions and was left out")
    if not columns:
        raise InputError("holds no column of numbers", path=str(source), mend="Save the signals as vectors")
    return Table(columns, constants=constants, notes=tuple(notes), format="MAT")


def _refuse_truncated(data: bytes, source: Path) -> None:
    """Walk over the elements of the file, each of which says its length: the last must end with the file."""
    order = "little" if data[126:128] == b"IM" else "big"
    at = HEADER_BYTES
    while at < len(data):
        tag = data[at : at + TAG_BYTES]
        at += TAG_BYTES + int.from_bytes(tag[4:], order)
    if at != len(data) or at == HEADER_BYTES:
        raise InputError(
            f"is truncated: {len(data)} bytes, and its content announces {max(at, HEADER_BYTES + TAG_BYTES)}",
            path=str(source),
            mend="Copy or save it again",
        )


def _numbers(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Yield every real array in a variable, structures and cells included, with its full name."""
    if isinstance(value, dict):
        for field, inner in value.items():
            yield from _numbers(f"{name}.{field}", inner)
        return
    if isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _numbers(f"{name}[{index}]", inner)
        return
    values = np.asarray(value)
    if values.dtype.kind in "fiub" and values.size:
        yield name, values
    elif values.dtype == object and values.ndim == 1:
        yield from _numbers(name, values.tolist())


def _columns_of(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Return the columns of a matrix; time runs along its longer side."""
    tall = values if values.shape[0] >= values.shape[1] else values.T
    return {f"{name}[{index}]": np.ascontiguousarray(column, float) for index, column in enumerate(tall.T)}
