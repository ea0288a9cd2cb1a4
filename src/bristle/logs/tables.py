"""Files that hold several tables: which of them is the log, what its columns are called, and which of them are read."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from bristle.core.content import SIZE_LIMIT, Content, Readable, content_of, refuse_larger
from bristle.core.errors import InputError, close_names
from bristle.logs.table import NUMBER_BYTES, Request, Table, some_of

__all__ = ["Arrays", "Series", "Stored", "by_name", "content_of_log", "no_such_table", "table_from", "table_of_series", "tall"]

T = TypeVar("T")

WITHIN = "::"  # between the name of a file and that of a table in it


def content_of_log(given: Readable, *, limit: int = SIZE_LIMIT) -> Content:
    """Return what the file of a log holds; ``log.h5::table`` names a table in it."""
    if not isinstance(given, (str, os.PathLike)) or isinstance(given, Content):
        return content_of(given, limit=limit, path="log", what="a log")
    text = os.fspath(given)
    file, _, name = text.rpartition(WITHIN)
    if not file or not name or os.path.lexists(text.partition("\0")[0]):
        return content_of(text, limit=limit)
    return replace(content_of(file, limit=limit), part=name)


class Stored(NamedTuple):
    """An array in a file: what the file says of it, and how it is read."""

    shape: tuple[int, ...]
    dtype: np.dtype
    read: Callable[[], Any]

    @property
    def size(self) -> int:
        """Count of its elements."""
        return math.prod(self.shape)

    @property
    def holds_columns(self) -> bool:
        """Whether it is made of numbers, in one or two dimensions; or of named numbers."""
        numbers = self.dtype.kind in "fiub" or (self.dtype.kind == "V" and bool(_numeric_fields(self.dtype)))
        return numbers and len(self.shape) <= 2 and self.size > 0


def _numeric_fields(dtype: np.dtype) -> list[str]:
    return [name for name in dtype.names or () if dtype[name].kind in "fiub" and not dtype[name].shape]


@dataclass(frozen=True)
class Arrays:
    """What a file of named arrays holds."""

    values: Mapping[str, Stored]
    units: Mapping[str, str] = field(default_factory=dict)
    separator: str = "/"
    notes: tuple[str, ...] = ()


class _Column(NamedTuple):
    """A column in the arrays of a file: in which one, and which part of it."""

    array: str
    part: int | str | None = None


def table_from(arrays: Arrays, request: Request, kind: str) -> Table:
    """Return the columns of one table of a file, or of all of them, each under its full name.

    A group of columns is a table, and so is an array of several columns; those without a name are ``column_1`` and
    so on. A file that holds one table only is understood whatever that table is called. Only the columns chosen are
    read, and only if what the file announces is not too large.
    """
    tables, constants = _tables_of(arrays)
    names = list(tables)
    notes = list(arrays.notes)
    if not names:
        raise InputError("holds no column of numbers", path=str(request.source), mend="Save the signals as vectors")
    if request.table is not None and request.table not in tables:
        if len(names) > 1:
            raise no_such_table(request.table, names, request.source)
        if names[0]:
            notes.append(f"there is no table {request.table!r} in this log: {names[0]!r}, its only one, was taken")
    chosen = request.table if request.table in tables else names[0] if len(names) == 1 else None
    if chosen is None:
        available = {_full(table, name, arrays): column for table in names for name, column in tables[table].items()}
    else:
        available = tables[chosen]
        constants = {name.removeprefix(f"{chosen}{arrays.separator}"): array for name, array in constants.items()}
    columns = _read({name: column for name, column in available.items() if request.choice(name)}, arrays, request.source, request.limit)
    units = {
        name: arrays.units[full] for name in available if (full := name if chosen is None else _full(chosen, name, arrays)) in arrays.units
    }
    return Table(
        columns,
        units,
        {name: float(np.asarray(constant.read()).reshape(())) for name, constant in constants.items()},
        notes=tuple(notes),
        format=kind,
        tables=() if chosen is not None else tuple(names),
        names=tuple(available),
    )


def _tables_of(arrays: Arrays) -> tuple[dict[str, dict[str, _Column]], dict[str, Stored]]:
    """Return the columns of each table, and the single numbers of the file."""
    tables: dict[str, dict[str, _Column]] = {}
    constants: dict[str, Stored] = {}
    for full, stored in arrays.values.items():
        group, _, name = full.rpartition(arrays.separator)
        if stored.dtype.names:
            tables[full] = {field: _Column(full, field) for field in _numeric_fields(stored.dtype)}
        elif stored.size == 1:
            constants[full] = stored
        elif len(stored.shape) == 1 or 1 in stored.shape:
            tables.setdefault(group, {})[name] = _Column(full)
        else:
            tables[full] = {f"column_{k + 1}": _Column(full, k) for k in range(min(stored.shape))}
    return {name: columns for name, columns in tables.items() if columns}, constants


def _read(columns: Mapping[str, _Column], arrays: Arrays, source: Path, limit: int) -> dict[str, np.ndarray]:
    needed = {column.array: arrays.values[column.array] for column in columns.values()}
    announced = sum(stored.size * max(stored.dtype.itemsize, NUMBER_BYTES) for stored in needed.values())
    refuse_larger(announced, limit, source)
    read = {name: np.asarray(stored.read()) for name, stored in needed.items()}
    return {name: _numbers_of(read[column.array], column.part) for name, column in columns.items()}


def _numbers_of(values: np.ndarray, part: int | str | None) -> np.ndarray:
    if isinstance(part, str):
        return values[part].ravel().astype(float)
    if part is None:
        return values.reshape(-1).astype(float)
    return np.ascontiguousarray(tall(values)[:, part], float)


def tall(values: np.ndarray) -> np.ndarray:
    """Return a matrix with time along its longer side."""
    return values if values.shape[0] >= values.shape[1] else values.T


def _full(table: str, column: str, arrays: Arrays) -> str:
    return f"{table}{arrays.separator}{column}" if table else column


def no_such_table(table: str, names: list[str], source: Path) -> InputError:
    """Return the error that says which tables there are instead of one that is asked for."""
    close = close_names(table, names)
    elsewhere = "Mend the name behind ::, or `table` under [log] of the axis file"
    return InputError(
        f"holds no table {table!r}", path=str(source), allowed=some_of(names), mend=f"Did you mean {close[0]!r}?" if close else elsewhere
    )


TIME = "time"


class Series(NamedTuple):
    """A channel, its values where they are read, and its times where it brings its own."""

    name: str
    values: np.ndarray | None
    times: np.ndarray | None = None
    unit: str = ""
    about: str = ""

    def every(self, period: float | None) -> Series:
        """Return it sampled once in a period [s]."""
        return self if period is None or self.values is None else self._replace(times=period * np.arange(self.values.size))


def by_name(channels: Iterable[tuple[str, str, T]]) -> dict[str, T]:
    """Return channels by their names where no other has it, else by their group and name, of (name, group, channel)."""
    listed = list(channels)
    count = Counter(name for name, *_ in listed)
    return {(name if count[name] == 1 else f"{group}/{name}"): channel for name, group, channel in listed}


def table_of_series(
    series: Iterable[Series],
    source: Path,
    kind: str,
    *,
    time: str = TIME,
    time_unit: str = "s",
    notes: Sequence[str] = (),
    texts: Mapping[str, InputError] | None = None,
    facts: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
) -> Table:
    """Return the table of channels that bring their own times: one column of time for all that share theirs."""
    channels = [channel for channel in series if channel.values is None or channel.values.size]
    if not channels:
        raise InputError("holds no column of numbers", path=str(source), mend="Save the signals as vectors, with their times")
    names_used = {channel.name for channel in channels}
    clocks: dict[str, np.ndarray] = {}
    stamps: dict[str, str] = {}
    for channel in channels:
        if channel.values is None or channel.times is None:
            continue
        name = next((name for name, clock in clocks.items() if np.array_equal(clock, channel.times)), None)
        if name is None:
            name = time if not clocks else f"{TIME} of {channel.name}"
            while name in names_used:
                name = f"{name}_"
            clocks[name] = np.asarray(channel.times, dtype=float)
        stamps[channel.name] = name
    columns = clocks | {channel.name: channel.values for channel in channels if channel.values is not None}
    units = dict.fromkeys(clocks if time_unit else (), time_unit) | {channel.name: channel.unit for channel in channels if channel.unit}
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
        source=source,
    )
