"""A friction model that encloses another one: the parameters of that, and coefficients of its slots beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from bristle.core.contracts import FrictionModel, Relation
from bristle.core.dispatch import friction_commit
from bristle.core.kernel import kernel
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.surroundings import Surrounding
from bristle.core.variable import Variable, variables_of

__all__ = ["EnclosingModel", "commit", "relations_of"]


@kernel
def commit(state, memory, move, p):
    """Commit the move of the model inside."""
    return friction_commit(state, memory, move, p.inner)


def relations_of(model: FrictionModel) -> tuple[Relation, ...]:
    """Return the relations of a model for the one around it, whose parameters hold those of the model."""
    return tuple(_of_inner(relation) for relation in model.relations)


def _of_inner(relation: Relation) -> Relation:
    return relation._replace(holds=lambda p: relation.holds(p.inner))


@dataclass(frozen=True, kw_only=True)
class EnclosingModel(FrictionModel):
    """A friction model with slots; what each slot adds is told by the class.

    Parameters
    ----------
    inner : FrictionModel
        The model inside.
    slots : tuple of str
        Names of its slots.
    """

    inner: FrictionModel
    slots: tuple[str, ...]
    coefficients: ClassVar[type]
    """The named tuple of the coefficients of all slots."""
    of_slot: ClassVar[Mapping[str, tuple[str, ...]]]
    """The coefficients of each slot."""
    without_default: ClassVar[tuple[str, ...]]
    """Coefficients that must be given."""
    depends_on: ClassVar[Mapping[str, Surrounding]]
    """What of the surroundings each slot depends on."""

    @property
    def own(self) -> tuple[str, ...]:
        """The coefficients of its slots."""
        return tuple(name for slot in self.slots for name in self.of_slot[slot])

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """What of its surroundings its slots depend on."""
        own = (self.depends_on[slot] for slot in self.slots if slot in self.depends_on)
        return (*self.inner.surroundings, *own)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets: those of the model, then those of its slots."""
        variables = variables_of(self.coefficients)
        return ReadOnly(self.inner.variables | {name: variables[name] for name in self.own})

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value: a range and a pitch must be given."""
        return self.inner.defaults | {name: 0.0 for name in self.own if name not in self.without_default}

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the model inside."""
        return self.inner.initial_state(parameters.inner)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name not in self.own and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name not in self.own and self.inner.is_integer(name)
