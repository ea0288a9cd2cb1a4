"""The cycle of a drive around a friction model, as a kernel: the first position, inputs that are no numbers, the step.

It is written as text, because the state that it loads and keeps has the fields of the model, and is built into the tree
as any kernel is. What lasts from cycle to cycle is an array: position, force, whether there was a position, whether one
was refused, whether a force was no number, and the state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.exports.build import Builder
from bristle.exports.prune import pruned
from bristle.exports.scope import defined
from bristle.exports.subject import Subject
from bristle.exports.tree import Function, Unit
from bristle.exports.types import INTEGER, REAL, Array

__all__ = ["BEGUN", "FORCE", "OVERFLOW", "POSITION", "REFUSED", "STATE", "Cycle", "at_rest_of", "cycle_of"]

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


@dataclass(frozen=True)
class Cycle:
    """The cycle of a model as a function of the tree, with what it lasts on."""

    subject: Subject
    unit: Unit
    entry: Function
    begin: np.ndarray


def cycle_of(subject: Subject, builder: Builder | None = None) -> Cycle:
    """Return the cycle of a model."""
    fields = subject.state.fields
    store = "\n".join(f"    lasting[{STATE + i}] = after.{name}" for i, (name, _) in enumerate(fields))
    text = TEXT.format(load=_load(subject), store=store or "    lasting[REFUSED] = lasting[REFUSED]")
    kernel = _defined("advanced", text, subject)
    own = builder is None
    builder = builder or Builder()
    size = STATE + len(fields)
    memory = Array(subject.memory_size, writable=True)
    entry = builder.function(kernel, [Array(size, writable=True), memory, REAL, REAL, subject.parameters])
    begin = np.zeros(size)
    begin[STATE:] = [float(value) for value in subject.virgin]
    return Cycle(subject, pruned(builder.unit, [entry]) if own else builder.unit, entry, begin)


def at_rest_of(subject: Subject, builder: Builder) -> Function:
    """Return the force at a velocity, of which the sign is enough, where the contact is: nothing moves."""
    kernel = _defined("at_rest", AT_REST.format(load=_load(subject)), subject)
    lasting, memory = Array(STATE + len(subject.state.fields)), Array(subject.memory_size)
    return builder.function(kernel, [lasting, memory, REAL, subject.parameters])


def _load(subject: Subject) -> str:
    return ", ".join(
        f"int(lasting[{STATE + i}])" if kind == INTEGER else f"lasting[{STATE + i}]" for i, (_, kind) in enumerate(subject.state.fields)
    )


def _defined(name: str, text: str, subject: Subject) -> Callable[..., Any]:
    scope: dict[str, Any] = {
        "__name__": __name__,
        "State": subject.state.cls,
        "Motion": Motion,
        "friction_trial": friction_trial,
        "friction_commit": friction_commit,
        "NOMINAL_LOAD": NOMINAL_LOAD,
        "NOMINAL_TEMPERATURE": NOMINAL_TEMPERATURE,
        "POSITION": POSITION,
        "FORCE": FORCE,
        "BEGUN": BEGUN,
        "REFUSED": REFUSED,
        "OVERFLOW": OVERFLOW,
        "LARGEST": LARGEST,
    }
    return defined(name, text, scope)
