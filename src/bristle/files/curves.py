"""Files that describe recorded hysteresis: the input and output columns, and the start of each curve."""

import fnmatch
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from bristle.core import SIZE_LIMIT, InputError, Readable, located, size_of, units
from bristle.core.variable import Kind, unit_of
from bristle.files.components import check_schema
from bristle.files.schema import ColumnName, Signal, SignalEntry, Strict, validated
from bristle.files.toml import read_toml
from bristle.logs.curves import Curve, Curves
from bristle.logs.problems import LARGEST, SMALLEST
from bristle.logs.readers import read_table
from bristle.logs.table import Table


class Columns(Strict):
    """Signals of the curves."""

    input: Signal
    output: Signal
    curve: ColumnName = ""


class LogEntry(Strict):
    """Place of the curves in the file."""

    tables: str = ""


class CurvesEntry(Strict):
    """Start of each curve, and the minimum length."""

    start: Literal["virgin", "saturated"] = "virgin"
    shortest: Annotated[int, Field(ge=2)] = 2


class HysteresisFile(Strict):
    """Complete description of recorded hysteresis."""

    schema_version: Literal[1] = Field(alias="schema")
    name: str = "hysteresis"
    kind: Kind
    log: LogEntry = LogEntry()
    columns: Columns
    curves: CurvesEntry = CurvesEntry()


def read_curve_columns(path: HysteresisFile | Readable | dict[str, Any]) -> HysteresisFile:
    """Return the description of the curves in a file."""
    if isinstance(path, HysteresisFile):
        return path
    data, source, _ = read_toml(
        path, path="axis", what="a file that names the columns of the curves"
    )
    with located(source):
        check_schema(data)
        file = validated(HysteresisFile, data)
        for name, quantity in (("input", "length"), ("output", "force")):
            if (unit := getattr(file.columns, name).unit) is not None:
                units.factor(unit, unit_of(quantity, file.kind), path=f"columns.{name}.unit")
        return file


def read_curves(
    path: Readable,
    axis: HysteresisFile | Readable | dict[str, Any],
    *,
    size_limit: int | str = SIZE_LIMIT,
) -> Curves:
    """Return recorded hysteresis: curves of input and output in SI units.

    Parameters
    ----------
    path : path-like, bytes or file object
        A file in any log format.
    axis : HysteresisFile, path-like or dict
        Description of the curves, or its file.
    size_limit : int or str
        Largest file [byte], or text such as ``"2 GB"``.

    Raises
    ------
    InputError
        If the files cannot be used; the message names the file, the key or column, and the remedy.
    """
    file = read_curve_columns(axis)
    table = read_table(path, size_limit=size_of(size_limit))
    tables, columns, shortest = file.log.tables, file.columns, file.curves.shortest
    notes, place, candidates = list(table.notes), str(table.source), []
    names = [name for name in table.tables if fnmatch.fnmatchcase(name, tables)]
    if tables and not names:
        allowed = (
            "tables: " * bool(table.tables)
            + (", ".join(table.tables[:5]) or "one table only")
            + (" and more" if len(table.tables) > 5 else "")
        )
        raise InputError(
            "does not match any table of the log", path="log.tables", value=tables, allowed=allowed
        )
    for part in [f"{name}/" for name in names] if tables else [""]:
        u = _signal(table, part, columns.input, "input", "length", file.kind)
        f = _signal(table, part, columns.output, "output", "force", file.kind)
        number = _column(table, part, columns.curve, "curve") if columns.curve else np.zeros(u.size)
        if u.size != f.size:
            raise InputError(
                f"has {u.size} samples of the input but {f.size} of the output", path=place
            )
        if number.size != u.size:
            raise InputError(
                f"has {number.size} samples, but the input has {u.size}", path=f"{place}: curve"
            )
        starts = np.flatnonzero(np.diff(number)) + 1
        candidates += [
            Curve(*pair) for pair in zip(np.split(u, starts), np.split(f, starts), strict=True)
        ]
    chosen = [curve for curve in candidates if curve.u.size >= shortest]
    if not chosen:
        raise InputError(
            "has only curves with too few samples",
            path=place,
            value=f"{len(candidates)} curves",
            allowed=f"at least {shortest} samples per curve",
        )
    if len(chosen) < len(candidates):
        notes.append(
            f"bristle ignores {len(candidates) - len(chosen)} curves with fewer than {shortest} samples"
        )
    if np.ptp(np.concatenate([curve.u for curve in chosen])) < SMALLEST:
        raise InputError(
            "is constant, so it cannot be the input",
            path=f"{place}: {columns.input.column}",
            mend="Name the column of the input",
        )
    return Curves(
        tuple(chosen),
        file.curves.start,
        file.kind,
        table.source,
        table.origin,
        tuple(notes),
        file.name,
    )


def _signal(
    table: Table, part: str, column: SignalEntry, key: str, quantity: str, kind: Kind
) -> np.ndarray:
    values = _column(table, part, column.column, key)
    place = f"{table.source}: column {part}{column.column}"
    unit = column.unit or table.units.get(table.name_of(part + column.column) or "", "")
    values = (
        column.sign
        * (units.factor(unit, unit_of(quantity, kind), path=place) if unit else 1.0)
        * values
    )
    bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
    if bad.size:
        message = (
            "is not a valid measurement"
            if np.isfinite(values[bad[0]])
            else "is not a finite number"
        )
        raise InputError(
            message,
            path=f"{place}[{bad[0]}]",
            value=float(values[bad[0]]),
            mend="End the curve before this sample, or correct the sample",
        )
    return values


def _column(table: Table, part: str, name: str, key: str) -> np.ndarray:
    stored_name = table.name_of(part + name)
    if stored_name is None:
        raise table.missing(part + name, key)
    return np.asarray(table.columns[stored_name], dtype=float)
