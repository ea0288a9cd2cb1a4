"""Convert text with units to numbers in SI units.

Angle and count are separate dimensions, a torque is not an energy, and ``Nm`` is newton metre. Units that differ from SI
by a power of ten are converted exactly. The unit library, which evaluates its input, converts the others, but only after
the grammar of units has accepted them.
"""

import math
import numbers
import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, cast

from bristle.core.dimensions import (
    KINDS,
    LONGEST,
    SYMBOLS,
    Kind,
    factors_of,
    grammar,
    total,
    unit_elsewhere,
    written,
)
from bristle.core.errors import InputError, located
from bristle.core.variable import Variable

ENERGY_UNITS = frozenset(
    {"joule", "calorie", "electron_volt", "british_thermal_unit", "erg", "watt_hour"}
)

_EXAMPLE = 'Write a number and a unit, such as "7 um", "40 mN*m", "3000 rpm" or "0.5 ms"'
_SHARES = {"%": -2, "‰": -3}
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)(.*)", re.DOTALL)
LARGEST = (
    1e100  # limit for quantities of an axis, so that products of a few of them do not overflow
)
LONGEST_UNIT = 64
_GRAMMAR = grammar(r"(?:[^\W\d_]\w*|%|‰|1)")
_DECIMALS = {
    f"{prefix}{si}": (si, power)
    for prefix, power in {"n": -9, "u": -6, "m": -3, "c": -2, "": 0, "k": 3}.items()
    for si in SYMBOLS
    if si not in ("kg", "T")
}
_DECIMALS |= {
    "kg": ("kg", 0),
    "g": ("kg", -3),
    "%": ("rated", -2),
    "‰": ("rated", -3),
    "1": ("1", 0),
}
_PRODUCTS = {"N": "kg*m/s^2", "Hz": "1/s", "V": "kg*m^2/(s^3*A)"}
_SPELLINGS = (
    (re.compile("[µμ]"), "u"),  # the micro sign and the Greek letter
    (re.compile("[·⋅×]"), "*"),
    (re.compile(r"\*\*"), "^"),
    (re.compile("²"), "^2"),
    (re.compile("°"), "deg"),
    (re.compile(r"\b(?:permille|promille)\b"), "‰"),
    (re.compile(r"\s*([*/^])\s*"), r"\1"),
    (re.compile(r"\s+"), "*"),
    (re.compile(r"\b([numkM]?N)(c?m)\b"), r"\1*\2"),  # the unit library reads Nm as another unit
)


class Scale(NamedTuple):
    """A unit that differs from SI by a power of ten: its SI unit, this power, and the powers of its base units."""

    si: str
    power: int
    base: dict[str, float]


@lru_cache(maxsize=512)
def _decimal(unit: str) -> Scale | None:
    """Parse a unit that differs from SI by a power of ten; None for any other unit."""
    factors = (
        factors_of(unit)
        if len(unit) <= LONGEST_UNIT and _GRAMMAR.fullmatch(unit)
        else {unit: 1.0}
        if unit
        else {}
    )
    power = (
        sum(_DECIMALS[name][1] * exponent for name, exponent in factors.items())
        if factors.keys() <= _DECIMALS.keys()
        else 0.5
    )
    if not float(power).is_integer():
        return None
    in_si = total((_DECIMALS[name][0], exponent) for name, exponent in factors.items())
    base = total(
        (part, exponent * inner)
        for name, exponent in in_si.items()
        for part, inner in factors_of(_PRODUCTS.get(name, name)).items()
    )
    return Scale(written(in_si, SYMBOLS), int(power), base)


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    # Separate base dimensions: rad/s and 1/s, rad and count, N*m/rad and N*m all differ. They are part of the definitions
    # of the library, because the effect of a later redefinition depends on earlier look-ups.
    folder = Path(pint.__file__).parent
    lines = (folder / "constants_en.txt").read_text(encoding="utf-8").splitlines()
    for line in (folder / "default_en.txt").read_text(encoding="utf-8").splitlines():
        head = next((head for head in OWN_DIMENSIONS if line.startswith(head)), None)
        if head is not None:
            lines.append(OWN_DIMENSIONS[head] + line[len(head) :])
        elif not line.startswith("@import"):
            lines.append(line)
    return pint.UnitRegistry(cast("Any", [*lines, *OWN_UNITS]), autoconvert_offset_to_baseunit=True)


