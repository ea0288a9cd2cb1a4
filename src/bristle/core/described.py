"""What a component is described by: names, the types of its data, conditions between parameters, and no functions.

Who shows a component, holds values to their conditions or sends it to another process asks for nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.relation import Redundancy, Relation
from bristle.core.variable import Variable, is_array, is_integer, variables_of

__all__ = ["Described"]


@dataclass(frozen=True, kw_only=True)
class Described:
    """The data of a descriptor; `bristle.core.contracts.Component` says what each is."""

    name: str
    description: str
    Parameters: type
    State: type
    reference: str = ""
    relations: tuple[Relation, ...] = ()
    redundancies: tuple[Redundancy, ...] = ()
    example: Mapping[str, Any] = field(default_factory=dict, compare=False)
    module: str = field(default="", compare=False)

    family: ClassVar[str] = "component"

    def __post_init__(self) -> None:
        object.__setattr__(self, "module", self.module or self.Parameters.__module__)
        object.__setattr__(self, "example", ReadOnly(self.example))

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets, with its description, in order."""
        return ReadOnly(variables_of(self.Parameters))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self._written(getattr(self.Parameters, "_field_defaults", {}))

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return is_array(self.Parameters, name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return is_integer(self.Parameters, name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the `Parameters` that kernels receive, from the values that a person sets."""
        return self.Parameters(**values)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values that a person sets, from the `Parameters` that kernels receive."""
        return self._written(parameters._asdict())

    def _written(self, values: Mapping[str, Any]) -> dict[str, Any]:
        described = variables_of(self.Parameters)
        return {name: described[name].written(value) for name, value in values.items()}
