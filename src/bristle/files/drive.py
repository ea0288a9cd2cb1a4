"""Convert the numbers of a drive to SI units of the axis: units, drive constants, counts, gear and lead."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from bristle.core import InputError, did_you_mean, units
from bristle.core.axis import COLUMNS, COUPLING_EFFORT, Column
from bristle.core.motion import Side, Transmission
from bristle.core.variable import KINDS, Kind, Variable, unit_of
from bristle.files.schema import AxisFile, ColumnEntry

MOVEMENTS: dict[str, Kind] = {"m": KINDS[0], "rad": KINDS[1]}  # Unit of a movement -> kind of axis
EFFORTS: dict[str, Kind] = {"N": KINDS[0], "N*m": KINDS[1]}
DRIVE_UNITS = ("V", "A", "rated", "count")


@dataclass(frozen=True)
class Scale:
    """Value in SI units of the axis for one `base`; numbers in other units are first converted to `base`."""

    base: str
    factor: float

    def of(self, text: str, path: str) -> float:
        """Convert text with a unit to SI units of the axis."""
        return units.convert(text, self.base, path=path) * self.factor


@dataclass(frozen=True)
class Constant:
    """Force or torque per unit of the drive: `value` in `effort` for one `drive`."""

    drive: str
    effort: str
    value: float

    @classmethod
    def of(cls, text: str, effort: str | None, path: str, drive: str | None = None) -> Constant:
        """Parse a constant such as ``"0.12 N*m/A"``, of a `drive` unit; without `effort`, its unit decides between force and torque."""
        unit = units.split(text, path)[1]
        if not unit:
            efforts, drives = (
                [effort] if effort else EFFORTS,
                [drive] if drive else ["V", "A", "%", "count"],
            )
            allowed = " or ".join(f"{spoken_of}/{per}" for spoken_of in efforts for per in drives)
            raise InputError(
                "lacks its unit", path=path, value=text, mend=f"Add the unit: {allowed}"
            )
        bases = [
            f"{spoken_of}/{drive}"
            for spoken_of in (EFFORTS if effort is None else (effort,))
            for drive in DRIVE_UNITS
        ]
        if (base := units.like(unit, bases, path=path)) is None:
            allowed = 'a force or torque per unit of the drive, such as "61.2 N/A"'
            allowed = (
                allowed
                if effort is None
                else f"a value in {effort}/V, {effort}/A, {effort}/% or {effort}/count"
            )
            raise InputError("is not a drive constant", path=path, value=text, allowed=allowed)
        value = units.convert(text, base, path=path)
        if value == 0 or not math.isfinite(value):
            raise InputError("must be finite and not zero", path=path, value=text)
        spoken_of, _, drive = base.rpartition("/")
        return cls(drive, spoken_of, value)


@dataclass(frozen=True)
class Drive:
    """Known relations between the numbers of a drive and its axis."""

    transmission: Transmission
    constant: Constant | None = None
    rated: str | None = None
    count: float | None = None

    def effort(self, unit: str | None, side: Side | None, path: str) -> Scale:
        """Return the scale of an effort in `unit`; None is the unit of the drive constant, or else SI."""
        if unit is None:
            unit = (
                self.constant.drive if self.constant else unit_of("force", self.transmission.kind)
            )
        if (base := units.like(unit, EFFORTS, path=path)) is not None:
            units.factor(unit, base, path=path)
            return Scale(base, self._carried(path, EFFORTS[base], side, effort=True))
        if (base := units.like(unit, DRIVE_UNITS, path=path)) is None:
            raise InputError(
                "is not a unit of effort",
                path=path,
                value=unit,
                allowed="N or N*m; also V, A, % or count with a constant under [effort]",
            )
        if base == "rated" and self.rated is not None:  # the rated effort of the motor
            path, text = "effort.rated", self.rated
            _, own = units.split(text, path)
            if not own or units.compatible(own, "rated", path=path):
                raise InputError(
                    "is not an effort",
                    path=path,
                    value=text,
                    mend='Write an effort, such as "2.4 N*m" or "3 A"',
                )
            value = self.effort(
                own, None if units.compatible(own, "N", path=path) else side or "motor", path
            ).of(text, path)
            if not 0 < abs(value) < math.inf:
                raise InputError("must be finite and not zero", path=path, value=text)
            return Scale("rated", value)
        if self.constant is None:
            mend = (
                'Write rated = "2.4 N*m"'
                if base == "rated"
                else f'Write constant = "0.12 N*m/{base}"'
            )
            raise InputError(
                "needs a drive constant, which converts it to a force or torque",
                path=path,
                value=unit,
                mend=f"{mend} under [effort]",
            )
        if base != self.constant.drive:
            raise InputError(
                "does not match the constant under [effort]",
                path=path,
                value=unit,
                allowed=f"{self.constant.drive.replace('rated', '%')} or a multiple",
            )
        measured = EFFORTS[self.constant.effort]
        return Scale(
            base,
            self.constant.value
            * self._carried(path, measured, side or "motor", effort=True, of_drive=True),
        )

    def movement(self, unit: str | None, side: Side | None, path: str, *, per: str = "") -> Scale:
        """Return the scale of a position in `unit`, or of a velocity with ``per="/s"``; None is SI units."""
        si = unit_of("length", self.transmission.kind) + per
        unit = si if unit is None else unit
        if (base := units.like(unit, MOVEMENTS, per=per, path=path)) is not None:
            return Scale(base + per, self._carried(path, MOVEMENTS[base], side, effort=False))
        if not units.compatible(unit, "count" + per, path=path):
            units.factor(unit, si, path=path)
            raise InputError("is not a unit of movement", path=path, value=unit)
        if self.count is None:
            raise InputError(
                "needs the movement of the axis per count",
                path=path,
                value=unit,
                mend='Write resolution = "0.125 um" (for one count) or counts_per_rev under [encoder]',
            )
        return Scale("count" + per, self.count)

    def _carried(
        self, path: str, measured: Kind, side: Side | None, *, effort: bool, of_drive: bool = False
    ) -> float:
        if measured == "translational" and side == "motor" and not of_drive:
            raise InputError(
                "is a unit of length, but the motor side of a gear is rotational",
                path=path,
                mend="Remove the key `side`",
            )
        if measured == "rotational" and side is None and self.transmission.gear_ratio != 1:
            raise InputError(
                "has no key `side`, but a gear has a motor side and a load side",
                path=path,
                allowed="motor or load",
                mend='Write side = "motor" or side = "load"',
            )
        try:
            return (self.transmission.effort if effort else self.transmission.travel)(
                measured, side or "load"
            )
        except InputError as error:
            message = (
                error.message.replace("an angle", "a torque").replace("a travel", "a force")
                if effort
                else error.message
            )
            raise InputError(message, path=path, mend=error.mend) from None


def with_kind(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of an axis file; derive a missing kind of axis from the units."""
    if "kind" in data:
        return dict(data)

    def entry_at(*path: str) -> Any:
        entry: Any = data
        for key in path:
            entry = entry.get(key) if isinstance(entry, Mapping) else None
        return entry

    resolution = entry_at("encoder", "resolution")
    try:
        step = (
            units.split(resolution.removesuffix("/count"))[1]
            if isinstance(resolution, str)
            else None
        )
    except ValueError:
        step = None
    named = (
        (entry_at("columns", "position", "unit"), ""),
        (step, ""),
        (entry_at("columns", "velocity", "unit"), "/s"),
    )
    for unit, per in named:
        if (
            isinstance(unit, str)
            and units.is_unit(unit)
            and (base := units.like(unit, MOVEMENTS, per=per))
        ):
            return {**data, "kind": MOVEMENTS[base]}
    if entry_at("encoder", "counts_per_rev") is None:
        return dict(data)
    return {**data, "kind": KINDS[0] if entry_at("transmission", "lead") is not None else KINDS[1]}