OWN_DIMENSIONS = {"radian = []": "radian = [angle]", "count = []": "count = [count]"}
OWN_UNITS = (
    "rated = [rated_effort]",
    "percent_rated = 0.01 * rated",
    "permille_rated = 0.001 * rated",
    "@alias turn = rev",
)


def quantity(
    value: Any,
    variable: Variable,
    kind: Kind = "translational",
    *,
    path: str = "",
    infinite: bool = False,
) -> float:
    """Convert a value to a number in SI units for the kind of axis."""
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, str)):
        raise InputError(
            f"must be a number, or text with a unit, for {variable.description!r}",
            path=path,
            value=value,
        )
    try:
        number = float(value)
    except OverflowError:
        raise InputError(
            "is too large for a floating-point number", path=path, mend="Check the unit"
        ) from None
    except ValueError:
        number = convert(str(value), variable.unit(kind), path=path)
    if not (infinite and math.isinf(number)):
        refuse_absurd(number, path, value)
    return number


def refuse_absurd(number: float, path: str, value: Any = None) -> None:
    """Refuse numbers that are not finite or absurdly large."""
    value = number if value is None else value
    if not math.isfinite(number):
        raise InputError("must be a finite number", path=path, value=value)
    if abs(number) > LARGEST:
        raise InputError(
            "is too large",
            path=path,
            value=value,
            allowed=f"up to {LARGEST:g} in SI units",
            mend="Check the unit",
        )


def convert(text: str, unit: str, *, path: str = "") -> float:
    """Convert text with a unit to a number in `unit`."""
    number, source_unit = split(text, path)
    allowed = "a number without a unit" if unit == "1" else f"a value in {unit}"
    if not source_unit and unit != "1":
        raise InputError("has no unit", path=path, value=text, allowed=allowed, mend=_EXAMPLE)
    if source_unit in _SHARES and unit == "1":
        return float(Decimal(number).scaleb(_SHARES[source_unit]))
    source, target = _decimal(source_unit), _decimal(unit)
    if (
        source
        and target
        and source.base == target.base
        and not (unit == "1/s" and "Hz" in source_unit)
    ):
        return float(Decimal(number).scaleb(source.power - target.power))
    if source_unit in ("", "1"):
        return float(number)
    if not compatible(source_unit, unit, path=path) or _misnamed(source_unit, unit):
        raise InputError(
            "has the wrong unit",
            path=path,
            value=text,
            allowed=allowed,
            mend=_mend(source_unit, unit),
        )
    return float(_registry().Quantity(float(number), _unit(source_unit)).to(_unit(unit)).magnitude)


def factor(unit: str, target: str, *, path: str = "") -> float:
    """Return the factor from `unit` to `target`."""
    with located(value=unit):
        return convert(f"1 {unit}", target, path=path)


def compatible(unit: str, target: str, *, path: str = "") -> bool:
    """Return whether `unit` has the dimension of `target`."""
    spelt = _spelt(unit)
    source, target_unit = _decimal(spelt), _decimal(target)
    if source and target_unit:
        return source.base == target_unit.base
    with located(path=path, value=unit, mend=_EXAMPLE):
        return _unit(spelt).dimensionality == _unit(target).dimensionality


def like(unit: str | None, targets: Iterable[str], *, per: str = "", path: str = "") -> str | None:
    """Return the first target, each followed by `per`, with the dimension of a unit; None without a match."""
    return next(
        (target for target in targets if unit and compatible(unit, target + per, path=path)), None
    )


def si_of(unit: str, *, path: str = "") -> str:
    """Return the SI unit of a unit without a known quantity; ``%`` and ``‰`` are plain fractions."""
    spelt = _spelt(unit)
    if spelt in _SHARES:
        return "1"
    if (decimal := _decimal(spelt)) is not None:
        return decimal.si
    with located(path=path, value=unit, mend=_EXAMPLE):
        return _spelt(f"{_registry().get_base_units(_unit(spelt))[1]:~C}") or "1"


def is_decimal(unit: str) -> bool:
    """Return whether a unit in canonical spelling differs from SI by a power of ten."""
    decimal = _decimal(unit)
    return decimal is not None and decimal.si != "1"


def is_unit(text: str) -> bool:
    """Return whether `text` is a unit."""
    if _decimal(_spelt(text)) is not None:
        return True
    # ambiguous: a thousandth of an inch, or a 6400th of a turn
    if text.strip().lower() in ("mil", "mils"):
        return False
    try:
        _unit(_spelt(text))
    except InputError:
        return False
    return True


