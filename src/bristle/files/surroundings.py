"""Columns of what surrounds an axis: the load on its guides, the temperature."""

from __future__ import annotations

import math

from bristle.core import units
from bristle.core.axis import Column
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.files.axis_schema import AxisFile, ColumnEntry

__all__ = ["surroundings_of"]

LOAD = Variable("force", "nominal load")
CELSIUS = ("degC", "°C", "celsius")
ZERO_CELSIUS = 273.15  # [K]


def surroundings_of(file: AxisFile) -> dict[str, Column]:
    """Return the columns of load and temperature that an axis file names.

    Raises
    ------
    InputError
        If a unit does not fit, or there is a load and no nominal one.
    """
    ambient = {}
    if file.columns.load is not None:
        ambient["load"] = _load(file.columns.load, file)
    if file.columns.temperature is not None:
        ambient["temperature"] = _temperature(file.columns.temperature)
    return ambient


def _load(entry: ColumnEntry, file: AxisFile) -> Column:
    raw, path = file.plant.nominal_load, "plant.nominal_load"
    if raw is None:
        raise InputError("is missing: a load counts as a multiple of it", path=path,
                         mend='Write nominal_load = "500 N" under [plant]')  # fmt: skip
    # A load is a force on a rotational axis too.
    nominal = units.quantity(raw, LOAD, "translational", path=path)
    if not 0.0 < nominal < math.inf:
        raise InputError("must be positive and finite", path=path, value=raw, allowed="> 0 N")
    if entry.unit is not None:
        units.factor(entry.unit, "N", path="columns.load.unit")
    return Column(entry.column, entry.unit or "", "N", entry.sign / nominal, entry.optional)


def _temperature(entry: ColumnEntry) -> Column:
    if entry.unit in CELSIUS:
        return Column(entry.column, "", "", 1.0, entry.optional, ZERO_CELSIUS)
    if entry.unit is not None:
        units.factor(entry.unit, "K", path="columns.temperature.unit")
    return Column(entry.column, entry.unit or "", "K", 1.0, entry.optional)
