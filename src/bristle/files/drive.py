"""From what a drive reports to SI of the axis: constants, percent of rated, counts, gear and lead."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle.core import units
from bristle.core.errors import InputError
from bristle.core.transmission import Side, Transmission
from bristle.core.variable import KINDS, Kind

__all__ = ["Constant", "Drive", "Scale"]

# Unit of what is measured -> which kind of movement or effort it is.
MOVEMENTS: dict[str, Kind] = {"m": KINDS[0], "rad": KINDS[1]}
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
    def of(cls, text: str, effort: str, path: str) -> Constant:
        """Return the constant that a text such as ``"0.12 N*m/A"`` tells; `effort` is ``"N"`` or ``"N*m"``."""
        _, unit = units.split(text, path)
        for drive in DRIVE_UNITS:
            if unit and units.compatible(unit, f"{effort}/{drive}", path=path):
                value = units.convert(text, f"{effort}/{drive}", path=path)
                if value == 0 or not math.isfinite(value):
                    raise InputError("must be finite and not zero", path=path, value=text)
                return cls(drive, effort, value)
        raise InputError(
            "is not the constant of a drive",
            path=path,
            value=text,
            allowed=f"a value in {effort}/V, {effort}/A, {effort}/% or {effort}/count",
        )

    @classmethod
    def whichever(cls, text: str, path: str) -> Constant:
        """Return the constant that a text tells, of a force or of a torque: its unit says which."""
        _, unit = units.split(text, path)
        turns = any(unit and units.compatible(unit, f"N*m/{drive}", path=path) for drive in DRIVE_UNITS)
        if not turns and not any(unit and units.compatible(unit, f"N/{drive}", path=path) for drive in DRIVE_UNITS):
            raise InputError(
                "is not the constant of a drive",
                path=path,
                value=text,
                allowed='a force or a torque for one unit of the drive, such as "61.2 N/A"',
            )
        return cls.of(text, "N*m" if turns else "N", path)


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
        for base, measured in EFFORTS.items():
            if units.compatible(unit, base, path=path):
                units.factor(unit, base, path=path)
                resolved = self._side(measured, side, path)
                return Scale(base, self._carried(path, measured, resolved, effort=True))
        base = next((base for base in DRIVE_UNITS if units.compatible(unit, base, path=path)), None)
        if base is None:
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
        for base, measured in MOVEMENTS.items():
            if units.compatible(unit, base + per, path=path):
                resolved = self._side(measured, side, path)
                return Scale(base + per, self._carried(path, measured, resolved, effort=False))
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
