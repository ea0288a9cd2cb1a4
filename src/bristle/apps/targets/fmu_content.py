"""Contents of an FMU: its variables, one step as a function of the tree, its description."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import count
from typing import Any

import numpy as np

from bristle.apps.targets.fmu_exchange import Exchange, exchange_of, why_not
from bristle.core import InputError, Kind, Model, Variable, unit_of, variables_of
from bristle.engine.translation import tree
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    TRUTH,
    Array,
    Function,
    Struct,
    Type,
    Unit,
)
from bristle.exports.cycle import LARGEST, Core, core_of
from bristle.exports.described import Source, parameter_table
from bristle.exports.law import INPUTS, Law, law_facts, law_of, settled_law, tunable_law
from bristle.exports.settled import pruned
from bristle.exports.subject import Subject, most_of, places_of
from bristle.exports.tunable import Tunable, tunable_of

TIME, INPUT, OUTPUT, START, PARAMETER, CONSTANT, STATE, RATE, MARGIN = range(9)


@dataclass(frozen=True)
class Setting:
    """Settings of an FMU."""

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
        """Smallest and largest allowed value; finite except for a parameter without a bound."""
        low = self.variable.min
        high = self.variable.max
        if self.role in (PARAMETER, CONSTANT, MARGIN):
            return low, high
        return max(low, -LARGEST), min(high, LARGEST)


@dataclass(frozen=True)
class Ports:
    """All variables, and for each model its parameters in their order among the variables."""

    listed: tuple[Port, ...]
    tuned: dict[str, tuple[Tunable, int]]
    fixed: tuple[str, ...] = ()
    states: tuple[int, ...] = ()

    def in_role(self, *roles: int) -> tuple[int, ...]:
        """Return the indices of the variables with these roles, in ascending order."""
        return tuple(i for i, port in enumerate(self.listed) if port.role in roles)

    def place(self, name: str) -> int:
        """Return the value reference of a variable."""
        return next(i for i, port in enumerate(self.listed) if port.name == name)


def ports_of(core: Core, source: Source, exchange: Exchange | None = None) -> Ports:
    """Return the variables of an FMU; the states for an importer are last."""
    listed = [Port("time", TIME, Variable("time", "time"), 0.0), *_signals(core)]
    tuned: dict[str, tuple[Tunable, int]] = {}
    fixed: list[str] = []
    has_screw = core.plant is not None and core.plant.component.screw is not None
    for argument, (model, _) in core.parameters.items():
        names = {port.name for port in listed}
        try:
            if has_screw:
                raise InputError("are converted to the motor", path=model.name)
            tuned[argument] = tunable_of(model), len(listed)
            role = PARAMETER
            values = tuned[argument][0].values
        except InputError:
            role = CONSTANT
            values = {name: v for name, v in model.values.items() if not isinstance(v, str)}
            fixed.append(
                f"the parameters of {model.name} cannot change during a simulation, because the model converts them at the start"
            )
        for port in parameter_ports(model.component.variables, values, role, source):
            name = port.name
            if name in names:
                name = f"{model.name}_{name}"
            listed.append(replace(port, name=name))
    places = ()
    if exchange is not None:
        places = _add_varying(exchange, listed, core.subject.model.name)
    return Ports(tuple(listed), tuned, tuple(fixed), places)


def _add_varying(exchange: Exchange, listed: list[Port], model: str) -> tuple[int, ...]:
    """Add missing variables that an importer integrates, and return the indices of the states."""
    # Position and velocity of a plant are outputs; their nominal values are those of the contact.
    taken = {port.name: i for i, port in enumerate(listed)}
    places: list[int] = []
    for state, variable in exchange.varying.items():
        at = taken.get(state)
        if at is not None and listed[at].role == START:
            listed[at] = replace(
                listed[at], variable=replace(listed[at].variable, nominal=variable.nominal)
            )
            places.append(at)
        else:
            places.append(len(listed))
            name = state
            if at is not None:
                name = f"{model}_{state}"
            listed.append(Port(name, STATE, variable, 0.0))
    for at, variable in zip(places, exchange.varying.values(), strict=True):
        name = listed[at].name
        listed.append(
            Port(
                f"der({name})", RATE, Variable(f"{variable.quantity}/time", f"rate of {name}"), 0.0
            )
        )
    if exchange.held:
        margin = Variable(
            "1",
            "margin to the next event of the contact; the event occurs when the margin falls below zero",
        )
        reversal = Variable(
            "length/time",
            "margin to a reversal; the reversal occurs when the margin falls below zero",
        )
        listed += [Port("margin", MARGIN, margin, 0.0), Port("reversal", MARGIN, reversal, 0.0)]
    return tuple(places)


def _signals(core: Core) -> list[Port]:
    force = Port(
        "force",
        OUTPUT,
        Variable("force", "friction force; in co-simulation, the mean of the last internal step"),
        0.0,
    )
    if core.plant is not None:
        body = variables_of(type(core.plant.component.initial_state(core.plant.parameters)))
        effort = Port(
            "effort",
            INPUT,
            Variable("force", "effort that drives the mass, constant over a step of co-simulation"),
            0.0,
        )
        starts = [
            Port(name, START, body[name], float(core.begin[i])) for i, name in enumerate("xv")
        ]
        # The state of the table follows that of the motor.
        if core.plant.component.screw is not None:
            starts += [
                replace(port, name=f"{port.name}_table", variable=_of_table(port.variable))
                for port in starts
            ]
        return [effort, *starts, force]
    around = variables_of(core.subject.motion.cls)
    defaults = core.subject.usual
    velocity = Variable(
        "length/time",
        "velocity, constant over a step of co-simulation; the sign of a zero states the direction",
    )
    position = Variable(
        "length",
        "position at the end of a step of co-simulation; used only by friction that depends on position",
    )
    inputs = [Port("v", INPUT, velocity, 0.0), Port("x", INPUT, position, 0.0)]
    return [
        *inputs,
        *(Port(name, INPUT, around[name], defaults[name]) for name in core.subject.signals),
        force,
    ]


def _of_table(variable: Variable) -> Variable:
    return replace(
        variable, description=f"{variable.description} of the table, converted to the motor"
    )


def parameter_ports(
    variables: Mapping[str, Variable], values: Mapping[str, Any], role: int, source: Source
) -> list[Port]:
    """Return a variable for each number of some parameters."""
    ports = []
    for name, value in values.items():
        variable = variables[name]
        facts = source.uncertainty.get(name, {})
        interval = facts.get("interval")
        if interval:
            sure = f"95 % interval {interval[0]:.6g} to {interval[1]:.6g}"
        else:
            sure = str(facts.get("status", ""))
        if isinstance(value, np.ndarray):
            ports += [
                Port(f"{name}[{i + 1}]", role, variable, v, sure)
                for i, v in enumerate(value.tolist())
            ]
        elif not math.isnan(float(value)):
            ports.append(Port(name, role, variable, float(value), sure))
    return ports


@dataclass(frozen=True)
class Content:
    """Contents of an FMU."""

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
    notes: tuple[str, ...]
    memory_at: Mapping[str, int]
    failures_at: int = -1


def content_of(subject: Subject, plant: Model | None, source: Source) -> Content:
    """Return the contents of an FMU of a friction model, on the plant if there is one."""
    builder = Builder()
    model = subject.model
    reason = why_not(subject.model, plant)
    core = core_of(subject, plant, builder)
    exchange = None
    notes = []
    entries = [core.entry]
    if reason:
        notes.append(f"co-simulation alone: {reason}")
    else:
        exchange = exchange_of(core, builder)
        entries += exchange[:4]
    ports = ports_of(core, source, exchange)
    force = unit_of("force", model.kind)
    title = f"Friction {model.name}: force [{force}] from velocity and position"
    guidance = (
        "friction is stiff in pre-sliding: with an external mass, exchange force and velocity in very short steps, or the "
        "loop may be unstable. If the export contains an FMU with the mass, prefer that FMU"
    )
    if plant is not None:
        title = f"{plant.name} with friction {model.name}: motion under an effort [{force}]"
        guidance = "set x and v before the start, and provide the effort; the FMU includes gravity and cogging of the plant"
        if plant.component.screw is not None:
            guidance = "set x and x_table alike before the start, and provide the effort; x and v are those of the motor"
    unit = pruned(builder.unit, entries)
    values = {name: (owner.parameters, kind) for name, (owner, kind) in core.parameters.items()}
    layout = f"{subject.state.fields} {subject.memory_size}"
    memory = np.zeros(subject.memory_size)
    table = parameter_table(model, source)
    lasting: dict[str, Any] = {
        "begin": core.begin,
        "memory": memory,
        "memory_at": places_of(subject.memories),
        "most": core.most,
        "layout": layout,
    }
    if plant is not None:
        lasting |= {"failures_at": core.begin.size - 1}
    texts = {"tables": table.splitlines(), "notes": (guidance, *notes, *ports.fixed)}
    return Content(
        title, model.kind, unit, core.entry, exchange, ports, "force", values, **lasting, **texts
    )


BEGUN = 0  # index of the flag for the first sample; the state of the law follows
ORDER = (
    "step the law before the plant, and apply its effort to the plant in the same step, like a simulated loop of bristle. "
    "An importer that steps both at once applies each effort one sample late: in this case add one to the delay of the "
    "experiment, and export again"
)
PAST = "the initial state of the compensator was computed with the exported parameters; new parameters do not change it"


def content_of_law(law: Law, name: str, source: Source) -> Content:
    """Return the contents of an FMU of a control law; its parameters are variable if possible."""
    notes = [ORDER]
    if not law.tunable:
        law = law_of(law.variant, tunable=True)
    try:
        tunable_law(law)
    except InputError as error:
        law = law_of(law.variant)
        notes.append(f"the parameters of the law cannot change during a simulation: {error}")
    law = settled_law(law)
    begin = np.array([0.0, *(float(reduce(getattr, path, law.lasting)) for path, _ in law.leaves)])
    entry = _stepped(law)
    facts = law_facts(law, name, source)
    if np.any(law.memory) and law.tunable:
        notes += [PAST]
    most = [2, *(_most_of(path[-1], kind, law.memory_size) for path, kind in law.leaves)]
    title = f"{facts['title']}, variant {facts['variant']}: effort [{facts['unit_force']}]"
    unit = pruned(tree.Unit([*law.unit.functions, entry]), [entry])
    layout = f"{law.types[0].fields} {law.memory_size} {law.dt!r}"
    lasting = {
        "begin": begin,
        "memory": law.memory,
        "memory_at": law.memory_at,
        "most": most,
        "layout": layout,
    }
    tables = "\n".join([facts["table"], *facts["frictions"].values()])
    texts = {"tables": tables.splitlines(), "notes": tuple(notes)}
    values = {"p": (law.p, law.types[1])}
    ports = _ports(law, source)
    return Content(
        title, law.controller.kind, unit, entry, None, ports, "effort", values, **lasting, **texts
    )


def _most_of(name: str, kind: Type, memory_size: int) -> int:
    """Return the number of values of a whole number of the state; 0 for a real number."""
    if kind == TRUTH:
        return 2
    return most_of(name, kind, memory_size)


def _stepped(law: Law) -> tree.Function:
    """Return the step of an FMU around that of a law."""
    lasting = Array(1 + len(law.leaves), writable=True)
    now = law.entry.result
    places = count(1)
    inside = {
        "lasting": lambda: _loaded(law.types[0], lasting, places),
        "begun": lambda: _loaded(TRUTH, lasting, iter([BEGUN])),
    }
    arguments = []
    for p in law.entry.parameters:
        if p.name in inside:
            arguments.append(inside[p.name]())
        else:
            arguments.append(tree.Variable(p.type, p.name))
    body: list[tree.Statement] = [
        tree.Assign(tree.Variable(now, "now"), tree.Call(now, law.entry, arguments)),
        tree.Store(
            tree.Variable(lasting, "lasting"),
            tree.Constant(INTEGER, BEGUN),
            tree.Constant(REAL, 1.0),
        ),
    ]
    for place, (path, kind) in enumerate(law.leaves, 1):
        field = _part(now, ("_1", *path))
        number = field
        if kind != REAL:
            number = tree.Convert(REAL, field)
        body.append(
            tree.Store(tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, place), number)
        )
    body.append(tree.Return(_part(now, ("_0",))))
    handed = [tree.Variable(p.type, p.name) for p in law.entry.parameters if p.name not in inside]
    return tree.Function(
        "law_stepped",
        _stepped,
        [tree.Variable(lasting, "lasting"), *handed],
        REAL,
        body,
        writes=True,
    )


def _part(now: Type, path: tuple[str, ...]) -> tree.Expression:
    """Return a part of the result of the law; no node of a tree may occur twice."""
    if not path:
        return tree.Variable(now, "now")
    outer = _part(now, path[:-1])
    inside = outer.type
    assert isinstance(inside, Struct)
    return tree.Field(inside.fields[inside.place(path[-1])][1], outer, path[-1])


def _loaded(kind: Type, lasting: Array, places: Iterator[int]) -> tree.Expression:
    """Return a value of this type from the next numbers of the state."""
    if isinstance(kind, Struct):
        return tree.Make(kind, [_loaded(part, lasting, places) for _, part in kind.fields])
    number = tree.Index(
        REAL, tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, next(places))
    )
    if kind == TRUTH:
        return tree.Compare(TRUTH, "!=", number, tree.Constant(REAL, 0.0))
    if kind == REAL:
        return number
    return tree.Convert(kind, number)


def _ports(law: Law, source: Source) -> Ports:
    """Return the variables: the inputs of the law, the effort, and the parameters."""
    listed = [Port("time", TIME, Variable("time", "time"), 0.0)]
    for name in law.inputs:
        meaning, quantity = INPUTS[name]
        variable = Variable(quantity, f"{meaning}, constant over a step of co-simulation")
        names = [name]
        if name.endswith("_ahead"):
            names = [f"{name}[{place + 1}]" for place in range(law.samples_ahead)]
        listed += [Port(input_name, INPUT, variable, 0.0) for input_name in names]
    listed.append(
        Port(
            "effort", OUTPUT, Variable("force", "command for the drive since the last sample"), 0.0
        )
    )
    if not law.tunable:
        return Ports(tuple(listed), {})
    tuned = tunable_law(law)
    places = {"p": (tuned, len(listed))}
    return Ports(
        (*listed, *parameter_ports(tuned.variables, tuned.values, PARAMETER, source)), places
    )
