"""What a file says of recorded hysteresis: which columns are input and output, and how each curve began."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from bristle.core import units
from bristle.core.content import SIZE_LIMIT, Readable, size_of
from bristle.core.errors import located
from bristle.core.variable import Kind, unit_of
from bristle.files.components import check_schema
from bristle.files.schema import ColumnName, Signal, Strict, validated
from bristle.files.toml import read_toml
from bristle.logs.curves import CurveColumns, Curves, SignalColumn
from bristle.logs.curves import read_curves as curves_in


class Columns(Strict):
    """The signals of the curves."""

    input: Signal
    output: Signal
    curve: ColumnName = ""


class LogEntry(Strict):
    """Where in the file the curves are."""

    tables: str = ""


class CurvesEntry(Strict):
    """How each curve began, and which are too short."""

    start: Literal["virgin", "saturated"] = "virgin"
    shortest: Annotated[int, Field(ge=2)] = 2


class HysteresisFile(Strict):
    """A description of recorded hysteresis as a whole."""

    schema_version: Literal[1] = Field(alias="schema")
    name: str = "hysteresis"
    kind: Kind
    log: LogEntry = LogEntry()
    columns: Columns
    curves: CurvesEntry = CurvesEntry()


def describes_curves(path: Readable | dict[str, Any]) -> bool:
    """Return whether an axis file names the input and the output of a hysteresis, not the channels of an axis."""
    data = read_toml(path).data
    columns = data.get("columns")
    named = isinstance(columns, dict) and bool({"input", "output"} & set(columns)) and "position" not in columns
    return named or data.get("kind") in ("magnetic", "piezo")


def read_curve_columns(path: Readable | dict[str, Any]) -> CurveColumns:
    """Return where the curves are, as a file says it."""
    data, source, _ = read_toml(path, path="axis", what="a file that says where the curves are")
    with located(source):
        check_schema(data)
        file = validated(HysteresisFile, data)
        signals = {}
        for name, quantity in (("input", "length"), ("output", "force")):
            entry = getattr(file.columns, name)
            if entry.unit is not None:
                units.factor(entry.unit, unit_of(quantity, file.kind), path=f"columns.{name}.unit")
            signals[name] = SignalColumn(entry.column, entry.unit or "", float(entry.sign))
        begun, log, curve = file.curves, file.log, file.columns.curve
        return CurveColumns(
            **signals, kind=file.kind, start=begun.start, tables=log.tables, curve=curve, shortest=begun.shortest, name=file.name
        )


def read_curves(path: Readable, axis: CurveColumns | Readable | dict[str, Any], *, size_limit: int | str = SIZE_LIMIT) -> Curves:
    """Return recorded hysteresis: curves of input and output, in SI.

    Parameters
    ----------
    path : path-like, bytes or file object
        Any file that a log can be in.
    axis : CurveColumns, path-like or dict
        Where the curves are in it, or the file that says so.
    size_limit : int or str
        Largest file [byte], or text such as ``"2 GB"``.

    Raises
    ------
    InputError
        If the files cannot be used; the message names file, key or column, and the mend.
    """
    columns = axis if isinstance(axis, CurveColumns) else read_curve_columns(axis)
    return curves_in(path, columns, size_limit=size_of(size_limit))
