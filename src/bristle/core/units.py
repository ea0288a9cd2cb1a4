"""The edge where units as people write them become numbers in SI.

Files and the command line take text such as ``"7 um"``, ``"40 mN*m"`` or ``"3000 rpm"``; bare numbers are SI of the
kind of axis. Three traps of unit libraries are closed here: an angle is a dimension of its own, so that 60 Hz is not
60 rad/s and 40000 counts are not 40000 rad; and a torque is not an energy, so that 0.04 J is refused where
0.04 N*m is meant.
"""

from __future__ import annotations

import numbers
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from bristle.core.errors import InputError
from bristle.core.variable import KINDS, Kind, Variable

__all__ = ["convert", "factor", "kind_of", "parse", "quantity"]

ENERGY_UNITS = frozenset({"joule", "calorie", "electron_volt", "british_thermal_unit", "erg", "watt_hour"})


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    registry = pint.UnitRegistry(cache_folder=":auto:", autoconvert_offset_to_baseunit=True)
    # An angle is a base dimension: rad/s and 1/s, rad and count, N*m/rad and N*m all differ.
    registry.define("radian = [angle] = rad")
    registry.define("rated = [rated_effort]")
    return registry


def parse(text: str, path: str = "") -> Any:
    """Return text such as ``"40 mN*m"`` as a quantity of the unit library.

    Raises
    ------
    InputError
        If the text is not a number with a unit.
    """
    import pint

    try:
        value = _registry().parse_expression(text.replace("%", "*0.01*rated") if "%" in text else text)
    except (pint.errors.PintError, ValueError, TypeError, AttributeError, SyntaxError, ZeroDivisionError) as error:
        raise InputError(f"is not a number with a unit ({error})", path=path, value=text, mend=_EXAMPLE) from None
    except Exception as error:  # noqa: BLE001  (the library's tokenizer raises what it likes on odd text)
        raise InputError(f"is not a number with a unit ({error})", path=path, value=text, mend=_EXAMPLE) from None
    if isinstance(value, numbers.Number):
        return _registry().Quantity(value, "dimensionless")
    return value


_EXAMPLE = 'Write a number and a unit, such as "7 um", "40 mN*m", "3000 rpm" or "0.5 ms"'


def quantity(value: Any, variable: Variable, kind: Kind = "translational", *, path: str = "") -> float:
    """Return a value as a number in SI of the kind of axis.

    Parameters
    ----------
    value : float or str
        A number in SI already, or text with a unit.
    variable : Variable
        What the value is.
    kind : {"translational", "rotational"}
        The kind of axis.
    path : str
        Where the value stands, for the message.

    Returns
    -------
    float
        The value in ``variable.unit(kind)``.

    Raises
    ------
    InputError
        If the text has no unit where one is needed, or another dimension.

    Examples
    --------
    >>> quantity("7 um", Variable("length", "break-away distance"))
    7e-06
    """
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, str)):
        raise InputError(f"must be a number, or text with a unit ({variable.description})", path=path, value=value)
    if not isinstance(value, str):
        return float(value)
    try:
        return float(value)
    except ValueError:
        return convert(value, variable.unit(kind), path=path)


def convert(text: str, unit: str, *, path: str = "") -> float:
    """Return text with a unit as a number in `unit`.

    Raises
    ------
    InputError
        If the dimensions differ; the message says what the text is and what is wanted.
    """
    import pint

    given = parse(text, path)
    wanted = _registry().Unit("dimensionless" if unit == "1" else unit)
    if given.units.dimensionless and unit != "1":
        raise InputError("has no unit", path=path, value=text, allowed=f"a value in {unit}", mend=_EXAMPLE)
    _refuse_energy(given, unit, text, path)
    try:
        return float(given.to(wanted).magnitude)
    except pint.errors.DimensionalityError:
        raise InputError("has the wrong unit", path=path, value=text, allowed=f"a value in {unit}",
                         mend=_mend(given, unit)) from None  # fmt: skip


def factor(unit: str, target: str, *, path: str = "") -> float:
    """Return by what a number in `unit` is multiplied to be in `target`."""
    return convert(f"1 {unit}", target, path=path)


def kind_of(values: Mapping[str, Any], variables: Mapping[str, Variable]) -> Kind:
    """Return the kind of axis that the units of some values speak of; translational where none does."""
    for name, value in values.items():
        variable = variables.get(name)
        if not isinstance(value, str) or variable is None:
            continue
        given = parse(value, name)
        for kind in KINDS:
            here = _registry().Unit(variable.unit(kind).replace("1/s", "1/s"))
            other = variable.unit(KINDS[1 - KINDS.index(kind)])
            if variable.unit(kind) != other and given.dimensionality == here.dimensionality:
                return kind
    return "translational"


def _refuse_energy(given: Any, unit: str, text: str, path: str) -> None:
    named = {str(part) for part, _ in given.units._units.items()}
    base = {name.removeprefix("milli").removeprefix("micro").removeprefix("kilo") for name in named}
    if base & ENERGY_UNITS and "N*m" in unit:
        raise InputError(
            "is an energy, not a torque", path=path, value=text, allowed=f"a value in {unit}",
            mend='Write a torque as newton times metre, such as "40 mN*m"',
        )  # fmt: skip


def _mend(given: Any, unit: str) -> str:
    dimensions = {str(k): v for k, v in given.dimensionality.items()}
    if dimensions == {"[time]": -1} and unit == "rad/s":
        return 'A frequency is not an angular velocity: write "60 rad/s", "60 rev/s" or "3000 rpm"'
    if dimensions == {"[angle]": 1, "[time]": -1} and unit == "Hz":
        return 'An angular velocity is not a frequency: write it in Hz'
    if given.units == _registry().Unit("count"):
        return 'Counts need a resolution: write the length or angle of one count, such as "0.125 um"'
    if "rad" in unit and "[angle]" not in dimensions:
        return f"On a rotational axis the angle is written: {unit}"
    return f"Write it in {unit} or a multiple of it"