def surroundings_of(file: AxisFile, drive: Drive) -> dict[str, Column]:
    """Return the columns of load, temperature, a sensor in the coupling and further channels in an axis file."""
    special = {"load": partial(_load, file=file), COUPLING_EFFORT: partial(_sensor, drive=drive)}
    return {
        name: special.get(name, partial(_further, name))(entry)
        for name, entry in (file.columns.model_extra or {}).items()
    }


def refuse_misspelt(columns: object) -> None:
    """Refuse a column with a misspelt name, before bristle reports a missing column."""
    for name in columns if isinstance(columns, Mapping) else ():
        if (
            name not in COLUMNS
            and not any(channel in name for channel in COLUMNS)
            and (close := did_you_mean(name, COLUMNS))
        ):
            raise InputError(
                "unknown key",
                path=f"columns.{name}",
                allowed=f"keys: {', '.join(COLUMNS)}",
                mend=close,
            )


def _load(entry: ColumnEntry, file: AxisFile) -> Column:
    raw, path = file.plant.nominal_load, "plant.nominal_load"
    if raw is None:
        raise InputError(
            "is missing, but bristle divides the load by this value",
            path=path,
            mend='Write nominal_load = "500 N" under [plant]',
        )
    # A load is a force on a rotational axis, too.
    nominal = units.quantity(raw, Variable("force", "nominal load"), "translational", path=path)
    if not 0.0 < nominal < math.inf:
        raise InputError("must be positive and finite", path=path, value=raw, allowed="> 0 N")
    if entry.unit is not None:
        units.factor(entry.unit, "N", path="columns.load.unit")
    return Column(entry.column, entry.unit or "", "N", entry.sign / nominal, entry.optional)


