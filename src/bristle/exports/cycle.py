"""The step of friction, alone or on a plant, as a kernel with generated text and its state in an array."""

from typing import Any, NamedTuple

import numpy as np

from bristle.core import dispatch
from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Model, Motion
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.screwed import Memories
from bristle.engine.translation.build import Builder
from bristle.engine.translation.scope import defined
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    Array,
    Function,
    Struct,
    Type,
    struct_type,
)
from bristle.exports.subject import Subject, most_of

POSITION, FORCE, BEGUN, REFUSED, OVERFLOW, STATE = range(6)
LARGEST = 1.7976931348623157e308
TEXT = """
def advanced(lasting, memory, x, dt, p):
    if lasting[BEGUN] == 0.0 and x - x == 0.0:
        lasting[POSITION] = x
        lasting[BEGUN] = 1.0
        return lasting[FORCE]
    v = (x - lasting[POSITION]) / dt
    if not (v - v == 0.0 and dt > 0.0 and dt <= LARGEST):
        lasting[REFUSED] = 1.0
        return lasting[FORCE]
    state = State({load})
    force, move = friction_trial(state, memory, Motion(v, x, NOMINAL_LOAD, NOMINAL_TEMPERATURE), dt, p)
    if force - force != 0.0:
        lasting[OVERFLOW] = 1.0
        return lasting[FORCE]
    after = friction_commit(state, memory, move, p)
{store}
    lasting[POSITION] = x
    lasting[FORCE] = force
    return force
"""

AT_REST = """
def at_rest(lasting, memory, x, p):
    state = State({load})
    around = Motion(x, lasting[POSITION], NOMINAL_LOAD, NOMINAL_TEMPERATURE)
    force, move = friction_trial(state, memory, around, 0.0, p)
    return force
"""


def cycle_of(subject: Subject, builder: Builder) -> tuple[Function, np.ndarray]:
    """Return the cycle of a model as a function of the tree, and its state before the first cycle."""
    state = subject.state
    begin = np.array([0.0] * STATE + [float(value) for value in subject.virgin])
    store = "    lasting[REFUSED] = lasting[REFUSED]"
    if state.fields:
        store = stored(state, "after", STATE)
    kernel = defined(
        "advanced",
        TEXT.format(load=loaded(state, STATE), store=store),
        _scope(subject) | {"Motion": Motion},
    )
    memory = Array(subject.memory_size, writable=True)
    return builder.function(
        kernel, [Array(begin.size, writable=True), memory, REAL, REAL, subject.parameters]
    ), begin


def at_rest_of(subject: Subject, builder: Builder) -> Function:
    """Return the force of the contact at its present position, for the sign of a velocity; the contact does not move."""
    kernel = defined(
        "at_rest",
        AT_REST.format(load=loaded(subject.state, STATE)),
        _scope(subject) | {"Motion": Motion},
    )
    lasting = Array(STATE + len(subject.state.fields))
    memory = Array(subject.memory_size)
    return builder.function(kernel, [lasting, memory, REAL, subject.parameters])


def _scope(subject: Subject) -> dict[str, Any]:
    nominal = {"NOMINAL_LOAD": NOMINAL_LOAD, "NOMINAL_TEMPERATURE": NOMINAL_TEMPERATURE}
    solve = {"Mechanism": Mechanism, "mechanism": mechanism, "Memories": Memories}
    return (
        vars(dispatch)
        | globals()
        | nominal
        | solve
        | {"State": subject.state.cls, "Motion": subject.motion.cls}
    )


ALONG = """
def stepped(lasting, memory, v, x, {signals}dt, p):
    state = State({load})
    force, move = friction_trial(state, memory, Motion(v, x, {around}), dt, p)
    after = friction_commit(state, memory, move, p)
{store}
    return force
"""
DRIVEN = """
def stepped(lasting, {memories}, effort, dt, q, p):
    {memory}body, contact = PlantState({load_plant}), State({load})
    before = Mechanism(body, contact, lasting[{at}], lasting[{at} + 1], lasting[{at} + 2], 0.0, 0.0)
    after = mechanism(before, memory, effort, effort, 0.0, 0.0, dt, 1, q, p)
{store}
    lasting[{at}] = after.effort
    lasting[{at} + 1] = after.slope
    lasting[{at} + 2] = after.acceleration
    lasting[{at} + 3] = lasting[{at} + 3] + after.failures
    return after.force
"""
SOLVER = 4  # numbers that the solve keeps: effort, slope, acceleration, count of failed solves


