"""Logs in HDF5, those that MATLAB saves as version 7.3 among them."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Request, Table
from bristle.logs.tables import Stored, table_from

UNIT_ATTRIBUTES = ("unit", "units")


def read(data: bytes, request: Request) -> Table:
    """Return the columns of a group, or of a matrix, of an HDF5 file."""
    import h5py

    separator = "." if data.startswith(b"MATLAB 7.3") else "/"
    values: dict[str, Stored] = {}
    notes: list[str] = []
    with h5py.File(io.BytesIO(data), "r") as content:
        for path, node in _data_sets(content, request.source):
            name = path.replace("/", separator)
            stored = Stored((0,) if node.shape is None else node.shape, node.dtype, lambda node=node: node[()])
            if not stored.holds_columns or _text(node, "MATLAB_class") in ("char", "cell", "function_handle"):
                notes.append(f"{name} holds no column of numbers and was left out")
                continue
            unit = next((text for key in UNIT_ATTRIBUTES if (text := _text(node, key))), "")
            values[name] = stored._replace(unit=unit)
            if not unit and any(key in node.attrs for key in UNIT_ATTRIBUTES):
                notes.append(f"the unit of {name} is no text and was left out")
        return table_from(values, request, "HDF5", separator=separator, notes=notes)


def _data_sets(content: Any, source: Path) -> Iterator[tuple[str, Any]]:
    """Yield name and data set of all that lies in the file itself; what lies elsewhere is not looked for."""
    import h5py
    from h5py import h5o  # pyright: ignore[reportAttributeAccessIssue]

    waiting, visited, count = [("", content)], set(), 0
    while waiting:
        before, group = waiting.pop(0)
        for name in group:
            count += 1
            path = f"{before}{name}"
            link = group.get(name, getlink=True)
            elsewhere = f"{path} is a link into another file" if isinstance(link, h5py.ExternalLink) else ""
            if not elsewhere and (name.startswith("#") or not isinstance(link, h5py.HardLink)):
                continue
            node: Any = None if elsewhere else group[name]
            if isinstance(node, h5py.Dataset) and (node.is_virtual or node.external):
                elsewhere = f"{path} takes its numbers from other files"
            if elsewhere:
                raise InputError(f"{elsewhere}, which are not read", path=str(source), mend="Save the log in one file (h5repack)")
            address = h5o.get_info(node.id).addr
            if address in visited or count > 100_000:
                continue
            visited.add(address)
            if isinstance(node, h5py.Group):
                waiting.append((f"{path}/", node))
            elif isinstance(node, h5py.Dataset):
                yield path, node


def _text(node: Any, key: str) -> str:
    if key not in node.attrs or node.attrs.get_id(key).get_storage_size() > 200:  # [byte]
        return ""
    value = node.attrs[key]
    value = value[0] if isinstance(value, np.ndarray) and value.shape == (1,) else value
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value if isinstance(value, str) else ""
