"""The model to try next, where another one lacks what friction depends on."""

from __future__ import annotations

from bristle.core.contracts import FrictionModel, Model
from bristle.core.motion import RECORDED
from bristle.friction import MODELS, base_of, is_static, with_slots
from bristle.friction.level import LEVELS, has_level
from bristle.friction.operator_kernel import REACHES
from bristle.friction.slots import directional, variations_of

__all__ = ["SLOT_OF", "model_with"]

SLOT_OF = {
    "direction": "asymmetry", "position": "position", "ripple": "periodic", "level": "ripple",
    "transmitted": "transmitted", **{name: name for name in RECORDED},
}  # fmt: skip
"""The slot that has what a cause needs."""


def model_with(cause: str, friction: Model) -> str:
    """Return the name of a model that has what another one lacks by a cause; empty where there is none."""
    component, base = friction.component, base_of(friction.component)
    if cause in SLOT_OF:
        return _beside(component, SLOT_OF[cause])
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


def _falls(component: FrictionModel) -> bool:
    """Return whether the friction of a model falls with speed: it has a speed over which it does."""
    return any(
        (variable.quantity, variable.excitation) == ("length/time", "stribeck")
        for variable in component.variables.values()
    )


def _takes(base: FrictionModel, slot: str) -> bool:
    """Return whether a model can have a slot: one that raises a level needs a level, and no elements that share it."""
    return slot not in LEVELS or (has_level(base) and not any(base.is_array(name) for name in base.variables))


def _beside(component: FrictionModel, slot: str) -> str:
    """Return the name of a model with one more slot; empty where it has that one."""
    operators = tuple(part for part in component.name.split("+") if part in REACHES)
    slots = (*operators, *variations_of(component), *(("asymmetry",) if directional(component) else ()))
    return (
        ""
        if slot in slots or not _takes(base_of(component), slot)
        else with_slots(base_of(component), (*slots, slot)).name
    )
