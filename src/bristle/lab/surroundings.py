"""What is around a contact, as parameters of it: on a page load, temperature and so on stand still, and are moved.

A kernel is told them with each step of the motion. A module on the page is told a position alone, so that layers around
all slots tell the rest: one what a motion holds, and one inside of it what slots of this model need beyond that.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED, FrictionModel, Motion
from bristle.core.dispatch import friction_trial
from bristle.core.kernel import kernel
from bristle.core.lazy import once
from bristle.core.surroundings import Surrounding, motion_with
from bristle.core.variable import Variable
from bristle.exports.scope import defined
from bristle.friction.enclosing import CoefficientsModel, EnclosingModel, enclosed


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
        SurroundedModel,
        _with_channels(model),
        name=model.name,
        description=model.description,
        Parameters=Surrounded,
        trial=trial,
        slots=("around",),
    )


WITH_CHANNELS = """
def trial(state, memory, motion, dt, p):
    force, move = friction_trial(state, memory, Motion({values}), dt, p.inner)
    return force, move
"""


@dataclass(frozen=True, kw_only=True)
class WithChannels(EnclosingModel):
    """A friction model with the further channels that its slots depend on."""

    channels: tuple[Surrounding, ...]

    @property
    def beside(self) -> Mapping[str, Variable]:
        """The channels, described."""
        return {around_named(channel): channel.variable for channel in self.channels}

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """What of its surroundings no parameter tells."""
        return tuple(item for item in self.inner.surroundings if item not in self.channels)

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults | {around_named(channel): channel.usual for channel in self.channels}

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return what kernels receive, from the values that a person sets."""
        return self.Parameters(self.inside(values), *(values[name] for name in self.beside))

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values that a person sets, from what kernels receive."""
        return self.inner.values(parameters.inner) | {name: getattr(parameters, name) for name in self.beside}


def around_named(channel: Surrounding) -> str:
    """Return what the number of a channel is called on a page; the name is that of no parameter of a model."""
    return f"around_{channel.name}"


def _with_channels(model: FrictionModel) -> FrictionModel:
    """Return a friction model whose parameters tell what a motion does not hold; the model where that holds all."""
    channels = tuple(dict.fromkeys(channel for channel in model.surroundings if channel.is_own))
    if not channels:
        return model
    names = [around_named(channel) for channel in channels]
    values = ", ".join([*(f"motion.{field}" for field in Motion._fields), *(f"p.{name}" for name in names)])
    scope = {"__name__": __name__, "friction_trial": friction_trial, "Motion": motion_with(channels)}
    return enclosed(
        WithChannels,
        model,
        name=model.name,
        description=model.description,
        Parameters=namedtuple("WithChannels", ("inner", *names)),
        trial=kernel(defined("trial", WITH_CHANNELS.format(values=values), scope)),
        channels=channels,
    )
