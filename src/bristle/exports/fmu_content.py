"""What an FMU is made of: its variables, one step as a function of the tree, what is said of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dimensions import Kind
from bristle.core.errors import InputError
from bristle.core.variable import Variable, unit_of, variables_of
from bristle.exports.build import Builder
from bristle.exports.cycle import LARGEST, Core, core_of
from bristle.exports.described import Source, parameter_table
from bristle.exports.fmu_exchange import Exchange, exchange_of, why_not
from bristle.exports.prune import pruned
from bristle.exports.subject import Subject
from bristle.exports.tree import Function, Struct, Unit
from bristle.exports.tunable import Tunable, tunable_of

TIME, INPUT, OUTPUT, START, PARAMETER, CONSTANT, STATE, RATE, MARGIN = range(9)


@dataclass(frozen=True)
class Setting:
    """How an FMU is written."""

    name: str
    source: Source
    step: float
    fmi: int


@dataclass(frozen=True)
class Port:
    """A variable of an FMU; its place among them is its value reference."""

    name: str
    role: int
    variable: Variable
    value: float
    sure: str = ""

    @property
    def range(self) -> tuple[float, float]:
        """The smallest and the largest value that it takes: finite but for a parameter without an end."""
        low, high = self.variable.min, self.variable.max
        if self.role in (PARAMETER, CONSTANT, MARGIN):
            return low, high
        return max(low, -LARGEST), min(high, LARGEST)


@dataclass(frozen=True)
class Ports:
    """All variables, and for each model its parameters in the order in which they are among them."""

    listed: tuple[Port, ...]
    tuned: dict[str, tuple[Tunable, int]]
    fixed: tuple[str, ...] = ()
    states: tuple[int, ...] = ()

    def in_role(self, *roles: int) -> tuple[int, ...]:
        """Return the places of the variables in these roles, in their order."""
        return tuple(i for i, port in enumerate(self.listed) if port.role in roles)

    def place(self, name: str) -> int:
        """Return the value reference of a variable."""
        return next(i for i, port in enumerate(self.listed) if port.name == name)


def ports_of(core: Core, source: Source, exchange: Exchange | None = None) -> Ports:
    """Return the variables of an FMU; those that an importer integrates come last."""
    listed = [Port("time", TIME, Variable("time", "time"), 0.0), *_signals(core)]
    tuned: dict[str, tuple[Tunable, int]] = {}
    fixed: list[str] = []
    for argument, (model, _) in core.parameters.items():
        names = {port.name for port in listed}
        try:
            tuned[argument] = tunable_of(model), len(listed)
            role, values = PARAMETER, tuned[argument][0].values
        except InputError:
            role = CONSTANT
            values = {name: v for name, v in model.values.items() if not isinstance(v, str)}
            fixed.append(f"the parameters of {model.name} are constant: it makes something else of them at the start")
        listed += [
            replace(port, name=f"{model.name}_{port.name}") if port.name in names else port
            for port in parameter_ports(model.component.variables, values, role, source)
        ]
    places = () if exchange is None else _add_varying(exchange, listed, core.subject.model.name)
    return Ports(tuple(listed), tuned, tuple(fixed), places)


def _add_varying(exchange: Exchange, listed: list[Port], model: str) -> tuple[int, ...]:
    """Add the variables that an importer integrates and that are not yet there, and return the places of the states.

    Position and velocity of a plant are outputs, which get the size that matters to the contact.
    """
    taken = {port.name: i for i, port in enumerate(listed)}
    places: list[int] = []
    for state, variable in exchange.varying.items():
        at = taken.get(state)
        if at is not None and listed[at].role == START:
            listed[at] = replace(listed[at], variable=replace(listed[at].variable, nominal=variable.nominal))
            places.append(at)
        else:
            places.append(len(listed))
            listed.append(Port(state if at is None else f"{model}_{state}", STATE, variable, 0.0))
    for at, variable in zip(places, exchange.varying.values(), strict=True):
        name = listed[at].name
        listed.append(Port(f"der({name})", RATE, Variable(f"{variable.quantity}/time", f"rate of {name}"), 0.0))
    if exchange.held:
        margin = Variable("1", "what is left to the next event of the contact, where it falls below zero")
        reversal = Variable("length/time", "what is left to a reversal, where it falls below zero")
        listed += [Port("margin", MARGIN, margin, 0.0), Port("reversal", MARGIN, reversal, 0.0)]
    return tuple(places)


def _signals(core: Core) -> list[Port]:
    force = Port("force", OUTPUT, Variable("force", "friction force; in co-simulation, the mean of the last internal step"), 0.0)
    if core.plant is not None:
        body = variables_of(type(core.plant.component.initial_state(core.plant.parameters)))
        effort = Port("effort", INPUT, Variable("force", "effort that drives the mass, held over a step of co-simulation"), 0.0)
        return [effort, *(Port(name, START, body[name], float(core.begin[i])) for i, name in enumerate("xv")), force]
    around, defaults = variables_of(core.subject.motion.cls), core.subject.usual
    velocity = Variable("length/time", "velocity, held over a step of co-simulation; the sign of zero is a side")
    position = Variable("length", "position, at the end of a step of co-simulation; only friction that depends on it looks at it")
    inputs = [Port("v", INPUT, velocity, 0.0), Port("x", INPUT, position, 0.0)]
    return [*inputs, *(Port(name, INPUT, around[name], defaults[name]) for name in core.subject.signals), force]


def parameter_ports(variables: Mapping[str, Variable], values: Mapping[str, Any], role: int, source: Source) -> list[Port]:
    """Return a variable for each number of some parameters."""
    ports = []
    for name, value in values.items():
        variable, facts = variables[name], source.uncertainty.get(name, {})
        interval = facts.get("interval")
        sure = f"95 % interval {interval[0]:.6g} to {interval[1]:.6g}" if interval else str(facts.get("status", ""))
        if isinstance(value, np.ndarray):
            ports += [Port(f"{name}[{i + 1}]", role, variable, v, sure) for i, v in enumerate(value.tolist())]
        elif not math.isnan(float(value)):
            ports.append(Port(name, role, variable, float(value), sure))
    return ports


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
    most: Sequence[int]
    layout: str
    tables: list[str]
    guidance: tuple[str, ...]
    notes: tuple[str, ...]
    failures_at: int = -1


def content_of(subject: Subject, plant: Model | None, source: Source) -> Content:
    """Return what an FMU of a friction model is made of, on a plant where one is given."""
    builder, model, reason = Builder(), subject.model, why_not(subject.model, plant)
    core = core_of(subject, plant, builder)
    exchange = None if reason else exchange_of(core, builder)
    ports, force = ports_of(core, source, exchange), unit_of("force", model.kind)
    title = f"Friction {model.name}: force [{force}] of a velocity and a position"
    guidance = (
        "Friction is stiff in pre-sliding: with a mass outside, exchange force and velocity in very short steps, or the "
        "loop may be unstable. Prefer the FMU with its mass, where there is one."
    )
    if plant is not None:
        title = f"{plant.name} with friction {model.name}: motion under an effort [{force}]"
        guidance = "Set x and v before the start, and give the effort: gravity and cogging of the plant are inside."
    return Content(
        title,
        model.kind,
        pruned(builder.unit, [core.entry, *(exchange.functions if exchange else ())]),
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
        (guidance,),
        (*((f"co-simulation alone: {reason}",) if reason else ()), *ports.fixed),
        -1 if plant is None else core.begin.size - 1,
    )
