"""`Variable`: the one description of a quantity from which bounds, schemas, tables, captions and units derive."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from bristle.core.dimensions import KINDS, Kind, canonical, unit_of  # noqa: F401  (asked for here)
from bristle.core.errors import InputError, did_you_mean, located

OF_SLOTS = ("place", "load", "temperature", "channel")  # What a log must contain for what only a slot has; the last of one's own
EXCITATIONS = ("", "sliding", "speed", "stribeck", "presliding", "displacement", "acceleration", *OF_SLOTS, "drive")
"""What a log may have to contain for a parameter to be identified from it."""


@dataclass(frozen=True)
class Variable:
    """One quantity: what it is, its generalised unit and its range.

    Parameters
    ----------
    quantity : str
        Generalised quantity: a product of powers of the names in `bristle.core.dimensions`, such as
        ``"force*time^2/length^2"``. It is kept in one spelling.
    description : str
        What it is, in a few words.
    min, max : float
        Smallest and largest value allowed, in SI.
    nominal : float
        Typical magnitude, in SI: the scale of a search where a log gives none, and what a check of the contract
        takes for a model without an example.
    directional : bool
        Whether it may differ between the directions of motion (the slot ``+asymmetry``).
    excitation : str
        What a log must contain for the quantity to be identified from it: one of `EXCITATIONS`, which an empty one
        is among.
    choices : tuple of str
        Where the quantity is one of several names: what a person writes. Kernels receive its place in this tuple.

    Raises
    ------
    InputError
        If the quantity or the excitation is none.

    Examples
    --------
    >>> Variable("force*time^2/length^2", "drag over the square of the speed").unit("rotational")
    'N*m*s^2/rad^2'
    """

    quantity: str
    description: str = ""
    min: float = -math.inf
    max: float = math.inf
    nominal: float = 1.0
    directional: bool = False
    excitation: str = ""
    choices: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.description:
            mend = 'Write both, Variable("force", "Coulomb friction force")'
            raise InputError("lacks its quantity or its description", path=f"Variable({self.quantity!r})", mend=mend)
        with located(f"quantity of {self.description!r}"):
            object.__setattr__(self, "quantity", canonical(self.quantity))
        if self.excitation not in EXCITATIONS:
            place, allowed = f"excitation of {self.description!r}", f"{', '.join(EXCITATIONS[1:])}, or empty"
            mend = did_you_mean(self.excitation, EXCITATIONS[1:])
            raise InputError("is no excitation", path=place, value=self.excitation, allowed=allowed, mend=mend)

    def unit(self, kind: Kind = "translational") -> str:
        """Return the SI unit on an axis of this kind."""
        return unit_of(self.quantity, kind)

    def allowed(self, kind: Kind = "translational") -> str:
        """Return the allowed range in words, with its unit."""
        if self.choices:
            return ", ".join(self.choices)
        unit = "" if self.quantity == "1" else f" {self.unit(kind)}"
        by_end = {  # without a smallest value, without a largest one
            (True, True): f"any number{unit and ' in'}{unit}",
            (False, True): f">= {self.min:g}{unit}",
            (True, False): f"<= {self.max:g}{unit}",
            (False, False): f"{self.min:g} to {self.max:g}{unit}",
        }
        return by_end[math.isinf(self.min), math.isinf(self.max)]

    def code(self, value: Any, path: str) -> int:
        """Return the place of a name among the choices.

        Raises
        ------
        InputError
            If it is none of them.
        """
        if value not in self.choices:
            mend = did_you_mean(value, self.choices)
            raise InputError("is none of the choices", path=path, value=value, allowed=self.allowed(), mend=mend)
        return self.choices.index(value)

    def written(self, value: Any) -> Any:
        """Return what a person writes for a value that kernels receive: the name of a choice, else the value."""
        return self.choices[value] if self.choices else value

    def validate(self, value: Any, path: str, kind: Kind = "translational") -> None:
        """Refuse a value that is not a number or lies outside the range.

        Raises
        ------
        InputError
            With the path, the value, and the range allowed. Infinity lies in a range without end, so it passes
            here: where only some parameters may be infinite, the caller refuses it.
        """
        for index, number in enumerate(value if hasattr(value, "__len__") else (value,)):
            place = f"{path}[{index}]" if hasattr(value, "__len__") else path
            if math.isnan(number):
                raise InputError("is not a number", path=place, value=float(number), allowed=self.allowed(kind))
            if not self.min <= number <= self.max:
                raise InputError("out of range", path=place, value=float(number), allowed=self.allowed(kind))


def variables_of(cls: type) -> dict[str, Variable]:
    """Return the `Variable` of each annotated field of a NamedTuple, in order.

    Raises
    ------
    TypeError
        If a field carries no `Variable`.
    """
    return dict(_variables(cls))


def is_array(cls: type, field: str) -> bool:
    """Return whether this field of a NamedTuple holds a 1-D array rather than a scalar."""
    return _base_of(cls, field) not in (float, int)


def is_integer(cls: type, field: str) -> bool:
    """Return whether this field of a NamedTuple holds a whole number."""
    return _base_of(cls, field) is int


@cache
def _base_of(cls: type, field: str) -> Any:
    hint = _hints(cls)[field]
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


@cache
def _variables(cls: type) -> tuple[tuple[str, Variable], ...]:
    hints = _hints(cls)
    variables = []
    for name in getattr(cls, "_fields", ()):
        marks = get_args(hints[name])[1:] if get_origin(hints[name]) is Annotated else ()
        variable = next((mark for mark in marks if isinstance(mark, Variable)), None)
        if variable is None:
            raise TypeError(f"{cls.__module__}.{cls.__qualname__}.{name} has no Variable in its annotation")
        variables.append((name, variable))
    return tuple(variables)


@cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)