class Core(NamedTuple):
    """One step of an FMU as a function of the tree, with its state and the range of each integer of the state."""

    subject: Subject
    plant: Model | None
    entry: Function
    begin: np.ndarray
    most: list[int]
    parameters: dict[str, tuple[Model, Struct]]


def core_of(subject: Subject, plant: Model | None, builder: Builder) -> Core:
    """Return the step of a friction model, on the plant if there is one."""
    # For the names and hashes of its functions.
    scope = _scope(subject) | {"__name__": "bristle.exports.fmu_core"}
    begin = _numbers(subject.virgin)
    scope |= {
        inside_name(name): kind.cls
        for name, kind in subject.state.fields
        if isinstance(kind, Struct)
    }
    parameters = {"p": (subject.model, subject.parameters)}
    sizes = {
        name: subject.memories.get(f"{name.partition('.')[0]}_memory", subject.memory_size)
        for name, _ in leaves_of(subject.state)
    }
    most = [most_of(name, kind, sizes[name]) for name, kind in leaves_of(subject.state)]
    inputs = 2 + len(subject.signals)
    if plant is None:
        around = {name: repr(usual) for name, usual in subject.usual.items()}
        around |= {name: name for name in subject.signals}
        text = ALONG.format(
            signals="".join(f"{name}, " for name in subject.signals),
            around=", ".join(around.values()),
            load=loaded(subject.state, 0),
            store=stored(subject.state, "after", 0),
        )
    else:
        body = plant.component.initial_state(plant.parameters)
        plant_state = struct_type(body)
        first = len(body)
        scope["PlantState"] = plant_state.cls
        memories = ", ".join(subject.memories)
        memory = ""
        if len(subject.memories) > 1:
            memory = f"memory = Memories({memories})\n    "
        text = DRIVEN.format(
            memories=memories,
            memory=memory,
            load_plant=loaded(plant_state, 0),
            load=loaded(subject.state, first),
            at=first + len(begin),
            store=stored(plant_state, "after.plant", 0)
            + "\n"
            + stored(subject.state, "after.friction", first),
        )
        inputs = 1
        begin = [float(value) for value in body] + begin + [0.0] * SOLVER
        most = [0] * first + most + [0] * SOLVER
        parameters = {"q": (plant, struct_type(plant.parameters))} | parameters
    arrays = [len(begin), *subject.memories.values()]
    types = [*(Array(size, writable=True) for size in arrays), *[REAL] * (inputs + 1)]
    entry = builder.function(
        defined("stepped", text, scope), [*types, *(kind for _, kind in parameters.values())]
    )
    return Core(subject, plant, entry, np.array(begin), most, parameters)


def _numbers(state: Any) -> list[float]:
    """Return the numbers of a state, also in the states inside it."""
    numbers = []
    for value in state:
        if isinstance(value, tuple):
            numbers += _numbers(value)
        else:
            numbers.append(float(value))
    return numbers


def leaves_of(kind: Struct, path: str = "") -> list[tuple[str, Type]]:
    """Return the place of each number of a tuple, such as ``table.z``, and its type."""
    leaves: list[tuple[str, Type]] = []
    for name, part in kind.fields:
        if isinstance(part, Struct):
            leaves += leaves_of(part, f"{path}{name}.")
        else:
            leaves.append((path + name, part))
    return leaves


def inside_name(name: str) -> str:
    """Return the name of the class of a tuple inside a state."""
    return f"Inside_{name}"


def loaded(kind: Struct, at: int, array: str = "lasting") -> str:
    """Return the text that loads the fields of a tuple from an array."""
    texts = []
    for name, part in kind.fields:
        number = f"{array}[{at}]"
        if isinstance(part, Struct):
            number = f"{inside_name(name)}({loaded(part, at, array)})"
            at += len(leaves_of(part))
        else:
            at += 1
        if part == INTEGER:
            number = f"int({number})"
        texts.append(number)
    return ", ".join(texts)


def stored(kind: Struct, source: str, at: int, array: str = "lasting") -> str:
    """Return the lines that store the fields of a tuple in an array."""
    lines = [
        f"    {array}[{at + i}] = {source}.{name}" for i, (name, _) in enumerate(leaves_of(kind))
    ]
    return "\n".join(lines) or "    pass"
