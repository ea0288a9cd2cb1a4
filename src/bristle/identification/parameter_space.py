"""The coordinates θ of least squares, and its solution.

Positive parameters of unknown magnitude (stiffness, Stribeck velocity) are sought in their logarithm. A parameter
with a lower bound (F_S >= F_C) is sought as the excess over it. If a product must stay below a limit, the parameter
is a share of its largest value. So all relations are satisfied at every step. Other parameters are scaled by a
typical magnitude. Linear parameters need no transform.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.identification.parameters import ParameterSet, Scales
from bristle.models.friction.slots import by_direction

ABOVE = re.compile(r"(\w+) (>=?) (\w+)")
MULTIPLE_BELOW = re.compile(r"(\w+) \* (\w+) < (\w+)")
SHARE_MOST = 0.95  # of the limit of a product: at 1 a gate would be a jump
CLEARLY = 0.1  # of the force scale: least excess of a force over its strict lower bound


class Turned(NamedTuple):
    """Reflected parameters: reported `numbers` [SI], and `values` for the model."""

    numbers: np.ndarray
    values: dict[str, Any]


@dataclass(frozen=True)
class ParameterSpace:
    """Coordinates of free parameters within bounds; in this class, the parameters [SI]."""

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    linear: bool = True  # whether the signal is linear in the coordinates
    logarithmic: frozenset[str] = frozenset()  # coordinates that are logarithms
    curve: tuple[
        float, ...
    ] = ()  # displacements of the virgin curve, which is reported too [m or rad]

    @classmethod
    def of(cls, parameters: ParameterSet) -> ParameterSpace:
        """Return the space of free parameters with the bounds of the model."""
        variables = [parameters.variables[name] for name in parameters.free]
        low, high = (
            np.array([getattr(variable, side) for variable in variables]) for side in ("min", "max")
        )
        return ParameterSpace(parameters.free, low, high)

    @property
    def reported(self) -> tuple[str, ...]:
        """The reported parameters."""
        return self.names

    def values(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the parameters of the model [SI], by name."""
        return dict(zip(self.names, theta.tolist(), strict=True))

    def member(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the parameters of the model for a draw [SI]."""
        return self.values(theta)

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the reported numbers [SI], followed by the curve, shape (reported and curve,)."""
        return theta

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of the reported numbers, shape (reported, coordinate)."""
        return np.eye(len(self.names))

    def turned(self, theta: np.ndarray, best: np.ndarray) -> Turned:
        """Return the reflection of coordinates about the `best` coordinates, within the bounds."""
        opposite = np.clip(2.0 * best - theta, self.low, self.high)
        return Turned(self.numbers(opposite), self.values(opposite))


class Ceiling(NamedTuple):
    """Upper bound of the product of a parameter and a `factor`: the smallest of the parameters `below`."""

    factor: str
    below: tuple[str, ...]

    def smallest(self, values: Mapping[str, float]) -> str:
        """Return the parameter that bounds the product."""
        return min(self.below, key=lambda name: values[name])

    def largest_value(self, values: Mapping[str, float]) -> float:
        """Return the upper bound of the parameter [SI]."""
        return values[self.smallest(values)] / values[self.factor]


class Transform(NamedTuple):
    """The coordinate of a free parameter, with bounds: ``plain``, ``log``, ``excess`` over another or ``below`` a ceiling."""

    name: str
    form: str
    scale: float
    low: float  # of the coordinate, like `high`
    high: float
    least: float  # of the parameter, like `most`
    most: float
    above: tuple[str, ...] = ()  # the parameter is in excess of the largest of these
    ceiling: Ceiling | None = None

    def base(self, values: Mapping[str, float]) -> float:
        """Return the parameter [SI] that this one exceeds, the largest of several; 0 without."""
        return max((values[name] for name in self.above), default=0.0)

    def value(self, theta: float, values: Mapping[str, float]) -> float:
        """Return the parameter [SI] at this coordinate, given those computed before it."""
        unit = self.scale if self.ceiling is None else self.ceiling.largest_value(values)
        value = math.exp(theta) if self.form == "log" else unit * theta
        # Rounding must not violate the bounds of the model.
        return min(max(value + self.base(values), self.least), self.most)

    def theta(self, value: float, values: Mapping[str, float]) -> float:
        """Return the coordinate of a parameter, clipped to its range."""
        unit = self.scale if self.ceiling is None else self.ceiling.largest_value(values)
        inside = (
            math.log(max(value, 1e-300))
            if self.form == "log"
            else (value - self.base(values)) / unit
        )
        return min(max(inside, self.low), self.high)

    def derivative(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the derivatives of the parameter by its coordinate and by the parameters computed before it."""
        value = values[self.name]
        if self.ceiling is not None:
            below, factor = self.ceiling.smallest(values), self.ceiling.factor
            return {
                self.name: self.ceiling.largest_value(values),
                below: value / values[below],
                factor: -value / values[factor],
            }
        largest = sorted(self.above, key=lambda name: values[name])[-1:]
        return {self.name: value if self.form == "log" else self.scale} | dict.fromkeys(
            largest, 1.0
        )


@dataclass(frozen=True, kw_only=True)
class TransformedSpace(ParameterSpace):
    """Free parameters through their transforms, each after the parameters that it depends on."""

    parameters: ParameterSet
    transforms: tuple[Transform, ...]

    @classmethod
    def within(cls, parameters: ParameterSet, scales: Scales) -> TransformedSpace:
        """Return the coordinates of the free parameters; the validation of the model checks further relations."""
        component, bases = parameters.component, dict[str, tuple[str, ...]]()
        floors: dict[str, Floor] = {}
        for relation in component.relations:
            match = ABOVE.fullmatch(relation.condition)
            if match is None:
                continue
            uppers, lowers = by_direction(component, match[1]), by_direction(component, match[3])
            # A parameter with one value for both directions is above the values of both.
            floor_names = (
                [(lower,) for lower in lowers]
                if len(uppers) == len(lowers)
                else [lowers] * len(uppers)
            )
            for upper, below in zip(uppers, floor_names, strict=True):
                has_values = all(
                    lower in parameters.free or lower in parameters.fixed for lower in below
                )
                if (
                    upper in parameters.free
                    and has_values
                    and not any(_hangs_on(lower, upper, bases) for lower in below)
                ):
                    floors[upper], bases[upper] = Floor(below, match[2] == ">"), below
        ceilings, placed = _ceilings(parameters, floors, bases), list[str]()

        def place(name: str) -> None:
            # Each after its bases.
            for base in bases.get(name, ()):
                if base in parameters.free:
                    place(base)
            if name not in placed:
                placed.append(name)

        for name in parameters.free:
            place(name)
        transforms = [
            _transform(
                name, parameters.variables[name], scales, floors.get(name), ceilings.get(name)
            )
            for name in placed
        ]
        return cls(
            tuple(placed),
            np.array([transform.low for transform in transforms]),
            np.array([transform.high for transform in transforms]),
            linear=False,
            logarithmic=frozenset(
                transform.name for transform in transforms if transform.form == "log"
            ),
            parameters=parameters,
            transforms=tuple(transforms),
        )

    def values(self, theta: np.ndarray) -> dict[str, float]:
        """Return the free parameters [SI]."""
        values = {**self.parameters.held}
        for transform, coordinate in zip(self.transforms, theta.tolist(), strict=True):
            values[transform.name] = transform.value(coordinate, values)
        return {name: values[name] for name in self.names}

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the free parameters [SI], shape (coordinate,)."""
        return np.array(list(self.values(theta).values()))

    def theta(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the coordinates of parameters [SI], clipped to their ranges."""
        return np.array(
            [transform.theta(values[transform.name], values) for transform in self.transforms]
        )

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of the parameters [SI], shape (parameter, coordinate)."""
        values = self.parameters.complete(self.values(theta))
        derivative = np.zeros((len(self.names), len(self.names)))
        for row, transform in enumerate(self.transforms):
            for name, slope in transform.derivative(values).items():
                if name == transform.name:
                    derivative[row, row] += slope
                elif name in self.names:
                    derivative[row] += slope * derivative[self.names.index(name)]
        return derivative


@dataclass(frozen=True)
class Solution:
    """The solution of least squares: the best parameters of one problem."""

    space: ParameterSpace
    theta: np.ndarray
    jacobian: np.ndarray
    at_edge: Mapping[str, str] = field(default_factory=dict)
    cost: float = 0.0
    unfinished: bool = False

    @cached_property
    def values(self) -> dict[str, Any]:
        """The free parameters of the model [SI]."""
        return self.space.values(self.theta)

    @cached_property
    def derivative(self) -> np.ndarray:
        """Derivative of the reported parameters with respect to the coordinates, shape (reported, coordinate)."""
        return self.space.derivative(self.theta)


def _transform(
    name: str, variable: Variable, scales: Scales, floor: Floor | None, ceiling: Ceiling | None
) -> Transform:
    scale, allowed = scales.magnitude(variable), (variable.min, variable.max)
    if ceiling is not None:
        return Transform(name, "below", 1.0, 0.0, SHARE_MOST, *allowed, ceiling=ceiling)
    if floor is not None:
        # A log does not show a force far above its efforts.
        # Times the largest effort of the log.
        most = 2.0 * scales.peak / scale if variable.quantity == "force" else math.inf
        return Transform(
            name, "excess", scale, CLEARLY if floor.strict else 0.0, most, *allowed, floor.names
        )
    if variable.min > 0.0 and variable.quantity != "mass":
        low, high = scales.range(variable)
        low, high = max(low, variable.min), min(high, variable.max)
        if not low < high:
            raise InputError(
                f"would have the range {low:.3g} to {high:.3g} for the extent of this log, in SI",
                path=name,
                allowed=f"{variable.min:g} to {variable.max:g}",
                mend="Check the units of time and position",
            )
        return Transform(name, "log", 1.0, math.log(low), math.log(high), *allowed)
    return Transform(name, "plain", scale, variable.min / scale, variable.max / scale, *allowed)


class Floor(NamedTuple):
    """Lower bound of a parameter: the largest of other parameters, and whether it is strict."""

    names: tuple[str, ...]
    strict: bool


def _hangs_on(name: str, base: str, bases: Mapping[str, tuple[str, ...]]) -> bool:
    """Return whether a parameter is `base`, or computed from it."""
    return name == base or any(_hangs_on(further, base, bases) for further in bases.get(name, ()))


def _ceilings(
    parameters: ParameterSet, floors: Mapping[str, Floor], bases: dict[str, tuple[str, ...]]
) -> dict[str, Ceiling]:
    """Return the ceiling of each free parameter whose product with another is bounded by a relation."""
    # Parameters that may be negative, have a floor or depend on themselves are left to the validation of the model.
    # `bases` receives the dependencies.
    component, variables = parameters.component, parameters.variables
    ceilings: dict[str, Ceiling] = {}
    for relation in component.relations:
        match = MULTIPLE_BELOW.fullmatch(relation.condition)
        if match is None or match[2] not in parameters.free or match[2] in floors:
            continue
        ceiling = Ceiling(match[1], tuple(by_direction(component, match[3])))
        names = (ceiling.factor, *ceiling.below)
        is_positive = all(name in variables and variables[name].min > 0.0 for name in names)
        if not is_positive or variables[match[2]].min < 0.0:
            continue
        if not any(_hangs_on(name, match[2], bases) for name in names):
            ceilings[match[2]], bases[match[2]] = ceiling, names
    return ceilings
