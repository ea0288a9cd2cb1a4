"""What an FMU steps, as a kernel: friction along a velocity, or a plant with its friction under an effort.

The kernel is written as text, because the state that it loads and keeps has the fields of the model, and is built into
the tree as any kernel is. What lasts from step to step is an array: the state, and where the next solve begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.exports.build import Builder
from bristle.exports.prune import pruned
from bristle.exports.scope import defined
from bristle.exports.subject import Subject
from bristle.exports.tree import Function, Unit
from bristle.exports.types import INTEGER, REAL, Array, Struct, type_of

__all__ = ["Core", "core_of", "loaded", "most_of", "stored"]

ALONG = """
def stepped(lasting, memory, v, x, {signals}dt, p):
    state = State({load})
    force, move = friction_trial(state, memory, Motion(v, x, {around}), dt, p)
    after = friction_commit(state, memory, move, p)
{store}
    return force
"""
DRIVEN = """
def stepped(lasting, memory, effort, dt, q, p):
    body, contact = PlantState({load_plant}), State({load})
    before = Mechanism(body, contact, lasting[{at}], lasting[{at} + 1], lasting[{at} + 2], 0.0, 0.0)
    after = mechanism(before, memory, effort, effort, 0.0, 0.0, dt, 1, q, p)
{store}
    lasting[{at}] = after.effort
    lasting[{at} + 1] = after.slope
    lasting[{at} + 2] = after.acceleration
    lasting[{at} + 3] = lasting[{at} + 3] + after.failures
    return after.force
"""
SOLVER = 4  # numbers that the solve keeps: effort, slope, acceleration, solves that failed


@dataclass(frozen=True)
class Core:
    """One step of an FMU as a function of the tree, with what it lasts on."""

    subject: Subject
    plant: Model | None
    unit: Unit
    entry: Function
    begin: np.ndarray
    most: tuple[int, ...]
    parameters: dict[str, tuple[Model, Struct]]

    @property
    def failures_at(self) -> int:
        """Where the number of solves that failed is; -1 where nothing is solved."""
        return self.begin.size - 1 if self.plant is not None else -1


def core_of(subject: Subject, plant: Model | None, builder: Builder | None = None) -> Core:
    """Return the step of a friction model, on a plant where one is given."""
    scope: dict[str, Any] = {
        "__name__": __name__,
        "State": subject.state.cls,
        "Motion": subject.motion.cls,
        "friction_trial": friction_trial,
        "friction_commit": friction_commit,
        "Mechanism": Mechanism,
        "mechanism": mechanism,
    }
    virgin = [float(value) for value in subject.virgin]
    parameters = {"p": (subject.model, subject.parameters)}
    most = [most_of(subject, name) if kind == INTEGER else 0 for name, kind in subject.state.fields]
    if plant is None:
        around = ", ".join(name if name in subject.signals else repr(usual) for name, usual in subject.usual.items())
        text = ALONG.format(
            signals="".join(f"{name}, " for name in subject.signals),
            around=around,
            load=loaded(subject.state, 0),
            store=stored(subject.state, "after", 0),
        )
        inputs, begin = 2 + len(subject.signals), virgin
    else:
        body = plant.component.initial_state(plant.parameters)
        plant_state, plant_parameters = type_of(body), type_of(plant.parameters)
        assert isinstance(plant_state, Struct)
        assert isinstance(plant_parameters, Struct)
        scope["PlantState"] = plant_state.cls
        first = len(plant_state.fields)
        text = DRIVEN.format(
            load_plant=loaded(plant_state, 0),
            load=loaded(subject.state, first),
            at=first + len(virgin),
            store=stored(plant_state, "after.plant", 0) + "\n" + stored(subject.state, "after.friction", first),
        )
        inputs, begin = 1, [float(value) for value in body] + virgin + [0.0] * SOLVER
        most = [0] * first + most + [0] * SOLVER
        parameters = {"q": (plant, plant_parameters)} | parameters
    entry_types = [Array(len(begin), writable=True), Array(subject.memory_size, writable=True), *[REAL] * (inputs + 1)]
    own = builder is None
    builder = builder or Builder()
    entry = builder.function(defined("stepped", text, scope), [*entry_types, *(kind for _, kind in parameters.values())])
    unit = pruned(builder.unit, [entry]) if own else builder.unit
    return Core(subject, plant, unit, entry, np.array(begin), tuple(most), parameters)


def most_of(subject: Subject, name: str) -> int:
    """Return how many values a whole number of the state takes: turning points have room in pairs in the memory."""
    return subject.memory_size // 2 if name == "depth" and subject.memory_size else 2**31


def loaded(kind: Struct, at: int, array: str = "lasting") -> str:
    """Return the text of the fields of a tuple as they are loaded from an array."""
    numbers = [f"{array}[{at + i}]" for i in range(len(kind.fields))]
    return ", ".join(f"int({n})" if part == INTEGER else n for n, (_, part) in zip(numbers, kind.fields, strict=True))


def stored(kind: Struct, source: str, at: int, array: str = "lasting") -> str:
    """Return the lines that store the fields of a tuple in an array."""
    lines = [f"    {array}[{at + i}] = {source}.{name}" for i, (name, _) in enumerate(kind.fields)]
    return "\n".join(lines) or "    pass"
