"""Logs that NumPy saved: NPZ archives of named arrays, and single arrays (NPY)."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError, said_by_library
from bristle.logs.table import Request, Table
from bristle.logs.tables import Arrays, Stored, table_from
from bristle.logs.words import distinct

__all__ = ["read"]

ARRAY = b"\x93NUMPY"
HEADER = 10_000  # [byte] at most, before the numbers of an array
MOST_ARRAYS = 100_000


def read(data: bytes, request: Request) -> Table:
    """Return the columns of an array with several of them, or of an archive of single columns."""
    try:
        if data.startswith(ARRAY):
            arrays = {request.source.stem: _stored(lambda: io.BytesIO(data), len(data), request.source)}
            return table_from(_columns_in(arrays, []), request, "NPZ")
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            arrays, notes = _members(archive, request.source, request.limit)
            return table_from(_columns_in(arrays, notes), request, "NPZ")
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"is truncated or damaged{said_by_library(error)}", path=str(request.source), mend="Copy it again, or save arrays of numbers"
        ) from None


def _members(archive: zipfile.ZipFile, source: Path, limit: int) -> tuple[dict[str, Stored], list[str]]:
    members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
    if len(members) > MOST_ARRAYS:
        raise InputError("holds too many arrays", path=str(source), value=len(members), allowed=f"up to {MOST_ARRAYS}")
    names, notes = distinct(member.filename.removesuffix(".npy") for member in members)
    arrays = {}
    for name, member in zip(names, members, strict=True):
        refuse_larger(member.file_size, limit, f"{source}: {name}")
        arrays[name] = _stored(lambda member=member: archive.open(member), member.file_size, source)
    return arrays, notes


def _columns_in(arrays: dict[str, Stored], notes: list[str]) -> Arrays:
    left_out = [name for name, array in arrays.items() if not array.holds_columns]
    remarks = [*notes, *(f"{name} holds no column of numbers and was left out" for name in left_out)]
    return Arrays({name: array for name, array in arrays.items() if array.holds_columns}, notes=tuple(remarks))


def _stored(opened: Callable[[], IO[bytes]], size: int, source: Path) -> Stored:
    """Return what the head of an array says of it; the numbers that it announces must be there."""
    with opened() as file:
        version = np.lib.format.read_magic(file)
        header: Any = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = header(file, max_header_size=HEADER)
    if dtype.hasobject:
        raise InputError("holds objects of Python, which are not read", path=str(source), mend="Save arrays of numbers")
    stored = Stored(tuple(shape), dtype, lambda: _array(opened))
    if stored.size * dtype.itemsize > size:
        raise ValueError(f"an array announces {stored.size} numbers and is shorter")
    return stored


def _array(opened: Callable[[], IO[bytes]]) -> np.ndarray:
    with opened() as file:
        return np.lib.format.read_array(file, allow_pickle=False)
