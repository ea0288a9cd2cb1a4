"""Elements that slip, as a model of fixed shape with two numbers; each element has a stiffness in fits to replicates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.variable import Variable
from bristle.identification.parameter_space import ParameterSpace, Turned
from bristle.models.friction import gms, maxwell_slip

ARRAYS = ("k_i", "nu_i")  # stiffness and share of each element
TOTAL = "s"  # the stiffness of all elements together
ELEMENT_MODELS = (maxwell_slip, gms)
LEAST = 0.05  # of level and stiffness: both stay positive in every draw
DIFFERENCE = "difference"  # half the difference of the levels forward and backward
STIFFNESS = Variable(
    "force/length",
    "stiffness after a reversal, the sum over all elements",
    min=1e-9,
    nominal=1e6,
    excitation="presliding",
)


CURVE = 12  # displacements at which the virgin curve has intervals


@dataclass(frozen=True, kw_only=True)
class ListedModel(FrictionModel):
    """A model of elements with its slots, parametrised by numbers instead of the lists of the `inner` model."""

    inner: FrictionModel

    @classmethod
    def around(cls, inner: FrictionModel, **own: Any) -> Self:
        """Return such a model with the kernels of the inner model."""
        return cls(
            name=inner.name,
            description=inner.description,
            Parameters=inner.Parameters,
            State=inner.State,
            trial=inner.trial,
            commit=inner.commit,
            memory_size=inner.memory_size,
            relations=inner.relations,
            reference=inner.reference,
            module=inner.module,
            inner=inner,
            **own,
        )

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults

    def is_array(self, name: str) -> bool:
        """Return False: no parameter is an array."""
        return False

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name in self.inner.variables and self.inner.is_integer(name)

    def of_inner(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of parameters of the inner model."""
        return {name: value for name, value in values.items() if name in self.inner.variables}


