"""Logs that MATLAB saved, version 5 to 7.2."""

from __future__ import annotations

import io
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import Request, Table
from bristle.logs.tables import Series, flattened, table_of_series, tall

MAT = b"MATLAB 5.0"
HEADER_BYTES, TAG_BYTES = 128, 8
DEEPEST = 64


def read(data: bytes, request: Request) -> Table:
    """Return the columns of a MAT file; fields of structures are named ``structure.field``."""
    if data.startswith(MAT):
        _examine(data, request.source, request.limit)
    import scipy.io

    series, constants, notes = [], {}, []
    variables = scipy.io.loadmat(io.BytesIO(data), simplify_cells=True)
    for full, value in flattened(_with_lists(variables), depth=2 * DEEPEST):
        values = np.asarray(value)
        if values.dtype.kind not in "fiub" or not values.size or full.startswith("__"):
            continue
        if values.size == 1:
            constants[full] = float(values.reshape(()))
        elif values.ndim > 2 and 1 not in values.shape:
            notes.append(f"{full} has {values.ndim} dimensions and was left out")
        else:  # time runs along the longer side of a matrix
            vector = values.ndim == 1 or 1 in values.shape
            columns = {full: values.reshape(-1)} if vector else {f"{full}[{k}]": column for k, column in enumerate(tall(values).T)}
            series += [Series(name, numbers) for name, numbers in columns.items()]
    return table_of_series(series, request, "MAT", constants=constants, notes=notes)


def _with_lists(value: Any) -> Any:
    """Return structures and cells as tables and lists."""
    if isinstance(value, dict):
        return {name: _with_lists(inner) for name, inner in value.items()}
    cells = isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1
    return list(map(_with_lists, value)) if cells or isinstance(value, list) else value


def _examine(data: bytes, source: Path, limit: int) -> None:
    """Walk over the elements, each of which says its length: the last must end with the file, all must fit."""
    order = "little" if data[126:128] == b"IM" else "big"
    at, unpacked = HEADER_BYTES, 0
    while at < len(data):
        kind, length = _tag(data, at, order)
        begin, at = at + TAG_BYTES, at + TAG_BYTES + length
        if at > len(data):
            break
        element = data[begin - TAG_BYTES : at]
        if kind == 15:
            with suppress(zlib.error):  # the reader will tell what is wrong with it
                element = zlib.decompressobj().decompress(data[begin:at], limit - unpacked + 1)
                unpacked += len(element)
            refuse_larger(unpacked, limit, source)
        _refuse_deep(element, order, source)
    if at != len(data) or at == HEADER_BYTES:
        announced = max(at, HEADER_BYTES + TAG_BYTES)
        message = f"is truncated: {len(data)} bytes, and its content announces {announced}"
        raise InputError(message, path=str(source), mend="Copy or save it again")


def _tag(data: bytes, at: int, order: Literal["little", "big"]) -> tuple[int, int]:
    """Return what the tag at this byte says: the kind of an element and its length [byte]."""
    kind, length = (int.from_bytes(data[at + i : at + i + 4], order) for i in (0, 4))
    # A small element has its length in the upper half of the kind, and its data in place of the length.
    return (kind & 0xFFFF, 0) if kind >> 16 else (kind, length)


def _refuse_deep(element: bytes, order: Literal["little", "big"], source: Path) -> None:
    """Refuse cells in cells in cells: the reader calls itself for each, in native code, until its stack is full."""
    at, ends = 0, []
    while at + TAG_BYTES <= len(element):
        while ends and at >= ends[-1]:
            ends.pop()
        kind, length = _tag(element, at, order)
        at += TAG_BYTES
        if kind == 14:
            ends.append(at + length)
        else:
            at += -(-length // TAG_BYTES) * TAG_BYTES
        if len(ends) > DEEPEST:
            allowed = f"up to {DEEPEST} cells in one another"
            raise InputError("is nested too deeply", path=str(source), allowed=allowed, mend="Save the signals as vectors")
