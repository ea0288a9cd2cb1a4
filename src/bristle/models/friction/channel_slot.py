r"""Slots that multiply friction by a function of a log channel: those of `bristle.models.friction.channels`, or user-defined.

.. math::
    F = g(c)\,F_\text{model} \qquad\text{or}\qquad F = F_\text{model} + (g(c) - 1)\,(F_\text{model} - F_v v)

with the channel :math:`c` at the middle of the step for the position, and at the end of the step for other channels.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from bristle.core import FrictionModel, InputError, Variable, kernel
from bristle.core.dispatch import friction_rate, friction_trial
from bristle.core.documented import relations_of
from bristle.core.formula import Paragraph
from bristle.core.lazy import once
from bristle.core.slot import LEVEL, Slot
from bristle.core.surroundings import Surrounding, motion_with, reader_of
from bristle.models.friction.enclosing import EnclosingModel, enclosed
from bristle.models.friction.level import viscous_of
from bristle.models.friction.variation import SMALLEST_FACTOR


class Kernels(NamedTuple):
    """Kernels of a slot, around any model: the class of its parameters, and the functions."""

    Parameters: Any
    trial: Callable[..., Any]
    rate: Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class ChannelSlotModel(EnclosingModel):
    """A friction model with a slot over a log channel."""

    slot: Slot

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return with_channel_slot, (self.inner, self.slot)

    @property
    def explanation(self) -> tuple[Paragraph, ...]:
        """Docstring of the file of the model, then that of the slot."""
        return (*self.inner.explanation, *self.slot.explanation)

    @property
    def slots(self) -> tuple[str, ...]:
        """Names of the slots."""
        return (self.slot.name,)

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """Inputs from the surroundings that the slots depend on."""
        return (*self.inner.surroundings, self.slot.channel)

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Parameters of the slot."""
        return self.slot.variables

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters."""
        return self.inner.defaults | self.slot.defaults

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of the kernels from the values of the user."""
        own = self.slot.assemble({name: values[name] for name in self.slot.variables})
        viscous = viscous_of(self.inner)
        return self.Parameters(self.inside(values), own, values[viscous] if viscous else 0.0)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        return self.inner.values(parameters.inner) | self.slot.values(parameters.slot)


def channel_slots_of(component: FrictionModel) -> tuple[Slot, ...]:
    """Return the channel slots of a model, built-in and user-defined, the outermost first."""
    layer: Any = component
    slots: tuple[Slot, ...] = ()
    while hasattr(layer, "inner"):
        slots += (layer.slot,) if isinstance(layer, ChannelSlotModel) else ()
        layer = layer.inner
    return slots


@once
def with_channel_slot(model: FrictionModel, slot: Slot) -> ChannelSlotModel:
    """Return `model` with a slot over a log channel.

    Raises
    ------
    InputError
        If the slot and the model share a name of a parameter, or two slots describe a channel differently.
    """
    both = [name for name in slot.variables if name in model.variables or name == "offset"]
    if both:
        raise InputError(
            f"has the name of a parameter of {model.name}",
            path=f"+{slot.name}",
            value=both[0],
            mend="Give the parameter of the slot another name",
        )
    motion_with((*model.surroundings, slot.channel))
    kernels = _kernels_of(slot)
    return enclosed(
        ChannelSlotModel,
        model,
        name=f"{model.name}+{slot.name}",
        description=f"{model.description}, varying with {slot.channel.variable.description}",
        Parameters=kernels.Parameters,
        trial=kernels.trial,
        rate=kernels.rate if model.rate else None,
        relations=(*relations_of(model), *(_of_slot(relation) for relation in slot.relations)),
        module=slot.module,
        example=dict(model.example) | dict(slot.example),
        slot=slot,
    )


def _of_slot(relation: Any) -> Any:
    return relation._replace(holds=lambda p: relation.holds(p.slot))


@kernel
def middle(motion, dt):
    """Return the position at the middle of the step [m or rad]."""
    return motion.x - 0.5 * dt * motion.v


def _reading_of(read: Callable[[Any], float]) -> Callable[[Any, float], float]:
    @kernel
    def at(motion, dt):
        return read(motion)

    return at


@once
def _kernels_of(slot: Slot) -> Kernels:
    factor, at = (
        slot.factor,
        middle if slot.channel.field == "x" else _reading_of(reader_of(slot.channel)),
    )

    @kernel
    def factor_at(motion, dt, p):
        return max(factor(at(motion, dt), p.slot), SMALLEST_FACTOR)

    @kernel
    def friction_varied(state, memory, motion, dt, p):
        force, move = friction_trial(state, memory, motion, dt, p.inner)
        return factor_at(motion, dt, p) * force, move

    @kernel
    def level_varied(state, memory, motion, dt, p):
        force, move = friction_trial(state, memory, motion, dt, p.inner)
        return force + (factor_at(motion, dt, p) - 1.0) * (force - p.viscous * motion.v), move

    @kernel
    def friction_varied_rate(state, motion, p):
        force, d_state = friction_rate(state, motion, p.inner)
        return factor_at(motion, 0.0, p) * force, d_state

    @kernel
    def level_varied_rate(state, motion, p):
        force, d_state = friction_rate(state, motion, p.inner)
        return force + (factor_at(motion, 0.0, p) - 1.0) * (force - p.viscous * motion.v), d_state

    trial, rate = (
        (level_varied, level_varied_rate)
        if slot.of == LEVEL
        else (friction_varied, friction_varied_rate)
    )
    return Kernels(_parameters_of(slot), trial, rate)


def _parameters_of(slot: Slot) -> type:
    """Return the parameter class of a model with this slot: a separate class for each slot, by which its kernels are found."""

    class WithSlot(NamedTuple):
        inner: Any
        slot: Any
        viscous: float

        def __reduce__(self) -> tuple[Any, ...]:
            return _parameters, (slot, tuple(self))

    WithSlot.__qualname__ = f"WithSlot_{slot.name}"
    return WithSlot


def _parameters(slot: Slot, values: tuple[Any, ...]) -> Any:
    return _kernels_of(slot).Parameters(*values)
