r"""Slots: additions to any friction model.

Some slots let friction vary (`bristle.models.friction.variation`). Others raise the level of its dry part
(`bristle.models.friction.level`), or multiply friction by a function of a log channel, built-in or user-defined
(`bristle.models.friction.channel_slot`). ``+asymmetry`` lets the directional parameters of a model differ between the
directions of motion (``F_C`` becomes ``F_C_pos`` and ``F_C_neg``), and every model takes a constant ``offset``:

.. math:: F = F_\pm(v, \dots) + F_\text{offset}

The slot is a layer around the model. The sign of the velocity selects the direction. The velocities :math:`\pm 0` are
the two one-sided limits, so that a model with a set of forces at rest still sticks. In steady sliding an offset and a
direction-dependent Coulomb force are confounded: the log has two levels for three unknowns.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from bristle.core import FrictionModel, InputError, Model, Relation, Variable, did_you_mean, kernel
from bristle.core.dimensions import exponents_of
from bristle.core.dispatch import (
    friction_arrival,
    friction_commit,
    friction_flow,
    friction_piece,
    friction_rate,
    friction_trial,
    friction_trial_sided,
)
from bristle.core.edge import component, guarded, model
from bristle.core.lazy import cached_property, once
from bristle.core.mathematics import direction
from bristle.core.read_only import ReadOnly
from bristle.models.friction.channel_slot import ChannelSlotModel, channel_slots_of
from bristle.models.friction.channels import CHANNEL_SLOTS
from bristle.models.friction.enclosing import EnclosingModel
from bristle.models.friction.level import LEVELS, RISES_WITH, Rise, Risen
from bristle.models.friction.variation import ADDS, VARIATIONS, VARIES_WITH, Place, Varied

SLOTS = (*VARIATIONS, *LEVELS, *CHANNEL_SLOTS, "asymmetry")
OPERATOR_SLOTS = ("everett_table", "reversal_table", "preisach_grid", "prandtl_ishlinskii")
"""The operators that can replace the kernel of a model, also written as slots."""
WHAT_SLOTS_DO = (
    {name: f"friction that varies with {cause}" for name, cause in VARIES_WITH.items()}
    | ADDS
    | {
        name: f"a level of dry friction that changes with {cause}"
        for name, cause in RISES_WITH.items()
    }
    | {name: slot.description for name, slot in CHANNEL_SLOTS.items()}
    | {"asymmetry": "one value per direction of motion for some parameters, NAME_pos and NAME_neg"}
)
"""The effect of each slot, in a few words."""
PARAMETERS_OF_SLOTS: dict[str, tuple[str, ...]] = {
    **VARIATIONS,
    **LEVELS,
    **{name: tuple(slot.variables) for name, slot in CHANNEL_SLOTS.items()},
    "asymmetry": (),
}
"""The parameters of each slot."""
OFFSET = Variable(
    "force", "constant part of the friction force (gravity, bias)", excitation="sliding"
)


class Slotted(NamedTuple):
    """Parameters of a model with slots: a set for each direction, and the offset."""

    forward: Any
    backward: Any
    offset: float


class Sided(NamedTuple):
    """The same for a model that depends on the side that the contact leans to."""

    forward: Any
    backward: Any
    offset: float


class SlottedMove(NamedTuple):
    """Result of a trial, applied by commit: the move of the model, and its side."""

    move: Any
    side: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of the model with the parameters of this side, plus the offset."""
    side = direction(motion.v)
    q = p.forward if side > 0.0 else p.backward
    force, move = friction_trial(state, memory, motion, dt, q)
    return force + p.offset, SlottedMove(move, side)


