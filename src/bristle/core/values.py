"""Values that a person gives for the parameters of a component: turned into numbers, and held to their conditions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from bristle.core.documented import Described
from bristle.core.errors import BristleError, InputError, InputWarning, told_by
from bristle.core.typography import typed
from bristle.core.variable import Kind, Variable

Converter = Callable[[Any, str, Any], Any]
"""What takes a value, the name of its argument and the kind of axis where it is known, and returns what it is."""

LARGEST_COUNT = 2**53  # beyond, a float tells whole numbers apart no more


def looked_at(convert: Converter, value: Any, path: str, kind: Kind | None) -> Any:
    """Return what a converter makes of a value, whatever the value does while it is looked at."""
    try:
        return convert(value, path, kind)
    except BristleError:
        raise
    except Exception as error:  # noqa: BLE001
        reason = f"cannot be read ({type(error).__name__}: {told_by(error)})"
        raise InputError(reason, path=path, value=value) from None


def shown(value: Any) -> Any:
    """Return what a message shows of a value: of None its name, since it stands for nothing to show elsewhere."""
    return "None" if value is None else value


def check_relations(component: Described, parameters: Any, path: str, *, structural_only: bool = False) -> None:
    """Refuse parameters that break a relation of the component; warn of those that break an advisory one."""
    for relation in component.relations:
        if (structural_only and not relation.structural) or relation.holds(parameters):
            continue
        names = [name for name in component.variables if name.split("_pos")[0].split("_neg")[0] in relation.condition]
        values = component.values(parameters)
        facts = ", ".join(f"{name} = {typed(values[name])}" for name in names) or "it does not hold"
        if relation.advisory:
            message = f"{path}: should have {relation.condition}, but {facts}. {relation.mend}"
            warnings.warn(message, InputWarning, stacklevel=4)
        else:
            raise InputError(f"needs {relation.condition}, but {facts}", path=path, mend=relation.mend)


def coerced(component: Described, name: str, variable: Variable, value: Any, path: str, kind: Kind) -> Any:
    """Return a given value as kernels receive it: a number in SI, a 1-D array, or the place of a choice."""
    from bristle.core import units

    if variable.choices:
        return variable.code(value, path)
    if component.is_integer(name):
        number = units.quantity(value, variable, kind, path=path)
        if not number.is_integer() or abs(number) > LARGEST_COUNT:
            raise InputError("must be a whole number", path=path, value=value, allowed=variable.allowed(kind))
        return int(number)
    if component.is_array(name):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__len__"):
            raise InputError("must be a list of numbers", path=path, value=value)
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind == "f":
            numbers = value.astype(float)
            for odd in numbers[~(np.abs(numbers) <= units.LARGEST)][:1]:
                units.refuse_absurd(float(odd), path)
            return numbers
        return np.array([units.quantity(number, variable, kind, path=path) for number in value], dtype=float)
    return units.quantity(value, variable, kind, path=path, infinite=True)


def check_value(component: Described, name: str, variable: Variable, value: Any, kind: Kind, path: str) -> None:
    """Refuse a number that is not finite or out of range; a default that is infinite may stay so."""
    default = component.defaults.get(name)
    may_be_infinite = isinstance(default, float) and math.isinf(default)
    if not np.all(np.isfinite(value)) and not (may_be_infinite and value == default):
        raise InputError("is not a finite number", path=path, value=float(np.max(value)), allowed=variable.allowed(kind))
    variable.validate(value, path, kind)


def numbers_of(component: Described, parameters: Any) -> dict[str, Any]:
    """Return the values that a person sets as kernels receive them: a choice by its place."""
    variables = component.variables
    return {
        name: variables[name].code(value, name) if variables[name].choices else value
        for name, value in component.values(parameters).items()
    }
