"""The arguments of an identification: models, prior knowledge and thresholds, as numbers or text."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from operator import attrgetter
from typing import Any

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel, Model
from bristle.core.edge import amount, whole
from bristle.core.errors import InputError
from bristle.core.units import quantity
from bristle.core.variable import Kind, Variable
from bristle.identification.fixed_shape import ELEMENT_MODELS
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.settings import Settings
from bristle.logs.log import Log
from bristle.models.friction import MODELS, base_of, find
from bristle.models.friction.level import TRANSMITTED
from bristle.models.friction.slots import OFFSET, SlottedModel, slotted
from bristle.models.friction.variation import MIDDLE
from bristle.models.plants import PLANTS, with_terms
from bristle.models.plants.terms import TURNS

ALL = "all"
METHODS = ("prediction_error", "inverse_dynamics", "output_error")
CUTOFF = Variable("frequency", "cut-off of the zero-phase filter", min=0.0)
MASS = Variable("mass", "moving mass or inertia")


def models_of(model: Any, *, transmits: bool = False) -> tuple[FrictionModel, ...]:
    """Return the requested friction models; with ``all``, models of the transmitted effort only if the axis `transmits` one."""
    requested = _separated(model)
    components: dict[str, FrictionModel] = {}
    for item in requested:
        if _is_all(item):
            continue
        component = _component_of(item)
        if component.name in components:
            raise InputError(
                "is requested twice",
                path="model",
                value=component.name,
                mend="Write each model once, and give your own model another name",
            )
        for names, kind in _not_identified(component):
            raise InputError(
                f"{component.name} has {kind} ({', '.join(names)}) that inverse dynamics does not identify",
                path="model",
                value=component.name,
                mend="Fit dahl, lugre, maxwell_slip or gms, or write the parameters into a model file yourself",
            )
        components[component.name] = component
    for name in filter(_is_all, requested):
        for base in MODELS:
            component = find(f"{base}{name.removeprefix(ALL)}", path="model")
            if not _not_identified(component) and (
                transmits or TRANSMITTED not in component.variables.values()
            ):
                components.setdefault(component.name, component)
    if not components:
        raise InputError(
            "names no friction model",
            path="model",
            value=model,
            mend='Write the name of a model, such as "coulomb_viscous"',
        )
    return tuple(components.values())


def asks_for_all(model: Any) -> bool:
    """Return whether all identifiable models are requested."""
    return any(map(_is_all, _separated(model)))


def _separated(model: Any) -> list[Any]:
    """Return the requested items, with lists of names split."""
    items: list[Any] = []
    for item in model if isinstance(model, (list, tuple)) else [model]:
        items += [name.strip() for name in item.split(",")] if isinstance(item, str) else [item]
    return items


def _is_all(item: Any) -> bool:
    return isinstance(item, str) and item.split("+")[0] == ALL


def _component_of(item: Any) -> SlottedModel:
    if isinstance(item, str):
        return find(item, path="model")
    if isinstance(item, Model):
        raise InputError(
            "has values already, but identify needs a model without values",
            path="model",
            value=item,
            mend=f"Write model={item.name!r}, or model.component",
        )
    if not isinstance(item, FrictionModel):
        raise InputError(
            "must be a name, a friction model or a list of them", path="model", value=item
        )
    component = item if isinstance(item, SlottedModel) else slotted(item, asymmetry=False)
    base = base_of(component)
    if MODELS.get(base.name, base) is not base:
        raise InputError(
            "is the name of a model of bristle",
            path="model",
            value=base.name,
            mend='Give your model another name: FrictionModel(name="...")',
        )
    return component


@cache
def _not_identified(component: FrictionModel) -> list[tuple[list[str], str]]:
    """Return the parameters that no fit supports, and their kind."""
    slips = base_of(component) in ELEMENT_MODELS
    arrays = [name for name in component.variables if component.is_array(name) and not slips]
    choices = [
        name
        for name, variable in component.variables.items()
        if variable.choices and name not in component.defaults
    ]
    kinds = ((arrays, "lists of numbers"), (choices, "choices of names"))
    return [(names, kind) for names, kind in kinds if names]


def freed(free: Sequence[str], components: Sequence[FrictionModel]) -> tuple[str, ...]:
    """Return the shapes to identify; reject a shape that no model has."""
    shapes = {
        name
        for component in components
        for name, variable in component.variables.items()
        if name in component.defaults
        and not variable.excitation
        and not variable.choices
        and variable != MIDDLE
    }
    for name in free:
        if name not in shapes:
            raise InputError(
                "is not a shape parameter with a default value",
                path="free",
                value=name,
                allowed=", ".join(sorted(shapes))
                or "no name, because the models have no such parameter",
            )
    return tuple(free)


def refuse_without_draws(method: str | None, draws: int) -> None:
    """Reject an observer without replicates, which are needed to test it."""
    if method == "prediction_error" and not draws:
        raise InputError(
            "are needed, because simulated logs test whether the observer explains the log",
            path="draws",
            value=0,
            allowed="20 or more",
            mend="Write --draws 100, or --method inverse_dynamics",
        )


def with_method(
    pairs: Sequence[tuple[Log, Axis | None]], method: str | None
) -> list[tuple[Log, Axis | None]]:
    """Return logs with their axes, with the requested method."""
    return [
        (log, axis if method is None else replace(axis or Axis(kind=log.kind), method=method))
        for log, axis in pairs
    ]


def settings_of(axis: Axis | None, beside: Settings | Mapping[str, float] | None) -> Settings:
    """Return the thresholds: those of the axis, overridden by `beside`."""
    of_axis = dict(axis.settings) if axis is not None else {}
    Settings.of(of_axis, "identification.settings")
    return Settings.of(
        of_axis | (beside.as_data() if isinstance(beside, Settings) else dict(beside or {}))
    )


def prior_knowledge_of(
    axis: Axis | None, mass: float | str | None, offset: float | str | None, kind: Kind
) -> PriorKnowledge:
    """Return the prior knowledge from the arguments, in SI units or text with a unit, else from the axis file."""
    axis = axis or Axis(kind=kind, offset="identify")
    mass = axis.mass if mass is None else mass
    value = None if mass is None else quantity(mass, MASS, kind, path="mass")
    if value is not None and not (math.isfinite(value) and value >= 1e-15):
        raise InputError(
            "out of range",
            path="mass",
            value=value,
            allowed="> 0",
            mend="Omit the mass to identify it",
        )
    plant = with_terms(
        PLANTS[axis.plant],
        gravity=axis.gravity,
        cogging={
            cogging.turner: cogging.harmonics for cogging in axis.cogging if cogging.harmonics
        },
        columns=tuple(map(attrgetter("name"), axis.regressors)),
        spring=axis.spring,
    )
    by_quantity = {"mass": value, "force*time/length": axis.damping, "force/length": axis.stiffness}
    values = {
        name: number
        for name, variable in PLANTS[axis.plant].variables.items()
        if (number := by_quantity.get(variable.quantity)) is not None
    }
    values |= {
        name: cogging.turn
        for cogging in axis.cogging
        if (name := TURNS[cogging.turner]) in plant.variables
    }
    values |= {
        f"known_{known.name}": known.coefficient
        for known in axis.regressors
        if known.coefficient is not None
    }
    constant = offset if offset is not None else axis.offset
    if isinstance(constant, str) and constant == "identify":
        return PriorKnowledge(None, values, plant, axis.pitch)
    force = quantity(constant, OFFSET, kind, path="offset")
    if not math.isfinite(force):
        raise InputError(
            "must be a number", path="offset", value=constant, allowed='a force, or "identify"'
        )
    return PriorKnowledge(force, values, plant, axis.pitch)


def refuse_options(
    function: Callable[..., Any], options: Mapping[str, Any], model: FrictionModel, kind: Kind
) -> None:
    """Refuse options of `identify`, or of a function in its place, that are wrong for every log."""
    options = vars(function).get("checked", dict)(**options)
    prior_knowledge_of(None, options.get("mass"), options.get("offset"), kind)
    treatment_of(options.get("cutoff"), options.get("decimation"), kind)
    settings_of(None, options.get("settings"))
    freed(options.get("free", ()), (model,))


def treatment_of(cutoff: Any, decimation: Any, kind: Kind) -> tuple[float | None, int | None]:
    """Return the requested cut-off [Hz] and decimation, or None."""
    rows = None if decimation is None else whole(1, 10_000)(decimation, "decimation", kind)
    return None if cutoff is None else amount(CUTOFF, exclusive=True)(cutoff, "cutoff", kind), rows