@dataclass(frozen=True, kw_only=True)
class ShapedModel(ListedModel):
    """A `maxwell_slip` model with its slots and fixed shares of the elements; its parameter ``s`` is the total stiffness."""

    shape: tuple[tuple[float, ...], tuple[float, ...]]

    def __reduce__(self) -> tuple[Any, ...]:
        # The shape defines the model: a new instance is equivalent.
        return _shaped, (self.inner, self.shape)

    @property
    def further(self) -> int:
        """Number of free numbers of the elements besides level and stiffness."""
        return max(len(self.shape[0]) - 2, 0)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter, with the stiffness in place of the lists."""
        variables: dict[str, Variable] = {}
        for name, variable in self.inner.variables.items():
            if name == ARRAYS[0]:
                variables[TOTAL] = STIFFNESS
            elif name not in ARRAYS:
                variables[name] = variable
        return ReadOnly(variables)

    def lists(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of the model with its lists."""
        stiffness, shares = (np.array(part) for part in self.shape)
        return self.of_inner(values) | dict(
            zip(ARRAYS, (values[TOTAL] * stiffness, shares), strict=True)
        )

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of the kernels from the values of the model."""
        return self.inner.assemble(self.lists(values))

    def finished(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values with the lists in place of the stiffness; other values are kept."""
        return {name: value for name, value in values.items() if name != TOTAL} | self.lists(values)

    def share_within(self, distance: float, stiffness: float, level: float) -> float:
        """Return the share of a total `stiffness`, at a total `level`, in elements that slip within a distance [m or rad]."""
        stiffnesses, levels = (np.array(part) for part in self.shape)
        return float(np.sum(stiffnesses[levels * level < distance * stiffnesses * stiffness]))

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the model from the parameters of the kernels."""
        values = self.inner.values(parameters)
        return {
            name: float(np.sum(values[ARRAYS[0]])) if name == TOTAL else values[name]
            for name in self.variables
        }


def shaped(model: FrictionModel, stiffness: np.ndarray, levels: np.ndarray) -> ShapedModel:
    """Return a `maxwell_slip` model whose elements have shares proportional to these stiffnesses and levels, shape (element,)."""
    return _shaped(
        model,
        (
            tuple((stiffness / np.sum(stiffness)).tolist()),
            tuple((levels / np.sum(levels)).tolist()),
        ),
    )


def _shaped(
    model: FrictionModel, shape: tuple[tuple[float, ...], tuple[float, ...]]
) -> ShapedModel:
    return ShapedModel.around(model, shape=shape)


def in_lists(friction: Model) -> Model:
    """Return a model of fixed shape as the model with lists."""
    return Model(friction.component.inner, friction.parameters, friction.kind)


@dataclass(frozen=True, kw_only=True)
class ElementSpace(ParameterSpace):
    """One stiffness for each element, then the other free parameters."""

    thresholds: np.ndarray  # slip of each element [m or rad]
    levels: Mapping[str, float]  # level parameters, with the sign of the difference in each
    rest: tuple[str, ...]  # reported unchanged

    @classmethod
    def around(
        cls,
        thresholds: np.ndarray,
        single: Mapping[str, float],
        levels: Mapping[str, float],
        free: Sequence[str],
    ) -> ElementSpace:
        """Return the space of elements and of single parameters with their lower bounds."""
        names = (*(f"k_{number}" for number in range(thresholds.size)), *single)
        return cls(
            names,
            np.array([*np.zeros(thresholds.size), *single.values()]),
            np.full(len(names), np.inf),
            curve=tuple(np.geomspace(thresholds[0], thresholds[-1], CURVE).tolist()),
            thresholds=thresholds,
            levels=levels,
            rest=tuple(name for name in free if name not in (*levels, TOTAL)),
        )

    @property
    def reported(self) -> tuple[str, ...]:
        """The level, the stiffness, then the other parameters."""
        return (*self.levels, TOTAL, *self.rest)

    def values(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the parameters of the model [SI]; an element without force keeps its threshold."""
        r = self.thresholds
        stiffness = np.maximum(theta[: r.size], 1e-12 * np.sum(theta[: r.size]))
        level = float(stiffness @ r)
        rest = dict(zip(self.names[r.size :], theta[r.size :].tolist(), strict=True))
        difference = rest.pop(DIFFERENCE, 0.0)
        levels = {name: level + sign * difference for name, sign in self.levels.items()}
        return dict(zip(ARRAYS, (stiffness, stiffness * r / level), strict=True)) | levels | rest

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of the reported numbers, shape (reported, coordinate)."""
        r, names = self.thresholds, self.names
        first = np.zeros((len(self.levels) + 1, len(names)))
        first[:-1, : r.size], first[-1, : r.size] = r, 1.0
        if DIFFERENCE in names:
            first[:-1, names.index(DIFFERENCE)] = list(self.levels.values())
        return np.vstack([first, np.eye(len(names))[[names.index(name) for name in self.rest]]])

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the reported numbers [SI], and the virgin curve."""
        reach = np.minimum.outer(np.array(self.curve), self.thresholds)
        return np.concatenate(
            [self.derivative(theta) @ theta, reach @ theta[: self.thresholds.size]]
        )

    def turned(self, theta: np.ndarray, best: np.ndarray) -> Turned:
        """Return the reflection of coordinates about the `best` ones; the shape of the elements has no opposite and stays."""
        opposite, count = 2.0 * best - theta, self.thresholds.size
        opposite[count:] = np.clip(opposite[count:], self.low[count:], self.high[count:])
        numbers, values, shape = (
            self.numbers(opposite),
            self.values(theta),
            slice(len(self.levels) + 1),
        )
        numbers[shape] = np.maximum(numbers[shape], LEAST * self.numbers(best)[shape])
        values |= {
            name: float(number) for name, number in zip(self.reported, numbers, strict=False)
        }
        values[ARRAYS[0]] *= values.pop(TOTAL) / np.sum(values[ARRAYS[0]])
        return Turned(numbers, values)
