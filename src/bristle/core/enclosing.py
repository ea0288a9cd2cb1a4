"""Components around another one: they have the parameters of that, and their own beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.core.contracts import Component, Relation
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.variable import Variable

__all__ = ["Enclosing", "relations_of"]


def relations_of(component: Component) -> tuple[Relation, ...]:
    """Return the relations of a component for the one around it, whose parameters hold those of the component."""
    return tuple(_of_inner(relation) for relation in component.relations)


def _of_inner(relation: Relation) -> Relation:
    return relation._replace(holds=lambda p: relation.holds(p.inner))


class Enclosing:
    """What a component around another one, `inner`, has of it; kernels find the parameters of that as ``p.inner``."""

    inner: Any

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Its parameters beside those of the component inside, of which there need be none."""
        return {}

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets: those of the component inside, then those beside."""
        return ReadOnly(self.inner.variables | dict(self.beside))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the component inside."""
        return self.inner.initial_state(parameters.inner)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name in self.inner.variables and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name in self.inner.variables and self.inner.is_integer(name)

    def inside(self, values: Mapping[str, Any]) -> Any:
        """Return what kernels of the component inside receive, from the values that a person sets."""
        return self.inner.assemble({name: values[name] for name in self.inner.variables})
