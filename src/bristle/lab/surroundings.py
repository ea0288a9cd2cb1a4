"""What is around a contact, as parameters of it: on a page load, temperature and so on stand still, and are moved.

A kernel is told them with each step of the motion. A module on the page is told a position alone, so that a layer around
all slots tells the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED, FrictionModel, Motion
from bristle.core.dispatch import friction_trial
from bristle.core.kernel import kernel
from bristle.core.lazy import once
from bristle.core.surroundings import Surrounding
from bristle.core.variable import Variable
from bristle.friction.enclosing import CoefficientsModel, enclosed


class Surroundings(NamedTuple):
    """Load, temperature and effort; their names are those of no parameter of a model."""

    around_load: Annotated[float, Variable("1", "load over its nominal value")] = NOMINAL_LOAD
    around_temperature: Annotated[float, Variable("temperature", "temperature")] = NOMINAL_TEMPERATURE
    around_transmitted: Annotated[float, Variable("force", "effort that passes on")] = NOTHING_TRANSMITTED


# For each slot that needs more than the motion, what it needs.
AROUND = {"load": "around_load", "temperature": "around_temperature", "transmitted": "around_transmitted"}


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
class SurroundedModel(CoefficientsModel):
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


@once
def surrounded(model: FrictionModel) -> SurroundedModel:
    """Return a friction model whose parameters tell what is around it."""
    return enclosed(
        SurroundedModel, model, name=model.name, description=model.description, Parameters=Surrounded, trial=trial, slots=("around",)
    )
