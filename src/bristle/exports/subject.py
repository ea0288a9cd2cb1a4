"""What is exported: a friction model or a hysteresis operator, as functions of the tree and the data around them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.core.lazy import cached_property
from bristle.core.surroundings import Surrounding, motion_with
from bristle.exports.build import Builder
from bristle.exports.prune import pruned
from bristle.exports.scope import NotExportableError, is_kernel
from bristle.exports.settled import fact_of, settled
from bristle.exports.tree import Function, Unit
from bristle.exports.types import REAL, Array, Struct, Type, struct_of, type_of

__all__ = ["COMMIT", "TRIAL", "Subject", "arguments_left", "kernels_of", "piece_of", "settled_subject", "subject_of"]

TRIAL = {False: ("state", "memory", "motion", "dt", "p"), True: ("state", "memory", "input", "p")}
"""What a trial takes, of a friction model and of an operator, before anything was left out."""
COMMIT = ("state", "memory", "move", "p")
"""What a commit takes."""


@dataclass(frozen=True)
class Subject:
    """A friction model, its step in two functions, and what they are handed."""

    model: Model
    unit: Unit
    trial: Function
    commit: Function
    state: Struct
    motion: Struct
    move: Struct
    parameters: Struct
    memory_size: int

    @cached_property
    def virgin(self) -> Any:
        """The state before the first step."""
        return self.model.component.initial_state(self.model.parameters)

    @property
    def signals(self) -> tuple[str, ...]:
        """What friction depends on besides the motion, where a slot asks for it: load, temperature and so on."""
        needed = {surrounding.field for surrounding in _surroundings(self.model)}
        return tuple(name for name in self.usual if name in needed)

    @property
    def usual(self) -> dict[str, float]:
        """What friction may depend on besides the motion, with the value of each where nobody tells it."""
        return self.motion.cls._field_defaults

    @property
    def is_operator(self) -> bool:
        """Whether it is a hysteresis operator, which knows no time."""
        return self.model.component.family == "hysteresis"

    def outputs(self, u: np.ndarray) -> np.ndarray:
        """Return what an operator gives at each input by the kernels as they stand; the last one where it gives none.

        An inverse has no output beyond saturation: the target holds the last one there, and stays where it is.
        """
        component, p, state = self.model.component, self.model.parameters, self.virgin
        memory, last = component.new_memory(p), 0.0
        outputs = np.zeros(len(u))
        for k, value in enumerate(u.tolist()):
            output, move = component.trial(state, memory, value, p)
            if math.isfinite(output):
                state, last = component.commit(state, memory, move, p), output
            outputs[k] = last
        return outputs

    def forces(self, x: np.ndarray, dt: float) -> np.ndarray:
        """Return the force at each sample by the kernels as they stand: nothing is compiled."""
        component, p, state = self.model.component, self.model.parameters, self.virgin
        memory = component.new_memory(p)
        force = np.zeros(len(x))
        for k in range(1, len(x)):
            v = (float(x[k]) - float(x[k - 1])) / dt
            motion = Motion(v, float(x[k]))
            force[k], move = component.trial(state, memory, motion, dt, p)
            state = component.commit(state, memory, move, p)
        return force


def subject_of(model: Model, constants: dict[tuple[str, float], float] | None = None) -> Subject:
    """Return a friction model, or a hysteresis operator, as functions of the tree."""
    component = model.component
    for function in (component.trial, component.commit):
        if not is_kernel(function):
            raise NotExportableError(function, None, "is not a kernel: decorate it with @kernel from bristle.core")
    builder = Builder(constants or {})
    parameters = _struct(type_of(model.parameters))
    state = _struct(type_of(component.initial_state(model.parameters)))
    moved = motion_with(_surroundings(model))
    motion = struct_of(moved, [REAL] * len(moved._fields))
    size = component.memory_size(model.parameters)
    inputs = [REAL] if component.family == "hysteresis" else [motion, REAL]
    trial = builder.function(component.trial, [state, Array(size), *inputs, parameters])
    move = _move_of(trial.result, component.trial)
    commit = builder.function(component.commit, [state, Array(size, writable=True), move, parameters])
    if commit.result != state:
        raise NotExportableError(component.commit, None, f"returns something else than a {state.cls.__name__}")
    unit = pruned(builder.unit, (trial, commit) if state.fields or commit.writes else (trial,))
    return Subject(model, unit, trial, commit, state, motion, move, parameters, size)


def settled_subject(subject: Subject, unknown: Iterable[tuple[str, ...]] = (), *, single: bool = False) -> Subject:
    """Return what is exported with all left out that its parameters decide, but for those at some paths."""
    commits = bool(subject.state.fields) or subject.commit.writes
    roots = [subject.trial, subject.commit] if commits else [subject.trial]
    fact = fact_of(subject.model.parameters, subject.parameters, unknown)
    named = {argument_of(subject.trial, TRIAL[subject.is_operator], "p"), argument_of(subject.commit, COMMIT, "p")}
    unit, written = settled(subject.unit, roots, dict.fromkeys(named, fact), single=single)
    return replace(subject, unit=unit, trial=written[0], commit=written[1] if commits else subject.commit)


def _surroundings(model: Model) -> tuple[Surrounding, ...]:
    return () if model.component.family == "hysteresis" else model.component.surroundings


def argument_of(function: Function, names: tuple[str, ...], name: str) -> str:
    """Return what a function calls one of these arguments."""
    return function.source.__code__.co_varnames[names.index(name)]


def arguments_left(function: Function, names: tuple[str, ...]) -> list[str]:
    """Return which of these arguments, in this order, a function still takes."""
    arguments = dict(zip(function.source.__code__.co_varnames, names, strict=False))
    return [arguments[parameter.name] for parameter in function.parameters]


def _struct(kind: Type) -> Struct:
    assert isinstance(kind, Struct)
    return kind


def _move_of(result: Type, trial: Callable[..., Any]) -> Struct:
    parts = [kind for _, kind in result.fields] if isinstance(result, Struct) and result.is_plain else []
    if len(parts) == 2 and parts[0] == REAL and isinstance(parts[1], Struct):
        return parts[1]
    raise NotExportableError(trial, None, "returns something else than (force, move), move a NamedTuple of scalars")


def kernels_of(model: Model) -> list[Function]:
    """Return every function of the tree that the kernels of a friction model become, those in continuous time too."""
    subject, component = subject_of(model), model.component
    builder = Builder()
    state, motion, p, memory = subject.state, subject.motion, subject.parameters, Array(subject.memory_size)
    builder.function(component.trial, [state, memory, motion, REAL, p])
    builder.function(component.commit, [state, Array(subject.memory_size, writable=True), subject.move, p])
    if component.rate is not None:
        builder.function(component.rate, [state, motion, p])
    if component.piece is not None and component.flow is not None and component.arrival is not None:
        contact, piece = piece_of(subject, builder)
        builder.function(component.flow, [contact, piece, motion, p])
        builder.function(component.arrival, [state, memory, contact, p])
    return builder.unit.functions


def piece_of(subject: Subject, builder: Builder) -> tuple[Struct, Struct]:
    """Return the types of what varies of a contact, and of what holds from event to event."""
    kernel = subject.model.component.piece
    memory = Array(subject.memory_size)
    begun = builder.function(kernel, [subject.state, memory, subject.motion, subject.parameters]).result
    parts = [kind for _, kind in begun.fields] if isinstance(begun, Struct) else []
    if len(parts) != 2 or not all(isinstance(part, Struct) for part in parts):
        raise NotExportableError(kernel, None, "returns something else than (contact, piece), NamedTuples of scalars")
    contact, piece = (_struct(part) for part in parts)
    return contact, piece
