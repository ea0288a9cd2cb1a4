"""What a person asks to be identified, checked against what the log and the model allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel, Model
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.units import quantity
from bristle.core.variable import Kind, Variable, unit_of
from bristle.friction import MODELS, find
from bristle.friction.slots import OFFSET, SlottedModel, slotted
from bristle.identification.given import number_or_text
from bristle.identification.regression import Regression
from bristle.identification.unknowns import Held, Unknowns

__all__ = ["Known", "known_of", "models_of", "unknowns_of"]

MASS = Variable("mass", "moving mass or inertia")
PUT_IN = 0.1  # share of the work besides inertia from which friction that puts energy in is a wrong sign
ONE_WAY = 0.01  # share of the samples below which a direction counts as not seen


class Known(NamedTuple):
    """What is known of the axis beforehand; None where it is to be identified."""

    mass: float | None
    offset: float | None


def models_of(model: Any) -> tuple[FrictionModel, ...]:
    """Return the friction models that are asked for.

    Parameters
    ----------
    model : str, FrictionModel or a list of either
        Names with slots, ``"coulomb_viscous+asymmetry"``, several separated by commas.

    Raises
    ------
    InputError
        If there is no such model or slot, one is given twice or under a name that is taken, or it has parameters that
        this method does not identify.
    """
    asked = list(model) if isinstance(model, (list, tuple)) else [model]
    found: dict[str, FrictionModel] = {}
    for one in asked:
        for component in _components_of(one):
            if component.name in found:
                raise InputError("is asked for twice", path="model", value=component.name,
                                 mend="Write it once; give a model of your own a name of its own")  # fmt: skip
            _refuse_arrays(component)
            found[component.name] = component
    if not found:
        raise InputError("names no friction model", path="model", value=model, mend='Write "coulomb_viscous"')
    return tuple(found.values())


def _components_of(one: Any) -> list[SlottedModel]:
    if isinstance(one, str):
        return [find(name.strip(), path="model") for name in one.split(",")]
    if isinstance(one, Model):
        raise InputError("has values already, which are to be identified", path="model", value=one,
                         mend=f"Write model={one.name!r}, or model.component for one of your own")  # fmt: skip
    if not isinstance(one, FrictionModel):
        raise InputError("must be a name, a friction model or a list of them", path="model", value=one)
    component = one if isinstance(one, SlottedModel) else slotted(one, asymmetry=False)
    if MODELS.get(component.inner.name, component.inner) is not component.inner:
        raise InputError("is the name of a model of bristle, and this is another one", path="model",
                         value=component.inner.name,
                         mend='Give yours a name of its own: FrictionModel(name="...")')  # fmt: skip
    return [component]


def _refuse_arrays(component: FrictionModel) -> None:
    arrays = [name for name in component.variables if component.is_array(name)]
    choices = [
        name for name, variable in component.variables.items() if variable.choices and name not in component.defaults
    ]
    for names, what in ((arrays, "lists of numbers"), (choices, "choices of names")):
        if names:
            raise InputError(
                f"{component.name} has {what} ({', '.join(names)}), which inverse dynamics does not identify",
                path="model", value=component.name,
                mend="Fit dahl or lugre, or write the parameters into a model file yourself",
            )  # fmt: skip


def known_of(axis: Axis | None, mass: float | str | None, offset: float | str | None, kind: Kind) -> Known:
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
    chosen = offset if offset is not None else (axis.offset if axis is not None else "identify")
    if chosen == "identify":
        return Known(chosen_mass, None)
    value = quantity(chosen, OFFSET, kind, path="offset")
    if not math.isfinite(value):
        raise InputError("must be a number", path="offset", value=chosen, allowed='a force, or "identify"')
    return Known(chosen_mass, value)


def unknowns_of(component: FrictionModel, known: Known, regression: Regression) -> Unknowns:
    """Return which parameters of a model are free and which are held, with the reason.

    Raises
    ------
    InputError
        If parameters by direction are asked of a log that moves in one direction only.
    """
    held: dict[str, Held] = {}
    if known.mass is not None:
        held["M"] = Held(known.mass, "given as known")
    for name, variable in component.variables.items():
        if name == "offset":
            continue
        if name in component.defaults and not variable.excitation:
            default = component.defaults[name]
            code = variable.code(default, name) if variable.choices else default
            held[name] = Held(code, "a shape that is kept at its default")
    reason = _why_no_offset(component, regression)
    if known.offset is not None:
        held["offset"] = Held(known.offset, "given as known")
    elif reason:
        held["offset"] = Held(0.0, reason)
    free = tuple(name for name in ("M", *component.variables) if name not in held)
    return Unknowns(component, free, held)


def _why_no_offset(component: FrictionModel, regression: Regression) -> str:
    """Return why the offset cannot be told from the rest, or nothing where it can."""
    side = _only_direction(regression)
    split = [name for name in component.variables if name.endswith(("_pos", "_neg"))]
    if side and split:
        raise InputError(
            f"the log moves {side} only, which does not show the friction of the other direction",
            path="model", value=component.name, mend="Record both directions, or drop +asymmetry",
        )  # fmt: skip
    force = unit_of("force", regression.kind)
    levels = [name for name in split if component.variables[name].unit(regression.kind) == force]
    if levels:
        return f"it cannot be told from the difference between {levels[0]} and {levels[1]}"
    constant = [
        name for name, one in component.variables.items() if name != "offset" and one.unit(regression.kind) == force
    ]
    if side and constant:
        return f"it cannot be told from {constant[0]}: the log moves {side} only"
    return ""


def _only_direction(regression: Regression) -> str:
    velocity = regression.all_velocities
    forward = float(np.mean(~np.signbit(velocity)))
    return "backward" if forward < ONE_WAY else "forward" if forward > 1.0 - ONE_WAY else ""


def refuse_reversed_effort(regression: Regression, sliding: Mapping[str, float]) -> None:
    """Refuse a log whose effort drives the friction backward: friction would put energy in.

    Parameters
    ----------
    regression : Regression
        The rows.
    sliding : mapping
        ``M``, ``F_v``, ``F_C`` and ``offset`` of an unbounded Coulomb and viscous fit in which nothing is held [SI].

    Raises
    ------
    InputError
        If so.
    """
    speed = np.abs(regression.velocity)
    power = float(np.mean(sliding["F_C"] * speed + sliding["F_v"] * speed * speed))
    rest = regression.effort - sliding["M"] * regression.acceleration - sliding["offset"]
    clearly = -PUT_IN * float(np.mean(np.abs(rest * regression.velocity)))
    if power < clearly or (power < 0.0 and sliding["M"] <= 0.0):
        dissipated = f"{power:.3g} W dissipated by friction, and an inertia of "
        raise InputError(
            "the sign of effort seems reversed", path="log.effort",
            value=dissipated + with_unit(sliding["M"], unit_of("mass", regression.kind)),
            mend="Turn the sign of the effort in the axis file: sign = -1 where it has none or 1, else 1",
        )  # fmt: skip
