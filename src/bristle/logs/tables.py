"""Files with several tables: find the log, the names of its columns, and the columns to read."""

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from bristle.core.content import SIZE_LIMIT, Content, Readable, content_of, refuse_larger
from bristle.core.errors import InputError, did_you_mean
from bristle.logs.table import NUMBER_BYTES, Request, Table, some_of

T = TypeVar("T")

WITHIN = "::"  # between the name of a file and that of a table in it


def content_of_log(given: Readable, *, limit: int = SIZE_LIMIT) -> Content:
    """Return the content of the file of a log; ``log.h5::table`` names a table in it."""
    if not isinstance(given, (str, os.PathLike)) or isinstance(given, Content):
        return content_of(given, limit=limit, path="log", what="a log")
    text = os.fspath(given)
    file, _, name = text.rpartition(WITHIN)
    if not file or not name or os.path.lexists(text.partition("\0")[0]):
        return content_of(text, limit=limit)
    return replace(content_of(file, limit=limit), part=name)


class Stored(NamedTuple):
    """An array in a file: its description, and a function that reads it."""

    shape: tuple[int, ...]
    dtype: np.dtype
    read: Callable[[], Any]
    unit: str = ""

    @property
    def size(self) -> int:
        """Count of its elements."""
        return math.prod(self.shape)

    @property
    def fields(self) -> list[str]:
        """Names of its fields, if it is a structured array."""
        return [
            name
            for name in self.dtype.names or ()
            if self.dtype[name].kind in "fiub" and not self.dtype[name].shape
        ]

    @property
    def holds_columns(self) -> bool:
        """Whether it has columns: numbers in one or two dimensions, or structured numbers."""
        return (
            (self.dtype.kind in "fiub" or bool(self.fields))
            and len(self.shape) <= 2
            and self.size > 0
        )


def table_from(
    arrays: Mapping[str, Stored],
    request: Request,
    kind: str,
    *,
    separator: str = "/",
    notes: Sequence[str] = (),
) -> Table:
    """Return the columns of one table of a file, or of all tables, each with its full name; read only the chosen columns."""
    # A group of columns is a table, and so is an array of several columns. The name of the only table does not matter.
    groups: dict[
        str, dict[str, tuple[Stored, int | str | None]]
    ] = {}  # each column as its array and the part of it
    constants: dict[str, Stored] = {}
    for full, stored in arrays.items():
        group, _, name = full.rpartition(separator)
        if stored.dtype.names:
            groups[full] = {field: (stored, field) for field in stored.fields}
        elif stored.size == 1:
            constants[full] = stored
        elif len(stored.shape) == 1 or 1 in stored.shape:
            groups.setdefault(group, {})[name] = (stored, None)
        else:
            groups[full] = {f"column_{k + 1}": (stored, k) for k in range(min(stored.shape))}
    tables = {name: columns for name, columns in groups.items() if columns}
    names, remarks, chosen = list(tables), list(notes), request.table
    if not names:
        raise InputError(
            "holds no column of numbers",
            path=str(request.source),
            mend="Save the signals as vectors",
        )
    if chosen not in tables:
        if chosen is not None and len(names) > 1:
            raise no_such_table(chosen, names, request.source)
        if chosen is not None and names[0]:
            remarks.append(
                f"this log has no table {chosen!r}: bristle read its only table, {names[0]!r}"
            )
        chosen = names[0] if len(names) == 1 else None
    if chosen is None:
        available = {
            f"{table}{separator}{name}" if table else name: column
            for table in names
            for name, column in tables[table].items()
        }
    else:
        available = tables[chosen]
        constants = {
            name.removeprefix(f"{chosen}{separator}"): array for name, array in constants.items()
        }
    columns = {name: column for name, column in available.items() if request.choice(name)}
    needed = dict.fromkeys(stored for stored, _ in columns.values())
    announced = sum(stored.size * max(stored.dtype.itemsize, NUMBER_BYTES) for stored in needed)
    refuse_larger(announced, request.limit, request.source)
    read = {stored: np.asarray(stored.read()) for stored in needed}
    return Table(
        {name: _numbers_of(read[stored], part) for name, (stored, part) in columns.items()},
        {
            name: stored.unit
            for name, (stored, part) in available.items()
            if stored.unit and part is None
        },
        {
            name: float(np.asarray(constant.read()).reshape(()))
            for name, constant in constants.items()
        },
        notes=tuple(remarks),
        format=kind,
        tables=() if chosen is not None else tuple(names),
        names=tuple(available),
    )


