"""Read a file with the reader of its format, and refuse files that are no logs."""

import dataclasses
import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np

from bristle.core import (
    SIZE_LIMIT,
    Axis,
    Content,
    InputError,
    MissingExtraError,
    Readable,
    escaped,
    units,
)
from bristle.logs.assembly import record_of
from bristle.logs.catalogue import ARCHIVE, format_of
from bristle.logs.formats import LogFormat
from bristle.logs.gather import axis_of
from bristle.logs.log import Log, is_table, log_of, table_of
from bristle.logs.stamped_text import stated_period
from bristle.logs.table import ALL, Choice, Request, Table, columns_of, damage_refused
from bristle.logs.tables import content_of_log
from bristle.logs.words import is_time, names_and_units, with_plain_names

# First bytes -> reason for the refusal, and advice.
REFUSED = {
    ARCHIVE: "This file is a spreadsheet or an archive: export the log as CSV, or unpack the archive",
    b"\xd0\xcf\x11\xe0": "This file is an old spreadsheet: export the log as CSV",
    b"\x1f\x8b": "This file is compressed: unpack it first (gunzip)",
    b"%PDF": "This file is a document: export the log as CSV",
}


def read_table(
    given: Readable, table: str | None = None, *, choice: Choice = ALL, size_limit: int = SIZE_LIMIT
) -> Table:
    """Return the columns of a log in any format."""
    content = content_of_log(given, limit=size_limit)
    place = str(content.source)
    if not content.data[:1024].strip() and not content.data.strip():
        raise InputError("is empty", path=place, mend="Record or export the log again")
    log_format = format_of(content.data, content.source.suffix)
    if log_format.name != "npz" and log_format.read is None:
        for magic, mend in REFUSED.items():
            if content.data.startswith(magic):
                raise InputError("is not a log that bristle can read", path=place, mend=mend)
    if content.part is not None and not log_format.holds_tables:
        raise InputError(
            "is not a file with several tables",
            path=place,
            value=content.part,
            mend="Remove the table name after the file name",
        )
    if log_format.name != "csv" and any(name.startswith("column_") for name in choice.names or ()):
        choice = ALL  # column numbers refer to the file
    read = _read(
        log_format, content, Request(content.source, content.part or table, choice, size_limit)
    )
    notes = read.notes
    if table is not None and not log_format.holds_tables:
        notes = (*notes, f"the file is a single table: bristle ignores the table name {table!r}")
    period = read.sample_time
    if period is None and not read.stamps:
        period = stated_period(
            {
                **read.facts,
                **{
                    re.split(r"[./]", name)[-1]: f"{value!r}"
                    for name, value in read.constants.items()
                },
            }
        )
    counted = (
        {}
        if read.stamps or read.tables
        else {f"column_{i + 1}": name for i, name in enumerate(read.names)}
    )
    source = Path(escaped(place))  # only displayed from here on
    changes = {
        "notes": notes,
        "sample_time": period,
        "numbers": {**counted, **read.numbers},
        "source": source,
        "origin": content.origin,
    }
    return with_plain_names(dataclasses.replace(read, **changes))


def _read(log_format: LogFormat, content: Content, request: Request) -> Table:
    """Read a file; report unforeseen errors of its reader as damage."""
    if log_format.package:
        from bristle.logs.apart import read_apart

        if find_spec(log_format.package) is None:
            raise MissingExtraError.of(
                f"{content.source}: reading {log_format.title}", log_format.extra
            )
        return read_apart(log_format.place, content.data, request)
    read: Callable[..., Table] = log_format.read or resolve_name(log_format.place)
    try:
        with damage_refused(content.source):
            return _as_table(read(content.data, request), log_format, content)
    except MemoryError:
        raise InputError(
            "needs more memory than is available", path=str(content.source), mend="Cut the log"
        ) from None


