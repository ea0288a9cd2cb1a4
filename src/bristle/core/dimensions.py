"""Quantities as products of powers, such as ``force*time^2/length^2``, and their units on each kind of axis.

A quantity is written from the names of `NAMES` with ``*``, ``/``, powers such as ``^2`` or ``^0.5``, and one level of
brackets. Quantities are *generalised*: `force` is a force [N] on a translational axis and a torque [N*m] on a
rotational axis. For a hysteresis operator of a magnet, `length` is the field [T] and `force` the moment [A*m^2].
For a piezo actuator, `length` is the voltage [V] and `force` the displacement [m].
"""

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, get_args

from bristle.core.errors import InputError, did_you_mean

AxisKind = Literal["translational", "rotational"]
Kind = Literal["translational", "rotational", "magnetic", "piezo"]
"""Kinds of axis; the kinds magnet and piezo actuator are only for hysteresis operators."""
KINDS: tuple[Kind, ...] = ("translational", "rotational")  # of axes


class Name(NamedTuple):
    """A named quantity: its SI unit on each kind of axis, and the product that defines it, if any."""

    translational: str
    rotational: str
    magnetic: str
    piezo: str
    product: str = ""


NAMES = {
    "mass of travel": Name("kg", "kg", "kg", "kg", "force of travel*time^2/travel"),
    "force of travel": Name("N", "N", "N", "N"),
    "mass": Name("kg", "kg*m^2", "A*m^2*s^2/T", "m*s^2/V", "force*time^2/length"),
    "force": Name("N", "N*m", "A*m^2", "m"),
    # Linear on every kind of axis: the table of a ball screw.
    "travel": Name("m", "m", "m", "m"),
    "length": Name("m", "rad", "T", "V"),
    "time": Name("s", "s", "s", "s"),
    "frequency": Name("Hz", "Hz", "Hz", "Hz", "1/time"),
    "temperature": Name("K", "K", "K", "K"),
}
"""Names of the factors of quantities, in their order of writing."""
# Order of symbols in a unit, including the units of a drive.
SYMBOLS = ("kg", "N", "V", "A", "rated", "m", "rad", "T", "s", "Hz", "count", "K")
HIGHEST, LONGEST = 9.0, 200  # power in a unit, and characters of a quantity
WITHOUT_NAME = {
    "torque": "force",
    "angle": "length",
    "position": "length",
    "distance": "length",
    "inertia": "mass",
    "velocity": "length/time",
    "speed": "length/time",
    "acceleration": "length/time^2",
    "stiffness": "force/length",
}
EXAMPLE = 'Write a product such as "force*time^2/length^2"'


def grammar(name: str) -> re.Pattern[str]:
    """Return the pattern of products of names: ``*``, ``/``, powers, and one level of brackets."""
    factor = rf"{name}(?:\^-?\d(?:\.5)?)?"
    part = rf"(?:{factor}|\({factor}(?:[*/]{factor})*\))"
    return re.compile(rf"{part}(?:[*/]{part})*")


_GRAMMAR = grammar(r"(?:1|[A-Za-z]+(?: [A-Za-z]+)*)")
_STEP = re.compile(r"([*/]?)(\(?)([^*/^()]+)(?:\^(-?[\d.]+))?(\)?)")


def canonical(quantity: Any) -> str:
    """Return the canonical spelling of a quantity."""
    if not isinstance(quantity, str):
        raise InputError(
            "must be text that names a quantity", value=quantity, allowed=_allowed(), mend=EXAMPLE
        )
    return _canonical(quantity)


@lru_cache(maxsize=512)
def _canonical(quantity: str) -> str:
    powers = _names_in(quantity)
    for kind in KINDS:
        if any(abs(power) > HIGHEST for power in _expanded(powers, _units(kind)).values()):
            raise InputError(
                "has too high a power",
                value=quantity,
                allowed=f"powers up to {HIGHEST:g} in its unit",
                mend=EXAMPLE,
            )
    return written(powers, NAMES)


@lru_cache(maxsize=512)
def exponents_of(quantity: str) -> Mapping[str, float]:
    """Return the power of each base quantity in a quantity, without powers of 0."""
    return MappingProxyType(
        _expanded(
            _names_in(quantity), {name: entry.product or name for name, entry in NAMES.items()}
        )
    )


@lru_cache(maxsize=512)
def _unit_of(quantity: str, kind: Kind, *counted: tuple[str, str]) -> str:
    return written(_expanded(_names_in(quantity), _units(kind) | dict(counted)), SYMBOLS)


