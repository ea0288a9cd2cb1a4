"""The model to try next, where another one lacks what friction depends on."""

from bristle.core.contracts import FrictionModel, Model
from bristle.core.motion import RECORDED
from bristle.core.slot import Slot
from bristle.core.surroundings import OF_MOTION
from bristle.friction import CHANNEL_SLOTS, MODELS, base_of, channel_slots_of, is_static, with_slots
from bristle.friction.level import LEVELS, has_level
from bristle.friction.operator_kernel import REACHES
from bristle.friction.slots import directional, variations_of

CHANNELS = {slot.channel.name: slot.channel for slot in CHANNEL_SLOTS.values()} | {name: OF_MOTION[name] for name in RECORDED}
"""What of the surroundings a slot of bristle depends on and a log may have, by name."""
SLOT_OF = {
    "direction": "asymmetry",
    "position": "position",
    "ripple": "periodic",
    "level": "ripple",
    "transmitted": "transmitted",
    **{slot.channel.name: name for name, slot in CHANNEL_SLOTS.items()},
    **{name: name for name in RECORDED},
}
"""The slot that has what a cause needs."""


def model_with(cause: str, friction: Model) -> str:
    """Return the name of a model that has what another one lacks by a cause; empty where there is none."""
    component, base = friction.component, base_of(friction.component)
    if cause in CHANNELS and cause in {surrounding.name for surrounding in component.surroundings}:
        return ""
    if cause in SLOT_OF:
        return _beside(component, base, SLOT_OF[cause])
    if cause == "presliding":
        return "lugre"
    if cause == "hysteresis":  # nothing but loops before sliding: the fewest parameters that remember where they turned
        return "preisach_contact"
    if cause == "lag":
        return "" if base is MODELS["gms"] else "gms"
    if cause != "speed":
        return ""
    if not is_static(friction) and not _falls(component):
        return "lugre"
    return "" if base is MODELS["stribeck_free"] else "stribeck_free"


def nested_in(component: FrictionModel) -> tuple[FrictionModel, ...]:
    """Return the models that one is for some values of its parameters: with one slot less, or of a curve that only falls."""
    base, slots = base_of(component), _slots_of(component)
    if with_slots(base, slots) != component:
        return ()
    fewer = [tuple(part for part in slots if part is not slot) for slot in slots if slot not in REACHES]
    falling = [with_slots(MODELS["stribeck"], slots)] if base is MODELS["stribeck_free"] else []
    return (*(with_slots(base, parts) for parts in fewer), *falling)


def goes_by_name(component: FrictionModel) -> bool:
    """Return whether a model is found by its name: neither it nor a slot of it is a person's own."""
    base = base_of(component)
    return MODELS.get(base.name) is base and not _own_slots(component)


def _own_slots(component: FrictionModel) -> dict[str, Slot]:
    """Return the slots of a person's own that a model has, by name."""
    return {slot.name: slot for slot in channel_slots_of(component) if CHANNEL_SLOTS.get(slot.name) != slot}


def _falls(component: FrictionModel) -> bool:
    """Return whether the friction of a model falls with speed: it has a speed over which it does."""
    return any((variable.quantity, variable.excitation) == ("length/time", "stribeck") for variable in component.variables.values())


def _beside(component: FrictionModel, base: FrictionModel, slot: str) -> str:
    """Return the name of a model with one more slot; empty where it has that one, or cannot have it."""
    # A slot that raises a level needs a level, and no elements that share it.
    if slot in (*LEVELS, *CHANNEL_SLOTS) and (not has_level(base) or any(map(base.is_array, base.variables))):
        return ""
    return "" if slot in component.name.split("+") else with_slots(base, (*_slots_of(component), slot)).name


def _slots_of(component: FrictionModel) -> tuple[str | Slot, ...]:
    """Return the slots of a model, those of bristle by name, as `with_slots` takes them."""
    operators, own = (part for part in component.name.split("+") if part in REACHES), _own_slots(component)
    names = (*operators, *reversed(variations_of(component)), *(("asymmetry",) if directional(component) else ()))
    return tuple(own.get(name, name) for name in names)