@kernel
def trial_sided(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of a model that takes both sides, plus the offset."""
    force, move = friction_trial_sided(state, memory, motion, dt, p.backward, p.forward)
    return force + p.offset, SlottedMove(move, direction(motion.v))


@kernel
def commit(state, memory, move, p):
    """Commit the move of the model with the parameters of the side of the move."""
    q = p.forward if move.side > 0.0 else p.backward
    return friction_commit(state, memory, move.move, q)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the rate of the state of the model with the parameters of this side."""
    q = p.forward if direction(motion.v) > 0.0 else p.backward
    force, d_state = friction_rate(state, motion, q)
    return force + p.offset, d_state


@kernel
def piece(state, memory, motion, p):
    """Return the variables, and the constants until the next event, with the parameters of this side."""
    return friction_piece(
        state, memory, motion, p.forward if direction(motion.v) > 0.0 else p.backward
    )


@kernel
def flow(contact, piece, motion, p):
    """Return force [N or N*m], rate and margin with the parameters of the side of the piece, plus the offset."""
    force, d_contact, margin = friction_flow(
        contact, piece, motion, p.forward if piece.side > 0.0 else p.backward
    )
    return force + p.offset, d_contact, margin


@kernel
def arrival(state, memory, contact, p):
    """Return the move to an event; memory does not depend on the direction."""
    return SlottedMove(friction_arrival(state, memory, contact, p.forward), 1.0)


@dataclass(frozen=True, kw_only=True)
class SlottedModel(EnclosingModel):
    """A friction model with an offset and, if requested, separate parameters for each direction."""

    asymmetry: bool

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _slotted, (self.inner, self.asymmetry)

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Description of the offset."""
        return {"offset": OFFSET}

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Description of each parameter: those of the model, by direction, and the offset."""
        variables: dict[str, Variable] = {}
        for name, variable in self.inner.variables.items():
            for key in self.keys(name):
                variables[key] = replace(
                    variable, description=variable.description + _SIDES.get(key[len(name) :], "")
                )
        return ReadOnly(variables | dict(self.beside))

    @cached_property
    def defaults(self) -> ReadOnly[str, Any]:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Default values of the parameters."""
        inner = self.inner.defaults
        return ReadOnly(
            {key: inner[name] for name in inner for key in self.keys(name)} | {"offset": 0.0}
        )

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the model inside."""
        return self.inner.initial_state(parameters.forward)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return both sides and the offset from the values of the user."""
        forward = backward = self.inner.assemble(
            {name: values[keys[0]] for name, keys in self._keys}
        )
        if self.asymmetry:
            backward = self.inner.assemble({name: values[keys[-1]] for name, keys in self._keys})
        return self.Parameters(forward, backward, values["offset"])

    @cached_property
    def _keys(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        return tuple((name, self.keys(name)) for name in self.inner.variables)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the user from both sides and the offset."""
        forward, backward = (
            self.inner.values(parameters.forward),
            self.inner.values(parameters.backward),
        )
        values = {}
        for name in self.inner.variables:
            keys = self.keys(name)
            values |= dict(
                zip(
                    keys,
                    (forward[name], backward[name]) if len(keys) == 2 else (forward[name],),
                    strict=True,
                )
            )
        return values | {"offset": parameters.offset}

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the names of an inner parameter here: its name, or a name for each direction."""
        if self.asymmetry and self.inner.variables[name].directional:
            return (f"{name}_pos", f"{name}_neg")
        return (name,)


@guarded(component=component("friction"))
def base_of(component: FrictionModel) -> FrictionModel:
    """Return the model inside all slots."""
    base: Any = component
    while hasattr(base, "inner"):
        base = base.inner
    return base


@cache
def by_direction(component: FrictionModel, name: str) -> tuple[str, ...]:
    """Return the names of a parameter of the model inside: forward and backward separately if they may differ."""
    layer = _slotted_layer(component)
    if layer is not None and name in layer.inner.variables:
        return layer.keys(name)
    return (name,)


@cache
def directional(component: FrictionModel) -> tuple[str, ...]:
    """Return the parameters that have a value for each direction."""
    layer = _slotted_layer(component)
    keys = [layer.keys(name) for name in layer.inner.variables] if layer is not None else []
    return tuple(key for pair in keys if len(pair) > 1 for key in pair)


def _slotted_layer(component: FrictionModel) -> SlottedModel | None:
    layer: Any = component
    while layer is not None and not isinstance(layer, SlottedModel):
        layer = getattr(layer, "inner", None)
    return layer


@guarded(component=component("friction"))
def variations_of(component: FrictionModel) -> tuple[str, ...]:
    """Return the slots that let a model vary."""
    layer: Any = component
    slots: tuple[str, ...] = ()
    while hasattr(layer, "inner"):
        slots += getattr(layer, "slots", ())
        layer = layer.inner
    return slots


def slot_needing(component: FrictionModel, channel: str) -> str:
    """Return the slot of a model for a log channel; the name of the channel if no channel slot needs it."""
    return next(
        (slot.name for slot in channel_slots_of(component) if slot.channel.name == channel), channel
    )


@guarded(friction=model("friction"))
def unvaried(friction: Model) -> Model:
    """Return a friction model without variation: with its values at the middle of the range, at nominal load and temperature."""
    p, inner = friction.parameters, getattr(friction.component, "inner", None)
    if not isinstance(p, Slotted) or not getattr(inner, "slots", ()):
        return friction
    still = p._replace(forward=_still(inner, p.forward), backward=_still(inner, p.backward))
    return Model(friction.component, still, friction.kind)


def _still(layer: Any, p: Any) -> Any:
    """Return parameters of layers without variation."""
    if isinstance(layer, ChannelSlotModel):
        return p._replace(slot=layer.slot.neutral, inner=_still(layer.inner, p.inner))
    if isinstance(p, Varied):
        return p._replace(place=Place(), inner=_still(layer.inner, p.inner))
    return p._replace(rise=Rise()) if isinstance(p, Risen) else p


_SIDES = {"_pos": ", moving forward", "_neg": ", moving backward"}


@guarded(model=component("friction"))
def slotted(model: FrictionModel, *, asymmetry: bool) -> SlottedModel:
    """Return `model` with an offset and, if requested, separate parameters for each direction."""
    return _slotted(model, asymmetry)


@once
def _slotted(model: FrictionModel, asymmetry: bool) -> SlottedModel:
    sided = asymmetry and model.trial_sided is not None
    first = model.start
    return SlottedModel(
        name=model.name + "+asymmetry" * asymmetry,
        description=model.description + ", by direction" * asymmetry,
        Parameters=Sided if sided else Slotted,
        State=model.State,
        trial=trial_sided if sided else trial,
        commit=commit,
        rate=rate if model.rate and not sided else None,
        piece=piece if model.piece else None,
        flow=flow if model.flow else None,
        arrival=arrival if model.arrival else None,
        start=None if first is None else lambda place, p: first(place, p.backward, p.forward),
        memory_size=lambda p: model.memory_size(p.forward),
        reference=model.reference,
        relations=tuple(_on_both_sides(relation) for relation in model.relations),
        redundancies=model.redundancies,
        linear=model.linear,
        module=model.module,
        example=_slotted_example(model, asymmetry),
        inner=model,
        asymmetry=asymmetry,
    )


def _slotted_example(model: FrictionModel, asymmetry: bool) -> dict[str, Any]:
    """Return the example of the model with 10 % more force forward and 10 % less backward, for directional parameters."""
    values: dict[str, Any] = {}
    for name, value in model.example.items():
        if name not in model.variables:
            raise InputError(
                f"the example has {name}, but {model.name} has no such parameter",
                path="example",
                value=value,
                allowed=", ".join(model.variables),
                mend=did_you_mean(name, model.variables),
            )
        if asymmetry and model.variables[name].directional:
            values |= {f"{name}_pos": 1.1 * value, f"{name}_neg": 0.9 * value}
        else:
            values[name] = value
    return values


def _on_both_sides(relation: Relation) -> Relation:
    return relation._replace(holds=lambda p: all(relation.holds(side) for side in _sides(p)))


def _sides(p: Any) -> tuple[Any, ...]:
    return (p.forward,) if p.backward is p.forward else (p.forward, p.backward)


VISCOUS = ("force*time/length", "speed")


def whole_parts(friction: Model) -> dict[str, float]:
    """Return the constant part [N or N*m] and the viscous part [N*s/m or N*m*s/rad] of a friction model.

    Of two viscous coefficients, one for each direction, the smaller one counts.
    """
    variables = friction.component.variables
    values = friction.values
    constants = [values[name] for name, variable in variables.items() if variable == OFFSET]
    slopes = [
        values[name]
        for name, variable in variables.items()
        if (variable.quantity, variable.excitation) == VISCOUS
    ]
    return {"constant": float(sum(constants)), "viscous": float(min(slopes, default=0.0))}


def scaled(friction: Model, factor: float, *, whole: bool = False) -> Model:
    """Return a friction model whose force has another size; with `whole`, its constant and viscous parts stay."""
    values = {}
    for name, variable in friction.component.variables.items():
        stays = variable == OFFSET or (variable.quantity, variable.excitation) == VISCOUS
        power = exponents_of(variable.quantity).get("force", 0.0)
        if power and not (whole and stays):
            values[name] = friction.values[name] * factor**power
    return friction.with_values(**values)
