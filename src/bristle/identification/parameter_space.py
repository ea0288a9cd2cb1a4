"""The coordinates θ in which least squares seeks parameters: one space for search, refit and bootstrap.

Parameters that are positive and of unknown magnitude (a stiffness, a Stribeck velocity) are sought in their logarithm;
one that may not fall below another (F_S >= F_C) as an excess over it, so that the relation holds at every step; all
others over a typical magnitude. What a model is linear in needs no transform.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.identification.parameters import ParameterSet
from bristle.identification.scales import Scales

__all__ = ["LinearSpace", "ParameterSpace", "Transform", "TransformedSpace"]

AT_LEAST = re.compile(r"(\w+) >=? (\w+)")
CLEARLY = 0.1  # of the force scale: by how much a force is above another one that it must exceed
BREAK_AWAY_MOST = 2.0  # times the largest effort of the log


class ParameterSpace(Protocol):
    """Coordinates of free parameters, within bounds.

    `names` are those of the coordinates; `reported` the parameters that a person is told; `logarithmic` those of them
    that are sought in their logarithm; `linear` says whether the signal is linear in the coordinates; `curve` are
    displacements [m or rad] at which the virgin curve is reported, too.
    """

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def low(self) -> np.ndarray: ...  # noqa: D102
    @property
    def high(self) -> np.ndarray: ...  # noqa: D102
    @property
    def reported(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def logarithmic(self) -> frozenset[str]: ...  # noqa: D102
    @property
    def linear(self) -> bool: ...  # noqa: D102
    @property
    def curve(self) -> tuple[float, ...]: ...  # noqa: D102

    def values(self, theta: np.ndarray) -> dict[str, Any]:
        """Return what the model takes [SI]."""
        ...

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return what is reported [SI], and the curve after it, shape (reported and curve,)."""
        ...

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of what is reported, shape (reported, coordinate)."""
        ...


@dataclass(frozen=True)
class LinearSpace:
    """Parameters as they are, between `low` and `high` [SI]."""

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    linear: bool = True
    logarithmic: frozenset[str] = frozenset()
    curve: tuple[float, ...] = ()

    @classmethod
    def of(cls, parameters: ParameterSet) -> LinearSpace:
        """Return the free parameters within what the model allows."""
        variables = [parameters.variables[name] for name in parameters.free]
        low, high = (np.array([getattr(variable, side) for variable in variables]) for side in ("min", "max"))
        return cls(parameters.free, low, high)

    @property
    def reported(self) -> tuple[str, ...]:
        """All of them."""
        return self.names

    def values(self, theta: np.ndarray) -> dict[str, float]:
        """Return the parameters by name [SI]."""
        return dict(zip(self.names, theta.tolist(), strict=True))

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the parameters [SI]."""
        return theta

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the identity."""
        return np.eye(len(self.names))


class Transform(NamedTuple):
    """One free parameter as the solver sees it: ``plain``, ``log`` or ``excess`` over the parameter `above`.

    `low` and `high` bound the coordinate, `least` and `most` the parameter.
    """

    name: str
    form: str
    scale: float
    low: float
    high: float
    least: float
    most: float
    above: str = ""

    def value(self, theta: float, values: Mapping[str, float]) -> float:
        """Return the parameter [SI] at this coordinate, given those computed before it."""
        value = math.exp(theta) if self.form == "log" else self.scale * theta
        # Rounding must not lead out of what the model allows.
        return min(max(value + (values[self.above] if self.above else 0.0), self.least), self.most)

    def theta(self, value: float, values: Mapping[str, float]) -> float:
        """Return the coordinate of a parameter, put inside its range."""
        if self.form == "log":
            inside = math.log(max(value, 1e-300))
        else:
            inside = (value - (values[self.above] if self.above else 0.0)) / self.scale
        return min(max(inside, self.low), self.high)


@dataclass(frozen=True)
class TransformedSpace:
    """Parameters through their transforms.

    Parameters
    ----------
    parameters : ParameterSet
        What is free and what is fixed.
    transforms : tuple of Transform
        One for each free parameter; one that may not fall below another comes after it.
    """

    parameters: ParameterSet
    transforms: tuple[Transform, ...]
    linear: bool = False
    curve: tuple[float, ...] = ()

    @classmethod
    def of(cls, parameters: ParameterSet, scales: Scales) -> TransformedSpace:
        """Return the coordinates of the free parameters; what further relations say is left to the finished model.

        Raises
        ------
        InputError
            If no value that the model allows is of the extent of the log.
        """
        floors = _floors(parameters)
        names = _in_turn(parameters.free, floors)
        return cls(parameters, tuple(_transform(name, parameters, scales, floors) for name in names))

    @property
    def names(self) -> tuple[str, ...]:
        """The free parameters, each after the one that it may not fall below."""
        return self._names

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(transform.name for transform in self.transforms)

    @property
    def reported(self) -> tuple[str, ...]:
        """All of them."""
        return self.names

    @property
    def low(self) -> np.ndarray:
        """Lower bounds, shape (coordinate,)."""
        return self._low

    @cached_property
    def _low(self) -> np.ndarray:
        return np.array([transform.low for transform in self.transforms])

    @property
    def high(self) -> np.ndarray:
        """Upper bounds, shape (coordinate,)."""
        return self._high

    @cached_property
    def _high(self) -> np.ndarray:
        return np.array([transform.high for transform in self.transforms])

    @property
    def logarithmic(self) -> frozenset[str]:
        """Those that are sought in their logarithm."""
        return self._logarithmic

    @cached_property
    def _logarithmic(self) -> frozenset[str]:
        return frozenset(transform.name for transform in self.transforms if transform.form == "log")

    def values(self, theta: np.ndarray) -> dict[str, float]:
        """Return the free parameters [SI]."""
        values = self.parameters.complete({})
        for transform, coordinate in zip(self.transforms, theta.tolist(), strict=True):
            values[transform.name] = transform.value(coordinate, values)
        return {name: values[name] for name in self.names}

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the free parameters [SI], shape (coordinate,)."""
        return np.array(list(self.values(theta).values()))

    def theta(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the coordinates of parameters [SI], put inside their range."""
        return np.array([transform.theta(values[transform.name], values) for transform in self.transforms])

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of the parameters [SI], shape (parameter, coordinate)."""
        values, derivative = self.values(theta), np.zeros((len(self.names), len(self.names)))
        for row, transform in enumerate(self.transforms):
            derivative[row, row] = values[transform.name] if transform.form == "log" else transform.scale
            if transform.above in self.names:
                derivative[row] += derivative[self.names.index(transform.above)]
        return derivative


def _transform(name: str, parameters: ParameterSet, scales: Scales, floors: Mapping[str, str]) -> Transform:
    variable = parameters.variables[name]
    scale, allowed = scales.magnitude(variable), (variable.min, variable.max)
    if name in floors:
        strict = any(
            relation.condition.startswith(f"{name.removesuffix('_pos').removesuffix('_neg')} > ")
            for relation in parameters.component.relations
        )
        # A log shows no force that its effort never came near.
        most = BREAK_AWAY_MOST * scales.peak / scale if variable.quantity == "force" else math.inf
        return Transform(name, "excess", scale, CLEARLY if strict else 0.0, most, *allowed, floors[name])
    if variable.min > 0.0 and variable.quantity != "mass":
        low, high = _sought(name, variable, scales)
        return Transform(name, "log", 1.0, math.log(low), math.log(high), *allowed)
    return Transform(name, "plain", scale, variable.min / scale, variable.max / scale, *allowed)


def _sought(name: str, variable: Variable, scales: Scales) -> tuple[float, float]:
    """Return between which values a positive parameter is sought [SI]."""
    low, high = scales.range(variable)
    least, most = max(low, variable.min), min(high, variable.max)
    if not least < most:
        raise InputError(
            f"would be {low:.3g} to {high:.3g} by the extent of this log, in SI", path=name,
            allowed=f"{variable.min:g} to {variable.max:g}", mend="Mend the units of the time and the position",
        )  # fmt: skip
    return least, most


def _in_turn(names: Sequence[str], floors: Mapping[str, str]) -> list[str]:
    """Return names in their order, but each after its floor."""
    placed: list[str] = []
    for name in names:
        chain = [name]
        while chain[-1] in floors and floors[chain[-1]] in names:
            chain.append(floors[chain[-1]])
        placed += [floor for floor in reversed(chain) if floor not in placed]
    return placed


def _floors(parameters: ParameterSet) -> dict[str, str]:
    """Return, for each parameter that a relation keeps above another one, that other one."""
    known = [*parameters.fixed, *parameters.free]
    floors: dict[str, str] = {}
    for relation in parameters.component.relations:
        match = AT_LEAST.fullmatch(relation.condition)
        if match is None:
            continue
        for side in ("", "_pos", "_neg"):
            upper, lower = match[1] + side, match[2] + side
            lower = lower if lower in known else match[2]
            if upper in parameters.free and lower in known and not _stands_on(lower, upper, floors):
                floors[upper] = lower
    return floors


def _stands_on(name: str, base: str, floors: Mapping[str, str]) -> bool:
    """Return whether `base` is the floor of `name`, or the floor of its floor."""
    while name != base and name in floors:
        name = floors[name]
    return name == base
