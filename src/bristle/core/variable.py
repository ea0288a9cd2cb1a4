"""`Variable`: description of a quantity, the source of bounds, schemas, tables, captions and units."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from bristle.core.dimensions import KINDS, Kind, canonical, unit_of  # noqa: F401  (re-exported)
from bristle.core.errors import InputError, did_you_mean, located

# Excitations for parameters of slots; the last is for user slots.
OF_SLOTS = ("place", "load", "temperature", "channel")
EXCITATIONS = (
    "",
    "sliding",
    "speed",
    "stribeck",
    "presliding",
    "displacement",
    "acceleration",
    *OF_SLOTS,
    "drive",
)
"""Excitations that the identification of a parameter may require."""


@dataclass(frozen=True)
class Variable:
    """A quantity: its description, generalised unit and range.

    Parameters
    ----------
    quantity : str
        Generalised quantity: a product of powers of the names in `bristle.core.dimensions`, such as
        ``"force*time^2/length^2"``. It is stored in canonical spelling.
    description : str
        Short description.
    min, max : float
        Smallest and largest value allowed, in SI.
    nominal : float
        Typical magnitude in SI units: the default scale of a search, and the value in a check of the contract for a
        model without an example.
    directional : bool
        Whether it may differ between the directions of motion (the slot ``+asymmetry``).
    excitation : str
        Excitation in a log that the identification of the quantity requires: one of `EXCITATIONS`, may be empty.
    choices : tuple of str
        Allowed names, for a quantity that is a choice. Kernels receive the index in this tuple.

    Raises
    ------
    InputError
        If the quantity or the excitation is invalid.

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
            raise InputError(
                "lacks the quantity or the description",
                path=f"Variable({self.quantity!r})",
                mend='Write both, such as Variable("force", "Coulomb friction force")',
            )
        with located(f"quantity of {self.description!r}"):
            object.__setattr__(self, "quantity", canonical(self.quantity))
        if not math.isfinite(self.nominal):
            raise InputError(
                "must be finite", path=f"nominal of {self.description!r}", value=self.nominal
            )
        if not self.min <= self.max:
            raise InputError(
                "is above max",
                path=f"min of {self.description!r}",
                value=self.min,
                allowed=f"<= {self.max:g}",
            )
        if self.excitation not in EXCITATIONS:
            place, allowed = (
                f"excitation of {self.description!r}",
                f"{', '.join(EXCITATIONS[1:])}, or empty text",
            )
            raise InputError(
                "is not an excitation",
                path=place,
                value=self.excitation,
                allowed=allowed,
                mend=did_you_mean(self.excitation, EXCITATIONS[1:]),
            )

    def unit(self, kind: Kind = "translational") -> str:
        """Return the SI unit on an axis of this kind."""
        return unit_of(self.quantity, kind)

    def allowed(self, kind: Kind = "translational") -> str:
        """Return the allowed range in words, with its unit."""
        if self.choices:
            return ", ".join(self.choices)
        unit = "" if self.quantity == "1" else f" {self.unit(kind)}"
        by_end = {  # (without a minimum, without a maximum)
            (True, True): f"any number{unit and ' in'}{unit}",
            (False, True): f">= {self.min:g}{unit}",
            (True, False): f"<= {self.max:g}{unit}",
            (False, False): f"{self.min:g} to {self.max:g}{unit}",
        }
        return by_end[math.isinf(self.min), math.isinf(self.max)]

    def code(self, value: Any, path: str) -> int:
        """Return the index of a name in the choices.

        Raises
        ------
        InputError
            If the name is not a choice.
        """
        if value not in self.choices:
            raise InputError(
                "is not a valid choice",
                path=path,
                value=value,
                allowed=self.allowed(),
                mend=did_you_mean(value, self.choices),
            )
        return self.choices.index(value)

    def written(self, value: Any) -> Any:
        """Return the user form of a kernel value: the name of a choice, or else the value."""
        return self.choices[value] if self.choices else value

    def validate(self, value: Any, path: str, kind: Kind = "translational") -> None:
        """Refuse a value that is not a number or lies outside the range.

        Raises
        ------
        InputError
            With the path, the value, and the allowed range. An unbounded range includes infinity; the caller must
            refuse it if necessary.
        """
        if (
            hasattr(value, "dtype")
            and value.size
            and self.min <= value.min()
            and value.max() <= self.max
        ):
            return  # an array, quickly
        for index, number in enumerate(value if hasattr(value, "__len__") else (value,)):
            place = f"{path}[{index}]" if hasattr(value, "__len__") else path
            if math.isnan(number):
                raise InputError(
                    "is not a number", path=place, value=float(number), allowed=self.allowed(kind)
                )
            if not self.min <= number <= self.max:
                raise InputError(
                    "out of range", path=place, value=float(number), allowed=self.allowed(kind)
                )


def variables_of(cls: type) -> dict[str, Variable]:
    """Return the `Variable` of each annotated field of a NamedTuple, in order.

    Raises
    ------
    TypeError
        If a field carries no `Variable`.
    """
    return dict(_variables(cls))


def is_array(cls: type, field: str) -> bool:
    """Return whether this field of a NamedTuple is a 1-D array rather than a scalar."""
    return _base_of(cls, field) not in (float, int)


def is_integer(cls: type, field: str) -> bool:
    """Return whether this field of a NamedTuple is a whole number."""
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
            raise TypeError(
                f"{cls.__module__}.{cls.__qualname__}.{name} has no Variable in its annotation"
            )
        variables.append((name, variable))
    return tuple(variables)


@cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)
