"""Numbers with a unit for kernels, which are plain Python: every sum, comparison and function of them is checked.

The numbers are quantities of the unit library. A zero or an infinity that is written in a kernel has any unit, as the
start of a sum or the end of a range; any other number there has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pint

from bristle.core import units
from bristle.core.contracts import Component
from bristle.core.kernel import kernels
from bristle.core.motion import NOMINAL_TEMPERATURE
from bristle.core.variable import Variable, variables_of

Quantity: Any = units._registry().Quantity


class Measured(Quantity):
    """A number with its unit."""


def _checked(operation: str) -> Any:
    """Return an operation on numbers of one dimension, which others are refused."""

    def checked(self: Any, other: Any) -> Any:
        if _has_any_unit(other):
            other = Measured(other, self.units)
        if self.dimensionality != getattr(other, "dimensionality", Measured(1.0).dimensionality):
            raise pint.DimensionalityError(self.units, getattr(other, "units", "1"))
        return getattr(Quantity, operation)(self, other)

    return checked


def _scaled(operation: str) -> Any:
    """Return a product, or a quotient, in which a number that has any unit keeps that."""

    def scaled(self: Any, other: Any) -> Any:
        if _has_any_unit(other):
            return getattr(float, operation)(self.magnitude, other)
        return getattr(Quantity, operation)(self, other)

    return scaled


def _has_any_unit(x: Any) -> bool:
    return isinstance(x, float) and (x == 0.0 or math.isinf(x))


for name in ("add", "radd", "sub", "rsub", "lt", "le", "gt", "ge", "eq"):
    setattr(Measured, f"__{name}__", _checked(f"__{name}__"))
for name in ("mul", "rmul", "rtruediv"):
    setattr(Measured, f"__{name}__", _scaled(f"__{name}__"))


class Several(list):
    """An array of numbers with units, each with its own."""

    @property
    def size(self) -> int:
        return len(self)


class Mathematics:
    """What kernels call of the library of mathematics, for numbers with units."""

    pi, inf, nan = math.pi, math.inf, math.nan

    @staticmethod
    def copysign(x: Any, y: Any) -> Any:
        return abs(x) if math.copysign(1.0, plain(y)) > 0.0 else -abs(x)

    @staticmethod
    def sqrt(x: Any) -> Any:
        return x**0.5 if isinstance(x, Measured) else math.sqrt(x)

    @staticmethod
    def isinf(x: Any) -> bool:
        return math.isinf(plain(x))

    # These make a plain number of what they are given, and a number with a unit refuses to be one.
    ldexp, frexp = math.ldexp, math.frexp


def plain(x: Any) -> Any:
    """A number without its unit, in SI."""
    return x.to_base_units().magnitude if isinstance(x, Measured) else x


def let_kernels_measure(monkeypatch: Any) -> None:
    """Let the kernels compute with `Measured` numbers."""
    stand_ins = {"math": (math, Mathematics), "NOMINAL_TEMPERATURE": (NOMINAL_TEMPERATURE, Measured(293.15, "K"))}
    for function in kernels():
        for name, (custom, measuring) in stand_ins.items():
            if function.__globals__.get(name) is custom:
                monkeypatch.setitem(function.__globals__, name, measuring)


def measured(value: Any, variable: Variable) -> Any:
    """A value in SI with the unit that it is declared to have; a plain number where that is none."""
    if isinstance(value, int):
        return value
    return float(value) if variable.quantity == "1" else Measured(float(value), variable.unit())


def measured_fields(cls: type, values: Mapping[str, Any], declared: Mapping[str, Variable] | None = None) -> Any:
    """A NamedTuple with these values, each with the unit that its field is declared to have."""
    return cls(**{name: measured(values[name], item) for name, item in (declared or variables_of(cls)).items()})


def measured_parameters(component: Component, values: Mapping[str, Any], declared: Mapping[str, Variable]) -> Any:
    """What kernels receive of a component with these values, each with the unit that it is declared to have."""
    numbers = {}
    for name, variable in declared.items():
        value = values[name]
        if variable.choices:
            numbers[name] = variable.code(value, name)
        elif component.is_array(name):
            numbers[name] = Several(measured(item, variable) for item in value)
        else:
            numbers[name] = measured(value, variable)
    return component.assemble(numbers)


def hold(value: Any, unit: str, what: str) -> None:
    """Refuse a number that has not the dimension of a unit; a plain zero has every one."""
    if not isinstance(value, Measured):
        value = Measured(float(value), unit if _has_any_unit(float(value)) else "")
    if not value.is_compatible_with(units._unit(unit)):
        raise pint.DimensionalityError(value.units, unit, extra_msg=f": {what}")
