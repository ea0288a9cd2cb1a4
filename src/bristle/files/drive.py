"""From what the columns of a log count in to SI of the axis: units, constants of the drive, counts, gear and lead."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bristle.core import units
from bristle.core.axis import COLUMNS, Column
from bristle.core.errors import InputError, did_you_mean
from bristle.core.motion import Side, Transmission
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.schema import AxisFile, ColumnEntry

MOVEMENTS: dict[str, Kind] = {"m": KINDS[0], "rad": KINDS[1]}
"""Unit of a movement -> the kind of axis that it speaks of."""
EFFORTS: dict[str, Kind] = {"N": KINDS[0], "N*m": KINDS[1]}
DRIVE_UNITS = ("V", "A", "rated", "count")


@dataclass(frozen=True)
class Scale:
    """SI of the axis for one `base`; numbers in other units are first converted to `base`."""

    base: str
    factor: float

    def of(self, text: str, path: str) -> float:
        """Return text with a unit in SI of the axis."""
        return units.convert(text, self.base, path=path) * self.factor


@dataclass(frozen=True)
class Constant:
    """Force or torque for one unit of the drive: `value` in `effort` for one `drive`."""

    drive: str
    effort: str
    value: float

    @classmethod
    def of(cls, text: str, effort: str | None, path: str) -> Constant:
        """Return the constant that a text such as ``"0.12 N*m/A"`` tells; without `effort` its unit says which it is of."""
        unit = units.split(text, path)[1]
        told = [f"{spoken_of}/{drive}" for spoken_of in (EFFORTS if effort is None else (effort,)) for drive in DRIVE_UNITS]
        if (base := units.like(unit, told, path=path)) is not None:
            value = units.convert(text, base, path=path)
            if value == 0 or not math.isfinite(value):
                raise InputError("must be finite and not zero", path=path, value=text)
            spoken_of, _, drive = base.rpartition("/")
            return cls(drive, spoken_of, value)
        allowed = 'a force or a torque for one unit of the drive, such as "61.2 N/A"'
        if effort is not None:
            allowed = f"a value in {effort}/V, {effort}/A, {effort}/% or {effort}/count"
        raise InputError("is not the constant of a drive", path=path, value=text, allowed=allowed)


@dataclass(frozen=True)
class Drive:
    """All that is known of how the numbers of a drive relate to its axis."""

    transmission: Transmission
    constant: Constant | None = None
    rated: str | None = None
    count: float | None = None

    def effort(self, unit: str | None, side: Side | None, path: str) -> Scale:
        """Return the scale of an effort in `unit`; None is the unit that the constant speaks of, else SI."""
        if unit is None:
            unit = self.constant.drive if self.constant else self._si(EFFORTS)
        if (base := units.like(unit, EFFORTS, path=path)) is not None:
            units.factor(unit, base, path=path)
            return Scale(base, self._carried(path, EFFORTS[base], self._side(EFFORTS[base], side, path), effort=True))
        if (base := units.like(unit, DRIVE_UNITS, path=path)) is None:
            raise InputError(
                "is not the unit of an effort", path=path, value=unit, allowed="N, N*m, or with a constant under [effort] V, A, %, count"
            )
        if base == "rated" and self.rated is not None:
            return self._percent(side)
        if self.constant is None:
            mend = 'Write rated = "2.4 N*m"' if base == "rated" else f'Write constant = "0.12 N*m/{base}"'
            raise InputError("is no effort by itself", path=path, value=unit, mend=f"{mend} under [effort]")
        if base != self.constant.drive:
            raise InputError(
                "does not match the constant under [effort]",
                path=path,
                value=unit,
                allowed=f"{self.constant.drive.replace('rated', '%')} or a multiple",
            )
        measured = EFFORTS[self.constant.effort]
        return Scale(base, self.constant.value * self._carried(path, measured, side or "motor", effort=True))

    def movement(self, unit: str | None, side: Side | None, path: str, *, per: str = "") -> Scale:
        """Return the scale of a position in `unit`, or with ``per="/s"`` a velocity; None is SI of the axis."""
        unit = unit if unit is not None else self._si(MOVEMENTS) + per
        if (base := units.like(unit, MOVEMENTS, per=per, path=path)) is not None:
            return Scale(base + per, self._carried(path, MOVEMENTS[base], self._side(MOVEMENTS[base], side, path), effort=False))
        if units.compatible(unit, "count" + per, path=path):
            if self.count is None:
                raise InputError(
                    "needs to know what a count is",
                    path=path,
                    value=unit,
                    mend='Write resolution = "0.125 um" (for one count) or counts_per_rev under [encoder]',
                )
            return Scale("count" + per, self.count)
        units.factor(unit, self._si(MOVEMENTS) + per, path=path)
        raise InputError("is not the unit of a movement", path=path, value=unit)

    def _percent(self, side: Side | None) -> Scale:
        """Return the scale of percent of the rated effort, which a drive tells for its motor."""
        path, text = "effort.rated", self.rated or ""
        _, unit = units.split(text, path)
        if not unit or units.compatible(unit, "rated", path=path):
            raise InputError("is no effort", path=path, value=text, mend='Write it as "2.4 N*m" or "3 A"')
        linear = units.compatible(unit, "N", path=path)
        value = self.effort(unit, None if linear else side or "motor", path).of(text, path)
        if not 0 < abs(value) < math.inf:
            raise InputError("must be finite and not zero", path=path, value=text)
        return Scale("rated", value)

    def _si(self, table: dict[str, Kind]) -> str:
        return next(unit for unit, kind in table.items() if kind == self.transmission.kind)

    def _side(self, measured: Kind, side: Side | None, path: str) -> Side:
        if measured == "translational" and side == "motor":
            raise InputError("is linear, so it is not on the motor's side of a gear", path=path, mend="Leave side out")
        if measured == "rotational" and side is None and self.transmission.gear_ratio != 1:
            raise InputError(
                "does not say on which side of the gear it is measured",
                path=path,
                allowed="motor or load",
                mend='Write side = "motor" or side = "load"',
            )
        return side or "load"

    def _carried(self, path: str, measured: Kind, side: Side, *, effort: bool) -> float:
        try:
            carry = self.transmission.effort if effort else self.transmission.travel
            return carry(measured, side)
        except InputError as error:
            message = error.message.replace("an angle", "a torque").replace("a travel", "a force") if effort else error.message
            raise InputError(message, path=path, mend=error.mend) from None


def with_kind(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of an axis file with the kind of axis that its units speak of, where it names none."""
    if "kind" in data:
        return dict(data)
    kind = (
        _of_movement(_entry_at(data, "columns", "position", "unit"))
        or _of_movement(_unit_of(_entry_at(data, "encoder", "resolution")))
        or _of_movement(_entry_at(data, "columns", "velocity", "unit"), per="/s")
    )
    if kind is None and _entry_at(data, "encoder", "counts_per_rev") is not None:
        kind = KINDS[0] if _entry_at(data, "transmission", "lead") is not None else KINDS[1]
    return dict(data) if kind is None else {**data, "kind": kind}


def _entry_at(data: Any, *path: str) -> Any:
    for key in path:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data


def _unit_of(quantity: Any) -> str | None:
    try:
        return units.split(quantity.removesuffix("/count"))[1] if isinstance(quantity, str) else None
    except ValueError:
        return None


def _of_movement(unit: Any, per: str = "") -> Kind | None:
    is_unit = isinstance(unit, str) and units.is_unit(unit)
    return MOVEMENTS.get(units.like(unit, MOVEMENTS, per=per) or "") if is_unit else None


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
