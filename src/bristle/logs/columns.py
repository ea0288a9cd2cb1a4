"""Logs from what a person has at hand: data frames, data sets, arrays by name.

Tables are told by what they can do, never by their class: no library is imported for it that is not there already.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import units
from bristle.core.axis import CHANNELS, Axis, Column, Injected
from bristle.core.edge import KIND, amount, instance, optional
from bristle.core.errors import InputError, did_you_mean, told_by
from bristle.core.values import looked_at, shown
from bristle.core.variable import KINDS, Kind, Variable, unit_of
from bristle.logs.choice import USUAL_NAMES
from bristle.logs.log import Log
from bristle.logs.read import log_of
from bristle.logs.table import Table, some_of

__all__ = ["is_table", "log_of_columns", "table_of"]

# What a log cannot do without may be called otherwise; of the rest any letter may stand for something else.
NAMES = {name: (USUAL_NAMES[name] if name in ("time", "position", "effort") else (name,)) for name in CHANNELS}
KNOWN_INPUT = "injected."
PLACE = "columns"
SOURCE = Path("<columns>")
MEND = 'Give a data frame or a dictionary with the columns "time", "position" and "effort"'
PERIOD = optional(amount(Variable("time", "time between samples", min=0.0), exclusive=True))
AXIS = optional(instance(Axis, "an axis"))


def log_of_columns(given: Any, *, axis: Axis | None = None, kind: str | None = None, sample_time: Any = None) -> Log:
    """Return the log in a table of columns; `Log.from_columns` tells more."""
    said: Axis | None = looked_at(AXIS, axis, "axis", None)
    chosen: Kind | None = looked_at(optional(KIND), kind, "kind", None)
    period = looked_at(PERIOD, sample_time, "sample_time", None)
    table = looked_at(lambda one, path, kind: table_of(one), given, PLACE, None)
    by_name = said is None or not said.columns
    used = said or Axis(kind=chosen or _kind_of(table))
    if by_name:
        used = _axis_of(table, used)
        table = replace(table, notes=tuple(_told(table, used)))
    if chosen is not None and used.kind != chosen:
        raise InputError("is not that of the axis", path="kind", value=chosen, allowed=used.kind)
    log = log_of(table, used if period is None else replace(used, sample_time=period))
    known = (replace(one, column=one.column.removeprefix(KNOWN_INPUT)) for one in log.injected)
    return replace(log, injected=tuple(known)) if by_name else log


def is_table(given: Any) -> bool:
    """Return whether something is a dictionary, a data frame, a data set or an array with named fields.

    Examples
    --------
    >>> is_table({"time": [0.0, 1.0]}), is_table("log.csv"), is_table([0.0, 1.0])
    (True, False, False)
    """
    named = getattr(getattr(given, "dtype", None), "names", None)
    frame = any(hasattr(given, name) for name in ("columns", "column_names", "variables", "collect_schema"))
    return isinstance(given, Mapping) or bool(named) or (frame and hasattr(given, "__getitem__"))


def table_of(given: Any) -> Table:
    """Return the columns of numbers in a data frame, a data set, a record array or a mapping.

    Raises
    ------
    InputError
        If it is no table, or holds no columns.
    """
    said, found = _columns_of(given)
    texts: dict[str, InputError] = {}
    columns: dict[str, np.ndarray] = {}
    units_: dict[str, str] = {name: str(unit) for name, unit in said.items() if isinstance(unit, str)}
    for name, values in found.items():
        try:
            columns[name] = _numbers(values, name)
        except InputError as error:
            texts[name] = error
        unit = _unit_of(values)
        if unit:
            units_[name] = unit
    return Table(columns, units_, texts=texts, source=SOURCE, names=tuple(columns))


def _columns_of(given: Any) -> tuple[Mapping[str, Any], dict[str, Any]]:
    """Return the units that a table says of all its columns, and the columns by name."""
    if callable(collect := getattr(given, "collect", None)):  # a frame that was only asked for so far
        given = collect()
    attributes = getattr(given, "attrs", None)
    said = attributes.get("units", {}) if isinstance(attributes, Mapping) else {}
    names = getattr(getattr(given, "dtype", None), "names", None)  # an array with named fields
    for one in ("variables", "column_names", "columns"):  # of xarray, of pyarrow, of pandas and polars
        names = names or (getattr(given, one, None) if not isinstance(given, Mapping) or one == "variables" else None)
    if names is None and isinstance(given, Mapping):
        names = list(given)
    if names is None or isinstance(names, str) or not hasattr(given, "__getitem__"):
        raise InputError("is no table of columns", path=PLACE, value=shown(given), mend=MEND)
    found = {str(name): given[name] for name in names}
    index = getattr(given, "index", None)
    if index is not None and not callable(index) and not set(NAMES["time"]) & {name.lower() for name in found}:
        dates = getattr(getattr(index, "dtype", None), "kind", "") in ("M", "m")
        found |= {"time": index} if dates or str(getattr(index, "name", "")).lower() in NAMES["time"] else {}
    return said if isinstance(said, Mapping) else {}, found


def _unit_of(values: Any) -> str:
    """Return the unit that a column says itself: in its attributes, or as a quantity with units."""
    attributes = getattr(values, "attrs", None)
    said = attributes.get("units") if isinstance(attributes, Mapping) else None
    if said is None and hasattr(values, "magnitude"):
        said = str(values.units).replace(" ", "").replace("**", "^")
    return said if isinstance(said, str) else ""


def _numbers(values: Any, name: str) -> np.ndarray:
    """Return a column as numbers; dates as seconds from the first.

    Raises
    ------
    InputError
        If it is not 1-D, or holds what is no number.
    """
    where = f"{SOURCE}: column {name!r}"
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=where, mend="Fill them, or delete their rows: a gap is understood")
    to_numpy: Callable[[], Any] | None = getattr(values, "to_numpy", None)
    found = np.asarray(to_numpy() if to_numpy is not None else getattr(values, "magnitude", values))
    if found.ndim != 1:
        raise InputError("must be 1-D", path=where, value=f"an array of shape {found.shape}",
                         mend="Give each signal a column of its own")  # fmt: skip
    if found.dtype.kind in "mM":
        return (found - found[:1]) / np.timedelta64(1, "s")
    if found.dtype.kind not in "fiubO":
        raise InputError("holds no numbers", path=where, value=found[0] if found.size else None)
    try:
        return found.astype(float)
    except (TypeError, ValueError) as error:
        odd = next((i for i, one in enumerate(found) if not _is_number(one)), 0)
        raise InputError(
            f"holds no number at sample {odd} ({told_by(error)})", path=where, value=found[odd],
            mend="Repair these samples or delete their rows: a gap in time is understood",
        ) from None  # fmt: skip


def _is_number(one: Any) -> bool:
    try:
        np.array([one], dtype=object).astype(float)
    except (TypeError, ValueError):
        return False
    return True


def _named(names: Iterable[str], channel: str) -> str | None:
    """Return the column that is called as a channel: by its name first, then as it usually is."""
    spelt = {name.lower(): name for name in reversed(list(names))}
    return next((spelt[usual] for usual in NAMES[channel] if usual in spelt), None)


def _told(table: Table, axis: Axis) -> Iterator[str]:
    """Yield what is to be known of the choice of columns."""
    yield from (f"column {one.name} is taken as the {name}" for name, one in axis.columns.items() if one.name != name)
    used = {one.name for one in axis.columns.values()} | {one.column for one in axis.injected}
    left = [name for name in (*table.names, *table.texts) if name not in used]
    if left:
        yield f"columns that are not used: {some_of(left)}"


def _kind_of(table: Table) -> Kind:
    unit = table.units.get(_named(table.names, "position") or "", "m")
    return KINDS[1] if units.compatible(unit, "rad", path=str(SOURCE)) else KINDS[0]


def _axis_of(table: Table, axis: Axis) -> Axis:
    """Return the axis with the columns of a table that are called as channels are, in SI unless they say otherwise."""
    columns = {}
    for channel, quantity in CHANNELS.items():
        name, base = _named((*table.names, *table.texts), channel), unit_of(quantity, axis.kind)
        if name is not None and name in table.texts:
            raise table.texts[name]
        if name is not None:
            columns[channel] = Column(name, table.units.get(name, base), base)
    if "position" not in columns:
        close = next((meant for name in table.names if (meant := did_you_mean(name, NAMES["position"]))), "")
        raise InputError(
            "has no column of the position", path=PLACE, value=some_of(table.names, 40) or "no columns",
            allowed=", ".join(CHANNELS), mend=close or "Rename it to position, or give an axis",
        )  # fmt: skip
    known = tuple(Injected(name, 1.0) for name in table.names if name.startswith(KNOWN_INPUT))
    return replace(axis, columns=columns, injected=known)