def _sensor(entry: ColumnEntry, drive: Drive) -> Column:
    """Return the column of a sensor of torque or force, which no drive constant converts."""
    unit, path = (
        entry.unit or unit_of("force", drive.transmission.kind),
        f"columns.{COUPLING_EFFORT}.unit",
    )
    if units.like(unit, EFFORTS, path=path) is None:
        raise InputError(
            "is not a unit of torque or force",
            path=path,
            value=unit,
            allowed="N or N*m, or a multiple",
        )
    scale = drive.effort(unit, entry.side, path)
    return Column(
        entry.column, entry.unit or "", scale.base, entry.sign * scale.factor, entry.optional
    )


def _further(name: str, entry: ColumnEntry) -> Column:
    """Return the column of a temperature, or of a further channel: its unit distinguishes it from a misspelt name."""
    path, is_temperature = f"columns.{name}.unit", name == "temperature"
    if not is_temperature and (entry.unit is None or not name.isidentifier()):
        further = f'A further channel for a slot needs a unit: {name} = {{ column = "{entry.column}", unit = "%" }}'
        mend = did_you_mean(name, COLUMNS) or further
        raise InputError(
            "unknown key", path=f"columns.{name}", allowed=f"keys: {', '.join(COLUMNS)}", mend=mend
        )
    if entry.unit in ("degC", "°C", "celsius"):
        return Column(entry.column, "", "", 1.0, entry.optional, 273.15)  # [K]
    base = "K" if is_temperature else units.si_of(entry.unit or "", path=path)
    if entry.unit is not None:
        units.factor(entry.unit, base, path=path)
        # A factor cannot convert a unit with another zero than its SI unit.
        if units.convert(f"0 {entry.unit}", base, path=path) != 0.0:
            raise InputError(
                "has a zero point that bristle cannot convert",
                path=path,
                value=entry.unit,
                allowed=f"degC, or a multiple of {base}",
            )
    return Column(
        entry.column,
        entry.unit or "",
        base,
        1.0 if is_temperature else float(entry.sign),
        entry.optional,
    )
