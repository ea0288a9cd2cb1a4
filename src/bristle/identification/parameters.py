"""The parameters of a plant with a friction model: which are free, which are fixed, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from bristle.core.contracts import FrictionModel, Plant
from bristle.core.diagnostic import Number
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.plants.inertia import MODEL as inertia

__all__ = ["Fixed", "ParameterSet"]


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
    """The parameters of a plant with a friction model, free and fixed.

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
        return {name: fixed.value for name, fixed in self.fixed.items()} | dict(values)

    @property
    def is_linear(self) -> bool:
        """Whether the effort is linear in the free parameters, and no relation binds them."""
        return self.component.linear and not self.component.relations
