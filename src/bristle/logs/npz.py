"""Logs that NumPy saved: NPZ archives of named arrays, and single arrays (NPY)."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import Request, Table
from bristle.logs.tables import Stored, table_from
from bristle.logs.words import distinct

MOST_ARRAYS = 100_000


def read(data: bytes, request: Request) -> Table:
    """Return the columns of an array with several of them, or of an archive of single columns."""
    if data.startswith(b"\x93NUMPY"):
        return _table({request.source.stem: _stored(lambda: io.BytesIO(data), len(data), request.source)}, [], request)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        if len(members) > MOST_ARRAYS:
            raise InputError("holds too many arrays", path=str(request.source), value=len(members), allowed=f"up to {MOST_ARRAYS}")
        names, notes = distinct(member.filename.removesuffix(".npy") for member in members)
        stored = {}
        for name, member in zip(names, members, strict=True):
            refuse_larger(member.file_size, request.limit, f"{request.source}: {name}")
            stored[name] = _stored(lambda member=member: archive.open(member), member.file_size, request.source)
        return _table(stored, notes, request)


def _table(stored: dict[str, Stored], notes: list[str], request: Request) -> Table:
    columns = {name: array for name, array in stored.items() if array.holds_columns}
    remarks = (f"{name} holds no column of numbers and was left out" for name in stored if name not in columns)
    return table_from(columns, request, "NPZ", notes=(*notes, *remarks))


def _stored(opened: Callable[[], IO[bytes]], size: int, source: Path) -> Stored:
    """Return what the head of an array says of it; the numbers that it announces must be there."""
    with opened() as file:
        version = np.lib.format.read_magic(file)
        header: Any = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = header(file, max_header_size=10_000)  # [byte] at most, before the numbers of an array
    if dtype.hasobject:
        raise InputError("holds objects of Python, which are not read", path=str(source), mend="Save arrays of numbers")

    def read() -> np.ndarray:
        with opened() as file:
            return np.lib.format.read_array(file, allow_pickle=False)

    stored = Stored(tuple(shape), dtype, read)
    if stored.size * dtype.itemsize > size:
        raise ValueError(f"an array announces {stored.size} numbers and is shorter")
    return stored
