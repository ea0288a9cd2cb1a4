"""The next model to try, if a model lacks a cause of friction."""

from bristle.core import FrictionModel, Model, Slot
from bristle.core.motion import RECORDED
from bristle.core.surroundings import OF_MOTION
from bristle.models.friction import (
    CHANNEL_SLOTS,
    MODELS,
    base_of,
    channel_slots_of,
    is_static,
    with_slots,
)
from bristle.models.friction.level import LEVELS, has_level
from bristle.models.friction.slots import OPERATOR_SLOTS, directional, variations_of

CHANNELS = {slot.channel.name: slot.channel for slot in CHANNEL_SLOTS.values()} | {
    name: OF_MOTION[name] for name in RECORDED
}
"""Inputs from the surroundings of built-in slots that a log may have, by name."""
SLOT_OF = {
    "direction": "asymmetry",
    "position": "position",
    "ripple": "periodic",
    "level": "ripple",
    "transmitted": "transmitted",
    **{slot.channel.name: name for name, slot in CHANNEL_SLOTS.items()},
    **{name: name for name in RECORDED},
}
"""The slot for each cause."""


def model_with(cause: str, friction: Model) -> str:
    """Return the name of a model with a cause that `friction` lacks; empty if there is none."""
    component, base = friction.component, base_of(friction.component)
    if cause in CHANNELS and cause in {surrounding.name for surrounding in component.surroundings}:
        return ""
    if cause in SLOT_OF:
        return _beside(component, base, SLOT_OF[cause])
    if cause == "presliding":
        return "lugre"
    if cause == "hysteresis":  # pre-sliding loops only: the fewest parameters with turning points
        return "preisach_contact"
    if cause == "lag":
        return "" if base is MODELS["gms"] else "gms"
    if cause != "speed":
        return ""
    if not is_static(friction) and not _falls(component):
        return "lugre"
    return "" if base is MODELS["stribeck_free"] else "stribeck_free"


def nested_in(component: FrictionModel) -> tuple[FrictionModel, ...]:
    """Return the models that a model contains as special cases: with a slot less, or with a curve that only falls."""
    base, slots = base_of(component), _slots_of(component)
    if with_slots(base, slots) != component:
        return ()
    fewer = [
        tuple(part for part in slots if part is not slot)
        for slot in slots
        if slot not in OPERATOR_SLOTS
    ]
    falling = [with_slots(MODELS["stribeck"], slots)] if base is MODELS["stribeck_free"] else []
    return (*(with_slots(base, parts) for parts in fewer), *falling)


def goes_by_name(component: FrictionModel) -> bool:
    """Return whether a name is enough to find a model: neither the model nor a slot of it is user-defined."""
    base = base_of(component)
    return MODELS.get(base.name) is base and not _own_slots(component)


def _own_slots(component: FrictionModel) -> dict[str, Slot]:
    """Return the user-defined slots of a model, by name."""
    return {
        slot.name: slot
        for slot in channel_slots_of(component)
        if CHANNEL_SLOTS.get(slot.name) != slot
    }


def _falls(component: FrictionModel) -> bool:
    """Return whether the friction of a model falls with speed: it has a Stribeck velocity."""
    return any(
        (variable.quantity, variable.excitation) == ("length/time", "stribeck")
        for variable in component.variables.values()
    )


def _beside(component: FrictionModel, base: FrictionModel, slot: str) -> str:
    """Return the name of a model with one more slot; empty if it has that slot already, or cannot have it."""
    # A slot that raises a level needs a level, and no elements that share it.
    if slot in (*LEVELS, *CHANNEL_SLOTS) and (
        not has_level(base) or any(map(base.is_array, base.variables))
    ):
        return ""
    if slot in component.name.split("+"):
        return ""
    return with_slots(base, (*_slots_of(component), slot)).name


def _slots_of(component: FrictionModel) -> tuple[str | Slot, ...]:
    """Return the slots of a model, built-in slots by name, in the form of `with_slots`."""
    operators, own = (
        (part for part in component.name.split("+") if part in OPERATOR_SLOTS),
        _own_slots(component),
    )
    names = (
        *operators,
        *reversed(variations_of(component)),
        *(("asymmetry",) if directional(component) else ()),
    )
    return tuple(own.get(name, name) for name in names)
