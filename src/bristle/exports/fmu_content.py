"""What an FMU is made of, whatever it is of: one step as a function of the tree, its variables, what is said of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dimensions import Kind
from bristle.core.variable import unit_of
from bristle.exports.build import Builder
from bristle.exports.described import Source, parameter_table
from bristle.exports.fmu_core import Core, core_of
from bristle.exports.fmu_exchange import Exchange, exchange_of, why_not
from bristle.exports.fmu_variables import Ports, ports_of
from bristle.exports.prune import pruned
from bristle.exports.subject import Subject
from bristle.exports.tree import Function, Unit
from bristle.exports.types import Struct

__all__ = ["Content", "content_of"]

ALONE = (
    "Friction is stiff in pre-sliding: with a mass outside, exchange force and velocity in very short steps, or the "
    "loop may be unstable. Prefer the FMU with its mass, where there is one."
)
DRIVEN = "Set x and v before the start, and give the effort: gravity and cogging of the plant are inside."


@dataclass(frozen=True)
class Content:
    """What an FMU is made of."""

    title: str
    kind: Kind
    unit: Unit
    entry: Function
    exchange: Exchange | None
    ports: Ports
    output: str
    values: dict[str, tuple[Any, Struct]]
    begin: np.ndarray
    memory: np.ndarray
    most: tuple[int, ...]
    layout: str
    tables: list[str]
    guidance: tuple[str, ...]
    notes: tuple[str, ...]
    failures_at: int = -1


def content_of(subject: Subject, plant: Model | None, source: Source) -> Content:
    """Return what an FMU of a friction model is made of, on a plant where one is given."""
    core, exchange = _cores(subject, plant)
    ports, model = ports_of(core, source, exchange), subject.model
    reason = why_not(model, plant)
    return Content(
        _title(core),
        "rotational" if model.kind == "rotational" else "translational",
        core.unit,
        core.entry,
        exchange,
        ports,
        "force",
        {name: (owner.parameters, kind) for name, (owner, kind) in core.parameters.items()},
        core.begin,
        np.zeros(subject.memory_size),
        core.most,
        f"{subject.state.fields} {subject.memory_size}",
        parameter_table(model, source).splitlines(),
        (ALONE if plant is None else DRIVEN,),
        (*((f"co-simulation alone: {reason}",) if reason else ()), *ports.fixed),
        core.failures_at,
    )


def _cores(subject: Subject, plant: Model | None) -> tuple[Core, Exchange | None]:
    """Return what an FMU steps, and, where it has equations in continuous time, what an importer integrates."""
    if why_not(subject.model, plant):
        return core_of(subject, plant), None
    builder = Builder()
    core = core_of(subject, plant, builder)
    exchange = exchange_of(core, builder)
    unit = pruned(builder.unit, [core.entry, exchange.flowing, exchange.begun, exchange.arrived])
    return replace(core, unit=unit), exchange


def _title(core: Core) -> str:
    model = core.subject.model
    unit = unit_of("force", model.kind)
    if core.plant is None:
        return f"Friction {model.name}: force [{unit}] of a velocity and a position"
    return f"{core.plant.name} with friction {model.name}: motion under an effort [{unit}]"
