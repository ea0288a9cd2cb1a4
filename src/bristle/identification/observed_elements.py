r"""Elements that slip, for observers: a level for each element, at thresholds on a fixed grid.

.. math:: F_C = \sum_i f_i, \qquad s = \sum_i \frac{f_i}{r_i}, \qquad F(x) = \sum_i f_i \min\Bigl(\frac{x}{r_i}, 1\Bigr)

Level, stiffness and virgin curve are linear in the levels :math:`f_i`. A shape from filtered rows is softer than the
contact; an observer does not differentiate or filter the position. The thresholds :math:`r_i` are those of inverse
dynamics, with additional thresholds down to one encoder step. An element that never slips is a slow force, which the
observer absorbs.
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.variable import Variable
from bristle.identification.fixed_shape import (
    ARRAYS,
    CURVE,
    TOTAL,
    ListedModel,
    ShapedModel,
    shaped,
)
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.parameters import Role, names_of, stroke_of
from bristle.models.friction import base_of, maxwell_slip

PER_DECADE, DECADES = 3.5, 3.0  # thresholds, at least
NEAR = 1.25  # times a threshold: nearer elements are merged with it
BEYOND = 1.4  # times the largest: an additional threshold
LEAST_STEPS = 1.0  # of the encoder: the smallest threshold
SLIPPED = (
    0.98  # of the level of elements that slip within half of the stroke: the largest threshold
)
LEAST = 1e-100  # N or N*m: an element without force keeps its threshold
SOFTEST = 1e-8  # N/m or N*m/rad: an element without force has a stiffness that a model file allows
# Level of the first element over that of the last one, where further searches begin.
STARTS = (1.0, 4.0, 0.25)


@dataclass(frozen=True, kw_only=True)
class SpreadModel(ListedModel):
    """A `maxwell_slip` model with its slots and, instead of its lists, a level for each threshold [m or rad]."""

    thresholds: tuple[float, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        return spread_model, (self.inner, self.thresholds)

    @property
    def names(self) -> tuple[str, ...]:
        """The level of each element."""
        return tuple(f"f_{number}" for number in range(len(self.thresholds)))

    @property
    def level(self) -> str:
        """The name of the level of all elements."""
        return names_of(Role.LEVEL, self.inner.variables)[0]

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter: the levels of the elements, then the other parameters of the model."""
        variables: dict[str, Variable] = {}
        for name in self.names:
            variables[name] = replace(self.inner.variables[self.level], min=0.0)
        variables |= {
            name: variable
            for name, variable in self.inner.variables.items()
            if name not in (self.level, *ARRAYS)
        }
        return ReadOnly(variables)

    def lists(self, values: Mapping[str, float]) -> dict[str, Any]:
        """Return the values of the model with its lists."""
        levels = np.maximum([values[name] for name in self.names], LEAST)
        total = float(np.sum(levels))
        return (
            self.of_inner(values)
            | {self.level: total}
            | dict(zip(ARRAYS, (levels / self.thresholds, levels / total), strict=True))
        )

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of the kernels from the values of the model."""
        return self.inner.assemble(self.lists(values))

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the model from the parameters of the kernels."""
        values = self.inner.values(parameters)
        levels = dict(
            zip(
                self.names,
                (values[self.level] * np.asarray(values[ARRAYS[1]])).tolist(),
                strict=True,
            )
        )
        return {name: levels[name] if name in levels else values[name] for name in self.variables}

    def equal(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return equal levels of all elements, with the same sum."""
        return dict.fromkeys(self.names, sum(values[name] for name in self.names) / len(self.names))

    def starts(self, values: Mapping[str, float]) -> Iterator[dict[str, float]]:
        """Yield further starts: the same level, shared in other ways."""
        equal = self.equal(values)
        for ratio in STARTS:
            shares = np.geomspace(ratio, 1.0, len(equal))
            yield {
                **values,
                **{
                    name: equal[name] * share
                    for name, share in zip(equal, shares / np.mean(shares), strict=True)
                },
            }


def spread_model(inner: FrictionModel, thresholds: tuple[float, ...]) -> SpreadModel:
    """Return a `maxwell_slip` model, with its slots, whose elements slip at these thresholds."""
    return SpreadModel.around(inner, thresholds=thresholds)


def spreads(component: FrictionModel) -> bool:
    """Return whether observers support the elements of this model: they need one level without a Stribeck curve."""
    if not isinstance(component, ShapedModel):
        return False
    return (
        base_of(component.inner) is maxwell_slip
        and len(names_of(Role.LEVEL, component.inner.variables)) == 1
    )


def spread_out(
    inverse: InverseDynamics, values: Mapping[str, float]
) -> tuple[InverseDynamics, dict[str, float]]:
    """Return a problem of elements of fixed shape as a problem of levels at thresholds, and the levels with the same virgin curve."""
    parameters = inverse.parameters
    assert isinstance(parameters.component, ShapedModel)
    lists = parameters.component.lists(parameters.complete(values))
    stiffness, reach = np.asarray(lists[ARRAYS[0]]), 0.5 * stroke_of(inverse.dataset)
    level = lists[names_of(Role.LEVEL, parameters.component.variables)[0]]
    slips = lists[ARRAYS[1]] * level / stiffness
    chosen = slips < reach if np.any(slips < reach) else np.ones(slips.size, dtype=bool)
    levels, slips = (stiffness * slips)[chosen], slips[chosen]
    thresholds = _thresholds(slips, levels, LEAST_STEPS * inverse.dataset.resolution)
    component = spread_model(parameters.component.inner, tuple(thresholds.tolist()))
    # Forces that are linear between the thresholds: at each drop of the slope, an element slips.
    forces = np.concatenate([[0.0], np.minimum(np.divide.outer(thresholds, slips), 1.0) @ levels])
    slopes = np.append(np.diff(forces) / np.diff(thresholds, prepend=0.0), 0.0)
    start = {name: value for name, value in values.items() if name not in (component.level, TOTAL)}
    start |= dict(zip(component.names, (-np.diff(slopes) * thresholds).tolist(), strict=True))
    free = tuple(
        name for name in (*parameters.plant.variables, *component.variables) if name in start
    )
    return replace(inverse, parameters=replace(parameters, component=component, free=free)), start


def _thresholds(slips: np.ndarray, levels: np.ndarray, least: float) -> np.ndarray:
    """Return the thresholds of elements, near ones merged, with additional thresholds between and below them."""
    largest = float(slips[np.searchsorted(np.cumsum(levels), SLIPPED * np.sum(levels))])
    least = min(max(least, largest * 10.0**-DECADES), 0.5 * largest)
    known = [least]
    for slip in (*slips[(slips > least) & (slips <= largest)].tolist(), BEYOND * largest):
        if slip > NEAR * known[-1]:
            known.append(slip)
    parts = [
        np.geomspace(low, high, math.ceil(PER_DECADE * math.log10(high / low)) + 1)[1:]
        for low, high in itertools.pairwise(known)
    ]
    return np.concatenate([known[:1], *parts])


@dataclass(frozen=True, kw_only=True)
class SpreadSpace(ParameterSpace):
    """Levels of elements in the coordinates of an `inner` space, reported as level, stiffness and the other parameters."""

    inner: ParameterSpace
    component: SpreadModel

    @property
    def reported(self) -> tuple[str, ...]:
        """The level, the stiffness, then the other parameters."""
        rest = (name for name in self.inner.names if name not in self.component.names)
        return (self.component.level, TOTAL, *rest)

    @cached_property
    def _levels(self) -> list[int]:
        """The places of the levels."""
        return [self.inner.names.index(name) for name in self.component.names]

    @cached_property
    def _sums(self) -> np.ndarray:
        """Matrix from free parameters to the reported numbers and the virgin curve, shape (number, parameter)."""
        levels, thresholds = self._levels, np.array(self.component.thresholds)
        sums = np.zeros((len(self.reported) + len(self.curve), len(self.inner.names)))
        sums[0, levels], sums[1, levels] = 1.0, 1.0 / thresholds
        for row, name in enumerate(self.reported[2:], 2):
            sums[row, self.inner.names.index(name)] = 1.0
        sums[len(self.reported) :, levels] = np.minimum(
            np.divide.outer(np.array(self.curve), thresholds), 1.0
        )
        return sums

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the reported numbers [SI], and the virgin curve; levels in a draw may be negative."""
        numbers = self.inner.numbers(theta)
        numbers[self._levels] = (self.inner.derivative(theta) @ theta)[self._levels]
        return self._sums @ numbers

    def values(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the reported numbers by name [SI]."""
        return dict(zip(self.reported, self.numbers(theta).tolist(), strict=False))

    def member(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the values of the model with lists [SI]: non-negative levels with the same sum."""
        names, values = self.component.names, self.inner.values(theta)
        levels = {name: max(values[name], LEAST) for name in names}
        share = max(float(self.numbers(theta)[0]), LEAST) / sum(levels.values())
        lists = self.component.lists(
            values | {name: share * level for name, level in levels.items()}
        )
        return {name: value for name, value in values.items() if name not in names} | lists

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of the reported numbers, shape (reported, coordinate)."""
        return self._sums[: len(self.reported)] @ self.inner.derivative(theta)


def gathered(inverse: InverseDynamics, solution: Solution) -> tuple[InverseDynamics, Solution]:
    """Return a problem of levels at thresholds and its solution, converted to elements of the shape found."""
    component, inner = inverse.parameters.component, solution.space
    assert isinstance(component, SpreadModel)
    thresholds = component.thresholds
    stiffness = np.maximum(component.lists(solution.values)[ARRAYS[0]], SOFTEST)
    view = shaped(component.inner, stiffness, stiffness * thresholds)
    curve = tuple(np.geomspace(thresholds[0], thresholds[-1], CURVE).tolist())
    low = np.where([name in component.names for name in inner.names], -np.inf, inner.low)
    space = SpreadSpace(
        inner.names, low, inner.high, linear=False, curve=curve, inner=inner, component=component
    )
    at_edge = {name: side for name, side in solution.at_edge.items() if name not in component.names}
    parameters = replace(inverse.parameters, component=view, free=space.reported)
    return replace(inverse, parameters=parameters), replace(solution, space=space, at_edge=at_edge)