def kind_of(values: Mapping[str, Any], variables: Mapping[str, Variable]) -> Kind:
    """Return the kind of axis according to the units of some values; translational by default."""
    for name, value in values.items():
        variable = variables.get(name)
        if not isinstance(value, str) or variable is None or variable.choices:
            continue
        _, unit = split(value, name)
        fits: list[Kind] = [
            kind for kind in KINDS if unit and compatible(unit, variable.unit(kind), path=name)
        ]
        if len(fits) == 1:
            return fits[0]
    return "translational"


def split(text: str, path: str = "") -> tuple[str, str]:
    """Split text into a number and a unit in canonical spelling, both as text."""
    if len(text.strip()) > LONGEST:
        raise InputError(
            "is too long for a number with a unit", path=path, value=text, mend=_EXAMPLE
        )
    match = _NUMBER.fullmatch(text.strip())
    if not match:
        raise InputError("is not a number with a unit", path=path, value=text, mend=_EXAMPLE)
    number, rest = match.groups()
    if re.match(r",\d", rest):
        raise InputError(
            "has a decimal comma",
            path=path,
            value=text,
            mend=f"Write {text.replace(',', '.', 1)!r}",
        )
    return number, _spelt(rest)


def _spelt(unit: str) -> str:
    unit = unit.strip()
    if len(unit) > LONGEST_UNIT:
        return unit
    for pattern, plain in _SPELLINGS:
        unit = pattern.sub(plain, unit)
    return unit


@lru_cache(maxsize=512)
def _unit(text: str) -> Any:
    spelt = _spelt(text)
    if spelt and (len(spelt) > LONGEST_UNIT or not _GRAMMAR.fullmatch(spelt)):
        raise InputError("is not a unit", value=text)
    try:
        return _registry().parse_units(
            ""
            if spelt == "1"
            else spelt.replace("%", "percent_rated").replace("‰", "permille_rated")
        )
    except Exception:  # noqa: BLE001  (the tokenizer of the library raises many kinds of errors)
        raise InputError("is not a unit", value=text) from None


def _names(unit: str) -> set[str]:
    """Return the units of a compound unit, in full and without prefixes."""
    registry = _registry()
    return {part for name in _unit(unit)._units for _, part, _ in registry.parse_unit_name(name)}


def _misnamed(source_unit: str, unit: str) -> bool:
    """Return whether the quantity differs although the dimension is right."""
    if "N*m" in unit:
        return bool(_names(source_unit) & ENERGY_UNITS)
    return unit == "1/s" and "hertz" in _names(source_unit)


def _mend(source_unit: str, unit: str) -> str:
    names, dimensions = _names(source_unit), dict(_unit(source_unit).dimensionality)
    is_frequency, turns = dimensions == {"[time]": -1}, dimensions == {"[angle]": 1, "[time]": -1}
    confusions = (
        (
            names & ENERGY_UNITS and "N*m" in unit,
            'An energy is not a torque: write newton times metre, such as "40 mN*m"',
        ),
        (
            "count" in names,
            'Counts need a resolution: write the length or angle instead, with for example "0.125 um" per count',
        ),
        (
            is_frequency and unit == "rad/s",
            'A frequency is not an angular velocity: write rad/s, rev/s or rpm, such as "3000 rpm"',
        ),
        (
            "hertz" in names and unit == "1/s",
            "A gain is not a frequency: write the gain in 1/s (2 pi times a corner frequency)",
        ),
        (
            turns and unit == "Hz",
            "An angular velocity is not a frequency: divide rad/s by 2 pi and write Hz",
        ),
        (
            names & {"percent_rated", "permille_rated"},
            "Percent needs the rated effort: write `rated` in [effort] of the axis file",
        ),
    )
    for is_confused, mend in confusions:
        if is_confused:
            return mend
    for own_kind, unit_kind in (KINDS, KINDS[::-1]):
        elsewhere = unit_elsewhere(unit, own_kind, unit_kind)
        if elsewhere not in (None, unit) and compatible(source_unit, elsewhere):
            return f"This unit is for a {unit_kind} axis, but this axis is {own_kind}. Use {unit}"
    if "rad" in unit and not any("angle" in name for name in dimensions):
        return f"Include the angle on a rotational axis: write {unit}"
    return "Write a number without a unit" if unit == "1" else f"Use {unit} or a multiple of {unit}"
