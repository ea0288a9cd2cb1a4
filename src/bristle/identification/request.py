"""What a person asks to be identified, checked against what the log and the model allow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel, Model
from bristle.core.errors import InputError
from bristle.core.units import quantity
from bristle.core.variable import Kind, Variable
from bristle.friction import MODELS, base_of, find
from bristle.friction.slots import OFFSET, SlottedModel, slotted
from bristle.friction.variation import MIDDLE
from bristle.identification.fixed_shape import ELEMENT_MODELS
from bristle.identification.inputs import number_or_text
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.settings import Settings
from bristle.logs.log import Log
from bristle.plants import PLANTS, inertia

__all__ = [
    "METHODS",
    "freed",
    "models_of",
    "prior_knowledge_of",
    "settings_of",
    "with_method",
]

ALL = "all"
METHODS = ("inverse_dynamics", "output_error")
MASS = Variable("mass", "moving mass or inertia")


def models_of(model: Any) -> tuple[FrictionModel, ...]:
    """Return the friction models that are asked for.

    Parameters
    ----------
    model : str, FrictionModel or a list of either
        Names with slots, ``"coulomb_viscous+asymmetry"``, several separated by commas. ``"all"`` is each model that can
        be identified and is not named beside it, ``"all+asymmetry"`` each with its slot.

    Raises
    ------
    InputError
        If there is no such model or slot, one is given twice or under a name that is taken, or it has parameters that
        this method does not identify.
    """
    asked = _one_by_one(model)
    found: dict[str, FrictionModel] = {}
    for component in (_component_of(one) for one in asked if not _is_all(one)):
        if component.name in found:
            raise InputError("is asked for twice", path="model", value=component.name,
                             mend="Write it once; give a model of your own a name of its own")  # fmt: skip
        _refuse_arrays(component)
        found[component.name] = component
    for one in (one for one in asked if _is_all(one)):
        found |= {each.name: each for each in _every(one) if each.name not in found}
    if not found:
        raise InputError("names no friction model", path="model", value=model, mend='Write "coulomb_viscous"')
    return tuple(found.values())


def _one_by_one(model: Any) -> list[Any]:
    """Return what is asked for, names apart."""
    found: list[Any] = []
    for one in model if isinstance(model, (list, tuple)) else [model]:
        found += [name.strip() for name in one.split(",")] if isinstance(one, str) else [one]
    return found


def _is_all(one: Any) -> bool:
    return isinstance(one, str) and one.split("+")[0] == ALL


def _every(name: str) -> list[FrictionModel]:
    """Return each model that can be identified, with the slots behind ``"all"``."""
    slots = name.removeprefix(ALL)
    every = [find(f"{base}{slots}", path="model") for base in MODELS]
    return [one for one in every if not _not_identified(one)]


def _component_of(one: Any) -> SlottedModel:
    if isinstance(one, str):
        return find(one, path="model")
    if isinstance(one, Model):
        raise InputError("has values already, which are to be identified", path="model", value=one,
                         mend=f"Write model={one.name!r}, or model.component for one of your own")  # fmt: skip
    if not isinstance(one, FrictionModel):
        raise InputError("must be a name, a friction model or a list of them", path="model", value=one)
    component = one if isinstance(one, SlottedModel) else slotted(one, asymmetry=False)
    base = base_of(component)
    if MODELS.get(base.name, base) is not base:
        raise InputError("is the name of a model of bristle, and this is another one", path="model", value=base.name,
                         mend='Give yours a name of its own: FrictionModel(name="...")')  # fmt: skip
    return component


def _not_identified(component: FrictionModel) -> list[tuple[list[str], str]]:
    """Return the parameters that no fit here finds, and what they are."""
    slips = base_of(component) in ELEMENT_MODELS
    arrays = [name for name in component.variables if component.is_array(name) and not slips]
    choices = [
        name for name, variable in component.variables.items() if variable.choices and name not in component.defaults
    ]
    return [one for one in ((arrays, "lists of numbers"), (choices, "choices of names")) if one[0]]


def _refuse_arrays(component: FrictionModel) -> None:
    for names, what in _not_identified(component):
        raise InputError(
            f"{component.name} has {what} ({', '.join(names)}), which inverse dynamics does not identify",
            path="model", value=component.name,
            mend="Fit dahl, lugre, maxwell_slip or gms, or write the parameters into a model file yourself",
        )  # fmt: skip


def freed(free: Sequence[str], components: Sequence[FrictionModel]) -> tuple[str, ...]:
    """Return the shapes that are to be identified.

    Raises
    ------
    InputError
        If none of the models has a shape of that name.
    """
    shapes = {
        name
        for one in components
        for name, variable in one.variables.items()
        if name in one.defaults and not variable.excitation and not variable.choices and variable != MIDDLE
    }
    for name in free:
        if name not in shapes:
            raise InputError("is no shape that is kept at a default", path="free", value=name,
                             allowed=", ".join(sorted(shapes)) or "none for these models")  # fmt: skip
    return tuple(free)


def with_method(
    given: Sequence[tuple[Log, Axis | None]], method: str | None, global_search: bool | None
) -> list[tuple[Log, Axis | None]]:
    """Return logs with their axes, which say what is made small, and where it is looked for, as a person asks."""
    changes = {"method": method, "global_search": global_search}
    changes = {name: value for name, value in changes.items() if value is not None}
    return [(log, replace(axis or Axis(kind=log.kind), **changes) if changes else axis) for log, axis in given]


def settings_of(axis: Axis | None, given: Settings | Mapping[str, float] | None) -> Settings:
    """Return the thresholds: those of the axis, and those given beside it.

    Raises
    ------
    InputError
        If there is no such threshold, or its value is out of range.
    """
    said = dict(axis.settings) if axis is not None else {}
    Settings.of(said, "identification.settings")
    return Settings.of(said | (given.as_data() if isinstance(given, Settings) else dict(given or {})))


def prior_knowledge_of(
    axis: Axis | None, mass: float | str | None, offset: float | str | None, kind: Kind
) -> PriorKnowledge:
    """Return what is known beforehand: the arguments, else the axis file.

    Numbers are in SI of the kind of axis; text has a unit.

    Raises
    ------
    InputError
        If a mass is not positive or an offset is not a number.
    """
    given_mass = mass if mass is not None else (axis.mass if axis is not None else None)
    chosen_mass = number_or_text(given_mass, MASS, kind, "mass")
    if chosen_mass is not None and not (math.isfinite(chosen_mass) and chosen_mass >= 1e-15):
        raise InputError("out of range", path="mass", value=chosen_mass, allowed="> 0",
                         mend="Leave it out to have it identified")  # fmt: skip
    plant = PLANTS[axis.plant] if axis is not None else inertia
    known = {"mass": chosen_mass}
    if axis is not None:
        known |= {"force*time/length": axis.damping, "force/length": axis.stiffness}
    values = {
        name: value for name, one in plant.variables.items() if (value := known.get(one.quantity)) is not None
    }  # fmt: skip
    pitch = axis.pitch if axis is not None else None
    chosen = offset if offset is not None else (axis.offset if axis is not None else "identify")
    if isinstance(chosen, str) and chosen == "identify":
        return PriorKnowledge(None, values, plant, pitch)
    value = quantity(chosen, OFFSET, kind, path="offset")
    if not math.isfinite(value):
        raise InputError("must be a number", path="offset", value=chosen, allowed='a force, or "identify"')
    return PriorKnowledge(value, values, plant, pitch)