def _numbers_of(values: np.ndarray, part: int | str | None) -> np.ndarray:
    if isinstance(part, str):
        return values[part].ravel().astype(float)
    if part is None:
        return values.reshape(-1).astype(float)
    return np.ascontiguousarray(tall(values)[:, part], float)


def tall(values: np.ndarray) -> np.ndarray:
    """Return a matrix with time along its longer side."""
    return values if values.shape[0] >= values.shape[1] else values.T


def no_such_table(table: str, names: list[str], source: Path) -> InputError:
    """Return the error that lists the tables of a file in place of an unknown one."""
    mend = (
        did_you_mean(table, names, 0.5)
        or "Correct the name after ::, or `table` under [log] of the axis file"
    )
    return InputError(
        f"holds no table {table!r}", path=str(source), allowed=some_of(names), mend=mend
    )


def flattened(
    node: Any, through: tuple[type, ...] = (Mapping, list), depth: int = 8, path: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield the leaves of nested mappings and lists, with full names: ``a.b[0]``; deeper levels stay whole."""
    if depth == 0 or not isinstance(node, through):
        yield path, node
        return
    for key, value in node.items() if isinstance(node, Mapping) else enumerate(node):
        name = f"{path}[{key}]" if isinstance(node, list) else f"{path}.{key}".removeprefix(".")
        yield from flattened(value, through, depth - 1, name)


def note_of_text(names: Sequence[str]) -> list[str]:
    """Return the note on columns of text."""
    if names:
        return [
            f"bristle ignores columns of text: {', '.join(names[:20])}"
            + (" and others" if len(names) > 20 else "")
        ]
    return []


class Series(NamedTuple):
    """A channel: its values if read, and its times if separate."""

    name: str
    values: np.ndarray | None
    times: np.ndarray | None = None
    unit: str = ""
    about: str = ""
    joint: str = ""


def by_name(channels: Iterable[tuple[str, str, T]]) -> dict[str, T]:
    """Return channels by their names if unique, else by group and name, from (name, group, channel)."""
    listed = list(channels)
    count = Counter(name for name, *_ in listed)
    return {
        (name if count[name] == 1 else f"{group}/{name}"): channel
        for name, group, channel in listed
    }


def table_of_series(
    series: Iterable[Series],
    request: Request,
    kind: str,
    *,
    time: str = "time",
    time_unit: str = "s",
    notes: Sequence[str] = (),
    texts: Mapping[str, InputError] | None = None,
    facts: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
) -> Table:
    """Return the table of channels with separate times: one time column for all channels that share their times."""
    channels = [channel for channel in series if channel.values is None or channel.values.size]
    if not channels:
        raise InputError(
            "holds no column of numbers",
            path=str(request.source),
            mend="Save the signals as vectors, with their times",
        )
    names_used = {channel.name for channel in channels}
    chosen = [
        channel
        for channel in channels
        if channel.values is not None and request.choice(channel.name)
    ]
    clocks: dict[str, np.ndarray] = {}
    stamps: dict[str, str] = {}
    for channel in chosen:
        if channel.times is None:
            continue
        name = next(
            (name for name, clock in clocks.items() if np.array_equal(clock, channel.times)), None
        )
        if name is None:
            name = time if not clocks else f"time of {channel.name}"
            while name in names_used:
                name = f"{name}_"
            clocks[name] = np.asarray(channel.times, dtype=float)
        stamps[channel.name] = name
    columns = clocks | {channel.name: np.asarray(channel.values, dtype=float) for channel in chosen}
    units = dict.fromkeys(clocks if time_unit else (), time_unit) | {
        channel.name: channel.unit for channel in channels if channel.unit
    }
    return Table(
        columns,
        units,
        constants or {},
        texts or {},
        notes=tuple(notes),
        format=kind,
        names=(*clocks, *(channel.name for channel in channels)),
        stamps=stamps,
        facts=facts or {},
        about={channel.name: channel.about for channel in channels if channel.about},
        joints={channel.name: (channel.joint, "") for channel in channels if channel.joint},
        source=request.source,
    )
