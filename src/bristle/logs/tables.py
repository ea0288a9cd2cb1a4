"""Files that hold several tables: which of them is the log, and what its columns are called."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Table, close_matches, some_of

__all__ = ["Arrays", "located", "table_from"]

WITHIN = "::"  # between the name of a file and that of a table in it


def located(path: str | os.PathLike[str]) -> tuple[Path, str | None]:
    """Return the file and the table in it, of ``log.h5`` or ``log.h5::table``.

    Examples
    --------
    >>> located("tests.npz::first")[1]
    'first'
    """
    text = os.fspath(path)
    file, _, name = text.rpartition(WITHIN)
    if not file or not name or Path(text).exists():
        return Path(text), None
    return Path(file), name


@dataclass(frozen=True)
class Arrays:
    """What a file of named arrays holds.

    Parameters
    ----------
    values : mapping of str to ndarray
        Each array under its full name, groups before it: a column (1-D), a table (2-D, or with named fields), or a
        single number.
    units : mapping of str to str
        Unit of an array, where the file says it.
    separator : str
        Between the name of a group and what is in it.
    notes : tuple of str
        What the reader left out.
    """

    values: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)
    separator: str = "/"
    notes: tuple[str, ...] = ()


def table_from(arrays: Arrays, wanted: str | None, source: Path, kind: str) -> Table:
    """Return the columns of one table of a file, or of all of them, each under its full name.

    A group of columns is a table, and so is an array of several columns; those without a name are ``column_1`` and
    so on. A file that holds one table only is understood whatever that table is called.

    Parameters
    ----------
    arrays : Arrays
        What the file holds.
    wanted : str or None
        Name of the table.
    source : Path
        The file.
    kind : str
        Kind of file.

    Raises
    ------
    InputError
        If there is no such table, or no column of numbers.
    """
    tables, constants = _tables_of(arrays)
    names = list(tables)
    notes = list(arrays.notes)
    if not names:
        raise InputError("holds no column of numbers", path=str(source), mend="Save the signals as vectors")
    if wanted is not None and wanted not in tables:
        if len(names) > 1:
            raise _no_such_table(wanted, names, source)
        if names[0]:
            notes.append(f"there is no table {wanted!r} in this log: {names[0]!r}, its only one, was taken")
    chosen = wanted if wanted in tables else names[0] if len(names) == 1 else None
    if chosen is None:
        columns = {_full(table, name, arrays): one for table in names for name, one in tables[table].items()}
    else:
        columns = dict(tables[chosen])
        constants = {name.removeprefix(f"{chosen}{arrays.separator}"): one for name, one in constants.items()}
    units = {name: arrays.units[full] for name in columns if (full := _origin(chosen, name, arrays)) in arrays.units}
    return Table(
        columns, units, constants, notes=tuple(notes), format=kind, tables=() if chosen is not None else tuple(names)
    )


def _tables_of(arrays: Arrays) -> tuple[dict[str, dict[str, np.ndarray]], dict[str, float]]:
    """Return the columns of each table, and the single numbers of the file."""
    tables: dict[str, dict[str, np.ndarray]] = {}
    constants: dict[str, float] = {}
    for full, values in arrays.values.items():
        group, _, name = full.rpartition(arrays.separator)
        if values.dtype.names:
            fields = {one: values[one].ravel() for one in values.dtype.names}
            tables[full] = {one: column.astype(float) for one, column in fields.items() if column.dtype.kind in "fiub"}
        elif values.size == 1:
            constants[full] = float(values.reshape(()))
        elif values.ndim == 1 or 1 in values.shape:
            tables.setdefault(group, {})[name] = values.reshape(-1).astype(float)
        else:
            tall = values if values.shape[0] >= values.shape[1] else values.T
            tables[full] = {f"column_{k + 1}": np.ascontiguousarray(one, float) for k, one in enumerate(tall.T)}
    return {name: columns for name, columns in tables.items() if columns}, constants


def _full(table: str, column: str, arrays: Arrays) -> str:
    return f"{table}{arrays.separator}{column}" if table else column


def _origin(chosen: str | None, column: str, arrays: Arrays) -> str:
    return column if chosen is None else _full(chosen, column, arrays)


def _no_such_table(wanted: str, names: list[str], source: Path) -> InputError:
    close = close_matches(wanted, names)
    elsewhere = "Mend the name behind ::, or `table` under [log] of the axis file"
    return InputError(
        f"holds no table {wanted!r}",
        path=str(source),
        allowed=some_of(names),
        mend=f"Did you mean {close[0]!r}?" if close else elsewhere,
    )
