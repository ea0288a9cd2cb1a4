r"""Slots of a person's own: the friction of a model, varied by a factor of one channel of a log.

.. math::
    F = g(c)\,F_\text{model} \qquad\text{or}\qquad F = F_\text{model} + (g(c) - 1)\,(F_\text{model} - F_v v)

with the channel :math:`c` at the middle of the step where it is the position, and at its end otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core.contracts import FrictionModel
from bristle.core.dispatch import friction_rate, friction_trial
from bristle.core.errors import InputError
from bristle.core.kernel import kernel
from bristle.core.lazy import cached_property
from bristle.core.once import once
from bristle.core.read_only import ReadOnly
from bristle.core.slot import LEVEL, Slot
from bristle.core.surroundings import Surrounding, motion_with, reader_of
from bristle.core.variable import Variable
from bristle.friction.enclosing import commit, relations_of
from bristle.friction.level import viscous_of
from bristle.friction.variation import SMALLEST_FACTOR

if TYPE_CHECKING:
    from bristle.core.docstring import Paragraph

__all__ = ["OwnSlotModel", "own_slots_of", "with_own_slot"]


class Kernels(NamedTuple):
    """What one slot runs as, around any model: the class of its parameters, and the functions."""

    Parameters: Any
    trial: Callable[..., Any]
    rate: Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class OwnSlotModel(FrictionModel):
    """A friction model with a slot of a person's own."""

    inner: FrictionModel
    slot: Slot

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return with_own_slot, (self.inner, self.slot)

    @property
    def explanation(self) -> tuple[Paragraph, ...]:
        """What the docstring of the file of the model says, then that of the slot."""
        return (*self.inner.explanation, *self.slot.explanation)

    @property
    def slots(self) -> tuple[str, ...]:
        """Names of its slots."""
        return (self.slot.name,)

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """What of its surroundings its slots depend on."""
        return (*self.inner.surroundings, self.slot.channel)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets: those of the model, then those of the slot."""
        return ReadOnly(self.inner.variables | self.slot.variables)

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults | self.slot.defaults

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the model inside."""
        return self.inner.initial_state(parameters.inner)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name not in self.slot.variables and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name not in self.slot.variables and self.inner.is_integer(name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return what kernels receive, from the values that a person sets."""
        inner = self.inner.assemble({name: values[name] for name in self.inner.variables})
        own = self.slot.assemble({name: values[name] for name in self.slot.variables})
        viscous = viscous_of(self.inner)
        return self.Parameters(inner, own, values[viscous] if viscous else 0.0)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values that a person sets, from what kernels receive."""
        return self.inner.values(parameters.inner) | self.slot.values(parameters.slot)


def own_slots_of(component: FrictionModel) -> tuple[Slot, ...]:
    """Return the slots of a person's own that a model has, the outermost first."""
    layer: Any = component
    slots: tuple[Slot, ...] = ()
    while hasattr(layer, "inner"):
        slots += (layer.slot,) if isinstance(layer, OwnSlotModel) else ()
        layer = layer.inner
    return slots


@once
def with_own_slot(model: FrictionModel, slot: Slot) -> OwnSlotModel:
    """Return `model` with a slot of a person's own.

    Raises
    ------
    InputError
        If a parameter of both has one name, or two slots do not agree about a channel.
    """
    both = [name for name in slot.variables if name in model.variables or name == "offset"]
    if both:
        raise InputError(f"is a parameter of {model.name} already", path=f"+{slot.name}", value=both[0],
                         mend="Give the parameter of the slot another name")  # fmt: skip
    motion_with((*model.surroundings, slot.channel))
    kernels = _kernels_of(slot)
    return OwnSlotModel(
        name=f"{model.name}+{slot.name}",
        description=f"{model.description}, varying with {slot.channel.variable.description}",
        Parameters=kernels.Parameters,
        State=model.State,
        trial=kernels.trial,
        commit=commit,
        rate=kernels.rate if model.rate else None,
        memory_size=lambda p: model.memory_size(p.inner),
        reference=model.reference,
        relations=(*relations_of(model), *(_of_slot(relation) for relation in slot.relations)),
        module=slot.module,
        example=dict(model.example) | dict(slot.example),
        inner=model,
        slot=slot,
    )


def _of_slot(relation: Any) -> Any:
    return relation._replace(holds=lambda p: relation.holds(p.slot))


@kernel
def middle(motion, dt):
    """Return the position at the middle of the step [m or rad]."""
    return motion.x - 0.5 * dt * motion.v


def _told_by(read: Callable[[Any], float]) -> Callable[[Any, float], float]:
    @kernel
    def at(motion, dt):
        return read(motion)

    return at


@once
def _kernels_of(slot: Slot) -> Kernels:
    factor, at = slot.factor, middle if slot.channel.field == "x" else _told_by(reader_of(slot.channel))

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

    trial, rate = (level_varied, level_varied_rate) if slot.of == LEVEL else (friction_varied, friction_varied_rate)
    return Kernels(_parameters_of(slot), trial, rate)


def _parameters_of(slot: Slot) -> type:
    """Return the class of the parameters of a model with a slot: one for each slot, by which its kernels are found."""

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
