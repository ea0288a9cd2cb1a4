"""What is asked of a log: which parameters are free, which are held and why, and over what range they are sought.

Free parameters are sought in dimensionless coordinates. Those that are positive and of unknown magnitude (a stiffness,
a Stribeck velocity) are sought in their logarithm; one that may not fall below another (F_S >= F_C) as an excess over
it, so that the relation holds at every step; all others over a typical magnitude.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Plant
from bristle.core.diagnostic import Number
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.identification.dataset import Dataset
from bristle.plants.inertia import MODEL as inertia

__all__ = ["Transform", "Fixed", "Scales", "ParameterSet", "coordinates_of", "scales_of", "stroke_of"]

AT_LEAST = re.compile(r"(\w+) >=? (\w+)")
CLEARLY = 0.1  # of the force scale: by how much a force is above another one that it must exceed
SLOWEST_SHARE = 0.01  # of the samples are slower than the smallest Stribeck velocity sought
BREAK_AWAY_MOST = 2.0  # times the largest effort of the log
STRIBECK_SHARE = 1.0 / 3.0  # of the greatest speed: beyond, the log would not show the level that friction falls to


class Fixed(NamedTuple):
    """A parameter that is not identified: its value, why (the code of a diagnostic with what its sentence needs).

    It is `redundant` where no log could tell it.
    """

    value: float
    reason: str
    redundant: bool = False
    numbers: Mapping[str, Number] = {}


@dataclass(frozen=True)
class ParameterSet:
    """The parameters of a plant with a friction model, free and held.

    Parameters
    ----------
    component : FrictionModel
        The friction model.
    free : tuple of str
        The plant first, then friction in the order of the model.
    fixed : mapping of str to Fixed
        All others.
    plant : Plant
        What the friction acts on.
    loop : mapping of str to Variable
        What is unknown of the loop that both are simulated in.
    """

    component: FrictionModel
    free: tuple[str, ...]
    fixed: Mapping[str, Fixed]
    plant: Plant = inertia
    loop: Mapping[str, Variable] = field(default_factory=dict)

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The `Variable` of each parameter, plant first."""
        return self.plant.variables | self.component.variables | dict(self.loop)

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return every parameter, from the free ones."""
        return {name: held.value for name, held in self.fixed.items()} | dict(values)


class Scales(NamedTuple):
    """Typical magnitudes of a log, in SI."""

    force: float
    peak: float
    speed: float
    slowest: float
    acceleration: float
    stroke: float
    shortest: float
    duration: float
    sample_time: float

    def magnitude(self, variable: Variable) -> float:
        """Return a typical value of a parameter [SI]."""
        if variable.excitation == "drive":
            return variable.nominal
        return {
            "force": self.force,
            "length": math.sqrt(self.stroke * self.shortest),
            "length/time": math.sqrt(self.slowest * self.speed),
            "force/length": self.force / math.sqrt(self.stroke * self.shortest),
            "force*time/length": self.force / self.speed,
            "mass": self.force / self.acceleration,
            "1/length": 1.0 / self.stroke,
            "time": math.sqrt(self.sample_time * self.duration),
            "1/time": 1.0 / math.sqrt(self.sample_time * self.duration),
            "force/time": self.force / math.sqrt(self.sample_time * self.duration),
        }.get(variable.quantity, variable.nominal)

    def range(self, variable: Variable) -> tuple[float, float]:
        """Return between which values a positive parameter of unknown magnitude is sought [SI]."""
        return {
            "length": (self.shortest, self.stroke),
            "length/time": (self.slowest, max(STRIBECK_SHARE * self.speed, 2.0 * self.slowest)),
            "force/length": (self.force / self.stroke, self.force / self.shortest),
            "time": (self.sample_time, self.duration),
            "1/time": (1.0 / self.duration, 1.0 / self.sample_time),
            "force/time": (self.force / self.duration, self.force / self.sample_time),
        }.get(variable.quantity, (1e-3 * self.magnitude(variable), 1e2 * self.magnitude(variable)))


def stroke_of(dataset: Dataset) -> float:
    """Return how far the axis goes within a segment of the log [m or rad]."""
    return max(float(np.ptp(segment.position)) for segment in dataset.segments)


def scales_of(dataset: Dataset, force: float) -> Scales:
    """Return the typical magnitudes of a log, for a friction force of this magnitude [N or N*m]."""
    speeds = np.abs(dataset.all_velocities)
    speeds = speeds[speeds > 0.0]
    speed = float(np.quantile(speeds, 0.995))
    slowest = max(float(np.quantile(speeds, SLOWEST_SHARE)), 1e-4 * speed)
    stroke = stroke_of(dataset)
    return Scales(
        force=force,
        peak=float(np.max(np.abs(dataset.effort))),
        speed=speed,
        slowest=slowest,
        acceleration=max(float(np.sqrt(np.mean(dataset.acceleration**2))), 1e-9 * speed / dataset.sample_time),
        stroke=stroke,
        shortest=min(max(dataset.resolution, slowest * dataset.sample_time), 0.1 * stroke),
        duration=float(np.ptp(dataset.time)),
        sample_time=dataset.sample_time,
    )


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
        """Return the parameter [SI] at this coordinate, given those found before it."""
        found = math.exp(theta) if self.form == "log" else self.scale * theta
        # Rounding must not lead out of what the model allows.
        return min(max(found + (values[self.above] if self.above else 0.0), self.least), self.most)

    def theta(self, value: float, values: Mapping[str, float]) -> float:
        """Return the coordinate of a parameter, put inside its range."""
        if self.form == "log":
            inside = math.log(max(value, 1e-300))
        else:
            inside = (value - (values[self.above] if self.above else 0.0)) / self.scale
        return min(max(inside, self.low), self.high)


def transforms_of(parameters: ParameterSet, scales: Scales) -> tuple[Transform, ...]:
    """Return the coordinates of the free parameters: one that may not fall below another comes after it.

    What other relations say is left to the check of the finished model.

    Raises
    ------
    InputError
        If no value that the model allows is of the extent of the log.
    """
    variables = parameters.variables
    floors = _floors(parameters)
    found = []
    for name in _in_turn(parameters.free, floors):
        variable = variables[name]
        scale = scales.magnitude(variable)
        allowed = (variable.min, variable.max)
        if name in floors:
            strict = any(
                one.condition.startswith(f"{name.removesuffix('_pos').removesuffix('_neg')} > ")
                for one in parameters.component.relations
            )
            # A log shows no force that its effort never came near.
            most = BREAK_AWAY_MOST * scales.peak / scale if variable.quantity == "force" else math.inf
            least = CLEARLY if strict else 0.0
            found.append(Transform(name, "excess", scale, least, most, *allowed, floors[name]))
        elif variable.min > 0.0 and variable.quantity != "mass":
            low, high = _sought(name, variable, scales)
            found.append(Transform(name, "log", 1.0, math.log(low), math.log(high), *allowed))
        else:
            found.append(Transform(name, "plain", scale, variable.min / scale, variable.max / scale, *allowed))
    return tuple(found)


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
        above = [name]
        while above[-1] in floors and floors[above[-1]] in names:
            above.append(floors[above[-1]])
        placed += [one for one in reversed(above) if one not in placed]
    return placed


def _floors(parameters: ParameterSet) -> dict[str, str]:
    """Return, for each parameter that a relation keeps above another one, that other one."""
    known = [*parameters.fixed, *parameters.free]
    found = {}
    for relation in parameters.component.relations:
        match = AT_LEAST.fullmatch(relation.condition)
        if match is None:
            continue
        for side in ("", "_pos", "_neg"):
            upper, lower = match[1] + side, match[2] + side
            lower = lower if lower in known else match[2]
            if upper in parameters.free and lower in known and not _stands_on(lower, upper, found):
                found[upper] = lower
    return found


def _stands_on(name: str, other: str, floors: Mapping[str, str]) -> bool:
    """Return whether `other` is the floor of `name`, or the floor of its floor."""
    while name != other and name in floors:
        name = floors[name]
    return name == other


def natural_derivative(coordinates: tuple[Transform, ...], values: Mapping[str, Any]) -> np.ndarray:
    """Return the derivative of the parameters [SI] with respect to their coordinates, shape (free, free)."""
    names = [coordinate.name for coordinate in coordinates]
    derivative = np.zeros((len(names), len(names)))
    for row, coordinate in enumerate(coordinates):
        derivative[row, row] = values[coordinate.name] if coordinate.form == "log" else coordinate.scale
        if coordinate.above in names:
            derivative[row] += derivative[names.index(coordinate.above)]
    return derivative
