"""Conversion and checks of user values; thresholds with default, unit and range."""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, NamedTuple, Self

import numpy as np

from bristle.core.documented import Documented
from bristle.core.errors import BristleError, InputError, InputWarning, did_you_mean, error_text
from bristle.core.former import FORMER
from bristle.core.typography import typed
from bristle.core.variable import Kind, Variable

Converter = Callable[[Any, str, Any], Any]
"""Function of a value, the name of its argument and the kind of axis, if known, that returns the converted value."""

LARGEST_COUNT = 2**53  # a float cannot represent all larger whole numbers


def looked_at(convert: Converter, value: Any, path: str, kind: Kind | None) -> Any:
    """Call a converter; convert any error of a foreign value to an `InputError`."""
    try:
        return convert(value, path, kind)
    except BristleError:
        raise
    except Exception as error:  # noqa: BLE001
        raise InputError(
            f"cannot be read ({type(error).__name__}: {error_text(error)})", path=path, value=value
        ) from None


def shown(value: Any) -> Any:
    """Return the form of a value for a message: None as text, because a message omits None."""
    return "None" if value is None else value


def check_relations(
    component: Documented, parameters: Any, path: str, *, structural_only: bool = False
) -> None:
    """Refuse parameters that violate a relation of the component; warn for an advisory relation."""
    for relation in component.relations:
        if (structural_only and not relation.structural) or relation.holds(parameters):
            continue
        names = [
            name
            for name in component.variables
            if name.split("_pos")[0].split("_neg")[0] in relation.condition
        ]
        values = component.values(parameters)
        facts = ", ".join(f"{name} = {typed(values[name])}" for name in names) or "it does not hold"
        if relation.advisory:
            warnings.warn(
                f"{path}: should have {relation.condition}, but {facts}. {relation.mend}",
                InputWarning,
                stacklevel=4,
            )
        else:
            allowed = relation.allowed(parameters) if relation.allowed else ""
            raise InputError(
                f"needs {relation.condition}, but {facts}",
                path=path,
                allowed=allowed,
                mend=relation.mend,
            )


def coerced(
    component: Documented, name: str, variable: Variable, value: Any, path: str, kind: Kind
) -> Any:
    """Convert a user value for kernels: to a number in SI units, a 1-D array, or the index of a choice."""
    from bristle.core import units

    if variable.choices:
        return variable.code(value, path)
    if component.is_integer(name):
        number = units.quantity(value, variable, kind, path=path)
        if not number.is_integer() or abs(number) > LARGEST_COUNT:
            raise InputError(
                "must be a whole number up to 2^53",
                path=path,
                value=value,
                allowed=variable.allowed(kind),
            )
        return int(number)
    if component.is_array(name):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__len__"):
            raise InputError("must be a list of numbers", path=path, value=value)
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind == "f":
            numbers = value.astype(float)
            for odd in numbers[~(np.abs(numbers) <= units.LARGEST)][:1]:
                units.refuse_absurd(float(odd), path)
            return numbers
        return np.array(
            [units.quantity(number, variable, kind, path=path) for number in value], dtype=float
        )
    return units.quantity(value, variable, kind, path=path, infinite=True)


def check_value(
    component: Documented, name: str, variable: Variable, value: Any, kind: Kind, path: str
) -> None:
    """Refuse a number that is not finite or out of range; an infinite default is accepted."""
    default = component.defaults.get(name)
    may_be_infinite = isinstance(default, float) and math.isinf(default)
    if not np.all(np.isfinite(value)) and not (may_be_infinite and value == default):
        raise InputError(
            "is not a finite number",
            path=path,
            value=float(np.max(value)),
            allowed=variable.allowed(kind),
        )
    variable.validate(value, path, kind)


def numbers_of(component: Documented, parameters: Any) -> dict[str, Any]:
    """Return user values in the form for kernels, with the index of each choice."""
    variables = component.variables
    return {
        name: variables[name].code(value, name) if variables[name].choices else value
        for name, value in component.values(parameters).items()
    }


class Threshold(NamedTuple):
    """Default, unit, meaning, range and source of a setting."""

    name: str
    default: float
    unit: str
    meaning: str
    least: float
    most: float
    source: str


def threshold(
    default: float,
    meaning: str,
    unit: str = "1",
    least: float = 0.0,
    most: float = math.inf,
    source: str = "",
) -> Any:
    """Return a field of a dataclass for a threshold."""
    about = {
        "default": default,
        "meaning": meaning,
        "unit": unit,
        "least": least,
        "most": most,
        "source": source,
    }
    return field(default=default, metadata=about)


@dataclass(frozen=True)
class Thresholds:
    """Base of dataclasses of thresholds."""

    @classmethod
    @cache
    def described(cls) -> tuple[Threshold, ...]:
        """Return the descriptions of the thresholds, in order."""
        return tuple(Threshold(entry.name, **entry.metadata) for entry in fields(cls))

    @classmethod
    def of(cls, values: Mapping[str, Any], path: str = "settings") -> Self:
        """Return thresholds with these values; other thresholds keep their defaults."""
        by_name = {entry.name: entry for entry in cls.described()}
        numbers: dict[str, float] = {}
        for name, value in values.items():
            if name not in by_name:
                raise InputError(
                    "is not a threshold of an identification",
                    path=f"{path}.{name}",
                    value=value,
                    allowed=", ".join(by_name),
                    mend=f"{did_you_mean(name, by_name)} {FORMER['settings.*']}".lstrip(),
                )
            entry = by_name[name]
            number = (
                value
                if isinstance(value, (int, float)) and not isinstance(value, bool)
                else math.nan
            )
            if not (entry.least <= number <= entry.most and math.isfinite(number)):
                allowed = (
                    f"{entry.least:g} to {entry.most:g}"
                    if math.isfinite(entry.most)
                    else f">= {entry.least:g}"
                )
                raise InputError(
                    "is out of range", path=f"{path}.{name}", value=value, allowed=allowed
                )
            numbers[name] = float(number)
        return cls(**numbers)

    @classmethod
    def among(cls, values: Mapping[str, Any], path: str = "settings") -> Self:
        """Return the thresholds of this class: from `values` where it names them, else their defaults."""
        names = {entry.name for entry in cls.described()}
        return cls.of({name: value for name, value in values.items() if name in names}, path)

    @property
    def changed(self) -> dict[str, float]:
        """Values that differ from the defaults, by name."""
        return {
            entry.name: value
            for entry in self.described()
            if (value := getattr(self, entry.name)) != entry.default
        }

    def as_data(self) -> dict[str, float]:
        """Return all values by name."""
        return {entry.name: getattr(self, entry.name) for entry in self.described()}
