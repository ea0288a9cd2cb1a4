"""Columns of what surrounds an axis: the load on its guides, the temperature, and further channels of slots."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from bristle.core import units
from bristle.core.axis import COLUMNS, Column
from bristle.core.errors import InputError, did_you_mean
from bristle.core.variable import Variable
from bristle.files.axis_schema import AxisFile, ColumnEntry

__all__ = ["refuse_misspelt", "surroundings_of"]

LOAD = Variable("force", "nominal load")
CELSIUS = ("degC", "°C", "celsius")
ZERO_CELSIUS = 273.15  # [K]


def surroundings_of(file: AxisFile) -> dict[str, Column]:
    """Return the columns of load and temperature that an axis file names, and those of further channels."""
    return {
        name: OF_BRISTLE[name](entry, file) if name in OF_BRISTLE else _further(name, entry)
        for name, entry in (file.columns.model_extra or {}).items()
    }


def refuse_misspelt(columns: object) -> None:
    """Refuse a column whose name is nearly one of those that bristle knows, before one of those is told to be missing."""
    for name in columns if isinstance(columns, Mapping) else ():
        if name not in COLUMNS and _is_misspelt(name):
            raise InputError("unknown key", path=f"columns.{name}", allowed=", ".join(COLUMNS), mend=did_you_mean(name, COLUMNS))


def _is_misspelt(name: str) -> bool:
    return bool(did_you_mean(name, COLUMNS)) and not any(channel in name for channel in COLUMNS)


def _further(name: str, entry: ColumnEntry) -> Column:
    """Return the column of a channel that bristle knows nothing of; a misspelt one is told from it by its unit."""
    path, close = f"columns.{name}", did_you_mean(name, COLUMNS)
    if entry.unit is None or _is_misspelt(name) or not name.isidentifier():
        raise InputError(
            "unknown key",
            path=path,
            allowed=", ".join(COLUMNS),
            mend=close
            or f'A further channel, for a slot that depends on it, has its unit: {name} = {{ column = "{entry.column}", unit = "%" }}',
        )
    if entry.unit in CELSIUS:
        return _in_kelvin(entry, f"{path}.unit")
    base = units.si_of(entry.unit, path=f"{path}.unit")
    _refuse_zero_elsewhere(entry.unit, base, f"{path}.unit")
    return Column(entry.column, entry.unit, base, float(entry.sign), entry.optional)


def _refuse_zero_elsewhere(unit: str, base: str, path: str) -> None:
    """Refuse a unit whose zero is not that of its SI unit: no factor makes one of the other."""
    if units.convert(f"0 {unit}", base, path=path) != 0.0:
        raise InputError("has a zero of its own", path=path, value=unit, allowed=f"degC, or a multiple of {base}")


def _load(entry: ColumnEntry, file: AxisFile) -> Column:
    raw, path = file.plant.nominal_load, "plant.nominal_load"
    if raw is None:
        raise InputError("is missing: a load counts as a multiple of it", path=path, mend='Write nominal_load = "500 N" under [plant]')
    # A load is a force on a rotational axis too.
    nominal = units.quantity(raw, LOAD, "translational", path=path)
    if not 0.0 < nominal < math.inf:
        raise InputError("must be positive and finite", path=path, value=raw, allowed="> 0 N")
    if entry.unit is not None:
        units.factor(entry.unit, "N", path="columns.load.unit")
    return Column(entry.column, entry.unit or "", "N", entry.sign / nominal, entry.optional)


def _temperature(entry: ColumnEntry, file: AxisFile) -> Column:
    return _in_kelvin(entry, "columns.temperature.unit")


OF_BRISTLE: dict[str, Callable[[ColumnEntry, AxisFile], Column]] = {"load": _load, "temperature": _temperature}
"""Channels whose numbers count otherwise than in their unit."""


def _in_kelvin(entry: ColumnEntry, path: str) -> Column:
    if entry.unit in CELSIUS:
        return Column(entry.column, "", "", 1.0, entry.optional, ZERO_CELSIUS)
    if entry.unit is not None:
        units.factor(entry.unit, "K", path=path)
        _refuse_zero_elsewhere(entry.unit, "K", path)
    return Column(entry.column, entry.unit or "", "K", 1.0, entry.optional)