def _as_table(read: Any, log_format: LogFormat, content: Content) -> Table:
    """Return the result of a reader as a `Table`; your own readers can return any table of columns."""
    if isinstance(read, Table):
        return read
    if not is_table(read):
        raise InputError(
            f"is read by {log_format.name}, which returned a {type(read).__name__}",
            path=str(content.source),
            allowed="a Table, a data frame, or arrays by name",
        )
    table = table_of(read)
    names, units, notes = names_and_units(table.columns, table.units)
    columns = dict(zip(names, table.columns.values(), strict=True))
    changes = {
        "columns": columns,
        "units": units,
        "notes": (*table.notes, *notes),
        "names": tuple(columns),
    }
    return dataclasses.replace(table, **changes, format=log_format.title, source=content.source)


def with_known(table: Table, axis: Axis | None, *, size_limit: int = SIZE_LIMIT) -> Table:
    """Return the table of a log with the known columns of other tables, interpolated to the times of the log."""
    columns, units_of = dict(table.columns), dict(table.units)
    for number, term in enumerate(axis.regressors if axis else ()):
        if not term.file:
            continue
        assert axis is not None
        if term.log and term.log != table.origin.mark:
            raise InputError(
                "holds the efforts of the bodies along another log",
                path=f"known[{number}].file",
                value=term.file,
                mend="Predict the other log of an arm with its folder of results: bristle predict DIR LOG",
            )
        path, second = f"known[{number}]", read_table(term.file, size_limit=size_limit)
        name = second.name_of(term.column)
        if name is None:
            raise second.missing(term.column, path)
        of_log = axis.columns.get("time")
        period = axis.sample_time or table.sample_time
        times = _times_of(
            table, None if of_log is None else of_log.name, of_log and of_log.unit, path, period
        )
        stamps = _times_of(
            second, next(filter(is_time, second.names), None), None, path, second.sample_time
        )
        slack = 0.5 * np.median(np.diff(stamps))  # rounded times may end before those of the log
        low, high = axis.span or (-np.inf, np.inf)
        used = times[(times >= low) & (times < high)]
        if used.size and (used[0] < stamps[0] - slack or used[-1] > stamps[-1] + slack):
            raise InputError(
                f"ends within the log, which lasts from {used[0]:g} to {used[-1]:g} s",
                path=f"{path}.file",
                value=f"{stamps[0]:g} to {stamps[-1]:g} s",
            )
        values = second.columns[name]
        columns[term.place] = (
            values if np.array_equal(times, stamps) else np.interp(times, stamps, values)
        )
        units_of |= {term.place: second.units[name]} if name in second.units else {}
    return dataclasses.replace(table, columns=columns, units=units_of)


def _times_of(
    table: Table, named: str | None, unit: str | None, path: str, period: float | None
) -> np.ndarray:
    """Return the times of the rows of a table [s], from its column of time or its sample time."""
    name = None if named is None else table.name_of(named)
    if name is None and period is not None:
        return period * np.arange(max(map(len, table.columns.values())))
    if name is None:
        raise InputError(
            "needs a column of time in both tables", path=f"{path}.file", value=str(table.source)
        )
    return table.columns[name] * units.factor(unit or table.units.get(name, "s"), "s", path=path)


def read_log(given: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT) -> Log:
    """Return the log in a file, in SI units of the axis, on a uniform grid of time.

    Parameters
    ----------
    given : path-like, bytes, file object or Content
        A file in a format listed by ``bristle log --help``; ``FILE::TABLE`` names a table in it.
    axis : Axis, optional
        Names, units and signs of the columns. Without it bristle reads columns with usual names (``t``, ``position``,
        ``force``), in the units of the file.
    size_limit : int
        Largest file, and largest content announced by a file [byte].

    Raises
    ------
    InputError
        If the file is truncated, a column is missing, has a wrong unit, is not finite, constant or saturated, or time is not in
        order; the error names the column and the sample.
    """
    table = with_known(
        read_table(given, axis and axis.table, choice=columns_of(axis), size_limit=size_limit),
        axis,
        size_limit=size_limit,
    )
    return log_of(record_of(table, axis or axis_of(table)))
