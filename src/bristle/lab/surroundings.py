"""What is around a contact, as parameters of it: on a page load, temperature and effort stand still, and are moved.

A kernel is told them with each step of the motion. A module on the page is told a position alone, so that this layer,
around all slots, tells the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED, FrictionModel, Motion
from bristle.core.dispatch import friction_trial
from bristle.core.kernel import kernel
from bristle.core.once import once
from bristle.core.surroundings import Surrounding
from bristle.core.variable import Variable
from bristle.friction.enclosing import EnclosingModel, commit

__all__ = ["AROUND", "surrounded"]


class Surroundings(NamedTuple):
    """Load, temperature and effort; their names are those of no parameter of a model."""

    around_load: Annotated[float, Variable("1", "load over its nominal value")] = NOMINAL_LOAD
    around_temperature: Annotated[float, Variable("temperature", "temperature")] = NOMINAL_TEMPERATURE
    around_transmitted: Annotated[float, Variable("force", "effort that passes on")] = NOTHING_TRANSMITTED


AROUND = {"load": "around_load", "temperature": "around_temperature", "transmitted": "around_transmitted"}
"""For each slot that needs more than the motion, what it needs."""


class Surrounded(NamedTuple):
    """Parameters of a model and what is around it."""

    inner: Any
    around: Surroundings


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of the model inside, and its move, where it is told what is around it."""
    passed = motion.transmitted + p.around.around_transmitted
    around = Motion(motion.v, motion.x, p.around.around_load, p.around.around_temperature, passed)
    force, move = friction_trial(state, memory, around, dt, p.inner)
    return force, move


@dataclass(frozen=True, kw_only=True)
class SurroundedModel(EnclosingModel):
    """A friction model with what is around it."""

    coefficients = Surroundings
    of_slot = MappingProxyType({"around": Surroundings._fields})
    without_default = ()
    depends_on = MappingProxyType({})

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """What of its surroundings no parameter tells."""
        return tuple(item for item in self.inner.surroundings if f"around_{item.name}" not in Surroundings._fields)

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults | Surroundings._field_defaults

    def assemble(self, values: Mapping[str, Any]) -> Surrounded:
        """Return what kernels receive, from the values that a person sets."""
        inner = {name: values[name] for name in self.inner.variables}
        return Surrounded(self.inner.assemble(inner), Surroundings(**{name: values[name] for name in self.own}))

    def values(self, parameters: Surrounded) -> dict[str, Any]:
        """Return the values that a person sets, from what kernels receive."""
        return self.inner.values(parameters.inner) | parameters.around._asdict()


@once
def surrounded(model: FrictionModel) -> SurroundedModel:
    """Return a friction model whose parameters tell what is around it."""
    return SurroundedModel(
        name=model.name,
        description=model.description,
        Parameters=Surrounded,
        State=model.State,
        trial=trial,
        commit=commit,
        memory_size=lambda p: model.memory_size(p.inner),
        reference=model.reference,
        module=model.module,
        example=dict(model.example),
        inner=model,
        slots=("around",),
    )
