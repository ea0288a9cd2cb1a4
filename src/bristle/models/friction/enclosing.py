"""Friction models around another model: they add parameters to those of the model inside."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from bristle.core import FrictionModel, Surrounding, Variable, kernel, variables_of
from bristle.core.dispatch import friction_commit
from bristle.core.documented import Enclosing, relations_of


@kernel
def commit(state, memory, move, p):
    """Commit the move of the model inside."""
    return friction_commit(state, memory, move, p.inner)


@dataclass(frozen=True, kw_only=True)
class EnclosingModel(Enclosing, FrictionModel):
    """A friction model around another one.

    Parameters
    ----------
    inner : FrictionModel
        The model inside.
    """

    inner: FrictionModel


@dataclass(frozen=True, kw_only=True)
class CoefficientsModel(EnclosingModel):
    """A friction model with slots that have coefficients; the class determines the slots.

    Parameters
    ----------
    slots : tuple of str
        Names of its slots.
    """

    slots: tuple[str, ...]
    coefficients: ClassVar[type]
    """Named tuple of the coefficients of all slots, in addition to the parameters of the model inside."""
    of_slot: ClassVar[Mapping[str, tuple[str, ...]]]
    """Coefficients of each slot."""
    without_default: ClassVar[tuple[str, ...]]
    """Coefficients that must be given."""
    depends_on: ClassVar[Mapping[str, Surrounding]]
    """Inputs from the surroundings that each slot depends on."""

    @property
    def own(self) -> tuple[str, ...]:
        """Coefficients of the slots."""
        return tuple(name for slot in self.slots for name in self.of_slot[slot])

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Descriptions of the coefficients of the slots."""
        variables = variables_of(self.coefficients)
        return {name: variables[name] for name in self.own}

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """Inputs from the surroundings that the slots depend on."""
        own = (self.depends_on[slot] for slot in self.slots if slot in self.depends_on)
        return (*self.inner.surroundings, *own)

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters; a range and a pitch have none."""
        return self.inner.defaults | {
            name: 0.0 for name in self.own if name not in self.without_default
        }

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of the kernels from the values of the user."""
        return self.Parameters(
            self.inside(values), self.coefficients(**{name: values[name] for name in self.own})
        )

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        inner, coefficients = parameters
        return self.inner.values(inner) | {name: getattr(coefficients, name) for name in self.own}


E = TypeVar("E", bound=EnclosingModel)


def enclosed(made: type[E], model: FrictionModel, **facts: Any) -> E:
    """Return a model around another model, with the same facts except for those given."""
    alike = {
        "State": model.State,
        "commit": commit,
        "memory_size": lambda p: model.memory_size(p.inner),
        "reference": model.reference,
        "relations": relations_of(model),
        "module": model.module,
        "example": dict(model.example),
        "inner": model,
    }
    return made(**(alike | facts))
