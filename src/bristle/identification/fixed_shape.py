"""Elements of a fixed shape, as one friction model with two numbers: its level and its stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.variable import Variable
from bristle.friction import gms, maxwell_slip

__all__ = ["ARRAYS", "ELEMENT_MODELS", "TOTAL", "ShapedModel", "further_numbers", "in_lists", "shaped"]

ARRAYS = ("k_i", "nu_i")  # stiffness and share of each element
TOTAL = "s"  # the stiffness of all elements together
ELEMENT_MODELS = (maxwell_slip, gms)
STIFFNESS = Variable(
    "force/length", "stiffness after a reversal, of all elements", min=1e-9, nominal=1e6, excitation="presliding"
)


@dataclass(frozen=True, kw_only=True)
class ShapedModel(FrictionModel):
    """A `maxwell_slip` model, with its slots, of which the shares of the elements are fixed.

    Instead of the lists it has the stiffness ``s`` of all elements together: a larger one steepens all of them alike, a
    larger ``F_C`` lets them slip later.
    """

    inner: FrictionModel
    shape: tuple[tuple[float, ...], tuple[float, ...]]

    def __reduce__(self) -> tuple[Any, ...]:
        # There are as many as shapes were tried, and nothing tells them apart but that: made anew, they are as good.
        return _shaped, (self.inner, self.shape)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets, the stiffness in place of the lists."""
        found: dict[str, Variable] = {}
        for name, variable in self.inner.variables.items():
            if name == ARRAYS[0]:
                found[TOTAL] = STIFFNESS
            elif name not in ARRAYS:
                found[name] = variable
        return ReadOnly(found)

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array: none is."""
        return False

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name != TOTAL and self.inner.is_integer(name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return what kernels receive, from the values that a person sets."""
        return self.inner.assemble(self.lists(values))

    def lists(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of the model with its lists."""
        stiffness, shares = (np.array(part) for part in self.shape)
        given = {name: value for name, value in values.items() if name in self.inner.variables}
        return given | dict(zip(ARRAYS, (values[TOTAL] * stiffness, shares), strict=True))

    def finished(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return values with the lists in place of the stiffness, whatever else there is among them."""
        return {name: value for name, value in values.items() if name != TOTAL} | self.lists(values)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values that a person sets, from what kernels receive."""
        whole = self.inner.values(parameters)
        return {name: float(np.sum(whole[ARRAYS[0]])) if name == TOTAL else whole[name] for name in self.variables}


def shaped(model: FrictionModel, stiffness: np.ndarray, levels: np.ndarray) -> ShapedModel:
    """Return a `maxwell_slip` model whose elements have these shares.

    Parameters
    ----------
    model : SlottedModel
        The model.
    stiffness, levels : ndarray, shape (element,)
        Stiffness [N/m or N*m/rad] of each element, and the force [N or N*m] at which it slips.
    """
    return _shaped(model, (tuple((stiffness / np.sum(stiffness)).tolist()), tuple((levels / np.sum(levels)).tolist())))


def _shaped(model: FrictionModel, shape: tuple[tuple[float, ...], tuple[float, ...]]) -> ShapedModel:
    return ShapedModel(
        name=model.name,
        description=model.description,
        Parameters=model.Parameters,
        State=model.State,
        trial=model.trial,
        commit=model.commit,
        memory_size=model.memory_size,
        relations=model.relations,
        reference=model.reference,
        module=model.module,
        inner=model,
        shape=shape,
    )


def in_lists(friction: Model) -> Model:
    """Return a model of a fixed shape as the one with its lists, as it is written and run."""
    return Model(friction.component.inner, friction.parameters, friction.kind)


def further_numbers(model: ShapedModel) -> int:
    """Return how many free numbers the elements are, besides their level and their stiffness."""
    return max(len(model.shape[0]) - 2, 0)