def unit_of(quantity: str, kind: Kind = "translational", **counted: str) -> str:
    """Return the SI unit of a generalised quantity on an axis of this kind.

    Parameters
    ----------
    quantity : str
        A product of powers of `NAMES`, such as ``"force/length"``.
    kind : {"translational", "rotational", "magnetic", "piezo"}
        The kind of axis.
    **counted : str
        Units for quantities that are not in SI units, such as ``force="V"``.

    Returns
    -------
    str
        The unit in the spelling of pint.

    Raises
    ------
    InputError
        If it is not a quantity.

    Examples
    --------
    >>> unit_of("force/length"), unit_of("force/length", "rotational"), unit_of("force", "magnetic")
    ('N/m', 'N*m/rad', 'A*m^2')
    >>> unit_of("force*time^2/length^2"), unit_of("force/length/time", "rotational")
    ('N*s^2/m^2', 'N*m/(rad*s)')
    >>> unit_of("force*time/length", force="V", length="rad")
    'V*s/rad'
    """
    return _unit_of(quantity, kind, *counted.items())


def unit_elsewhere(unit: str, own: Kind, foreign: Kind) -> str | None:
    """Convert a unit of an axis of the kind `own` to the kind `foreign`; None if it is not a unit of an axis."""
    rest = factors_of(unit) if _GRAMMAR.fullmatch(unit) else {unit: 1.0}
    powers = {}
    for name in ("mass", "force", "length", "time", "frequency", "temperature"):
        symbols = factors_of(unit_of(name, own))
        powers[name] = rest.get(next(iter(symbols)), 0.0)
        rest = total(
            [*rest.items(), *((symbol, -powers[name] * power) for symbol, power in symbols.items())]
        )
    return None if rest else unit_of(written(powers, NAMES), foreign)


def _units(kind: Kind) -> dict[str, str]:
    if kind not in get_args(Kind):
        raise InputError(
            "is not a valid choice", path="kind", value=kind, allowed=", ".join(get_args(Kind))
        )
    return {name: getattr(entry, kind) for name, entry in NAMES.items()}


def _expanded(powers: Mapping[str, float], products: Mapping[str, str]) -> dict[str, float]:
    """Return the power of each factor after each name is replaced by its product."""
    return total(
        (part, power * inner)
        for name, power in powers.items()
        for part, inner in factors_of(products[name]).items()
    )


def _names_in(quantity: str) -> dict[str, float]:
    """Return the power of each name in a quantity; refuse invalid text."""
    text = re.sub(r"\s*([*/^()])\s*", r"\1", quantity[:LONGEST].strip().replace("**", "^"))
    if len(quantity) > LONGEST or not _GRAMMAR.fullmatch(text):
        raise InputError("is not a quantity", value=quantity, allowed=_allowed(), mend=EXAMPLE)
    powers = factors_of(text)
    for name in powers:
        if name not in NAMES:
            reason, without = (
                f"is not a quantity: {name!r} is unknown",
                WITHOUT_NAME.get(name.lower()),
            )
            mend = (
                f'Write "{without}" for {name}'
                if without
                else did_you_mean(name, NAMES) or f"{EXAMPLE}, not its unit"
            )
            raise InputError(reason, value=quantity, allowed=_allowed(), mend=mend)
    return powers


def _allowed() -> str:
    names = sorted(NAMES, key=lambda name: ("travel" in name, NAMES[name].product != ""))
    return f"1, or a product of powers of {', '.join(names)}"


def factors_of(product: str) -> dict[str, float]:
    """Return the power of each factor of a product in the grammar."""
    factors, bracket = [], 1.0
    for operator, opened, name, power, closed in _STEP.findall(product):
        side = -1.0 if operator == "/" else 1.0
        if opened:
            side, bracket = 1.0, side
        factors.append((name, bracket * side * float(power or 1.0)))
        if closed:
            bracket = 1.0
    return total((name, power) for name, power in factors if name != "1")


def total(powers: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Return the sum of the powers of each name, without powers of 0."""
    summed: dict[str, float] = {}
    for name, power in powers:
        summed[name] = summed.get(name, 0.0) + power
    return {name: power for name, power in summed.items() if power}


def written(powers: Mapping[str, float], order: Iterable[str]) -> str:
    """Write a product with its factors in this order and at most one slash."""
    places = {name: place for place, name in enumerate(order)}
    sorted_powers = sorted(powers.items(), key=lambda factor: places.get(factor[0], len(places)))
    above = [_raised(name, power) for name, power in sorted_powers if power > 0.0]
    below = [_raised(name, -power) for name, power in sorted_powers if power < 0.0]
    product, divisor = "*".join(above) or "1", "*".join(below)
    return f"{product}/({divisor})" if len(below) > 1 else f"{product}/{divisor}".removesuffix("/")


def _raised(name: str, power: float) -> str:
    return name if power == 1.0 else f"{name}^{power:g}"
