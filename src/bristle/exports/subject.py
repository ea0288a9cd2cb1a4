"""The subject of an export, a friction model or a hysteresis operator, as functions of the tree, and the walk of its self-test."""

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any

import numpy as np

from bristle.core import Model, Motion, cached_property
from bristle.core.surroundings import motion_with
from bristle.engine.screwed import Memories, ScrewedModel
from bristle.engine.translation.build import Builder
from bristle.engine.translation.scope import NotExportableError, is_kernel
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    Array,
    Function,
    Struct,
    Type,
    Unit,
    struct_of,
    struct_type,
)
from bristle.exports.settled import fact_of, pruned, settled

TRIAL = {False: ("state", "memory", "motion", "dt", "p"), True: ("state", "memory", "input", "p")}
"""Arguments of a trial, of a friction model and of an operator, before unused ones are dropped."""
COMMIT = ("state", "memory", "move", "p")  # Arguments of a commit


@dataclass(frozen=True)
class Subject:
    """A friction model, the two functions of its step, and their arguments."""

    model: Model
    unit: Unit
    trial: Function
    commit: Function
    state: Struct
    motion: Struct
    move: Struct
    parameters: Struct
    memories: Mapping[str, int]
    derived: Function | None = None
    """The step with its tangent in one direction, if the export has derivatives."""

    @property
    def memory_size(self) -> int:
        """Numbers in all memories."""
        return sum(self.memories.values())

    @cached_property
    def virgin(self) -> Any:
        """The state before the first step."""
        return self.model.component.initial_state(self.model.parameters)

    @property
    def signals(self) -> tuple[str, ...]:
        """Inputs of friction besides the motion, as slots require: load, temperature and so on."""
        needed = ()
        if not self.is_operator:
            needed = {surrounding.field for surrounding in self.model.component.surroundings}
        return tuple(name for name in self.usual if name in needed)

    @property
    def usual(self) -> dict[str, float]:
        """Possible inputs of friction besides the motion, with their default values."""
        return self.motion.cls._field_defaults

    @property
    def commits(self) -> bool:
        """Whether a step changes the state or the memory."""
        return bool(self.state.fields) or self.commit.writes

    @property
    def is_operator(self) -> bool:
        """Whether it is a hysteresis operator, which has no time."""
        return self.model.component.family == "hysteresis"

    def outputs(self, u: np.ndarray) -> np.ndarray:
        """Return the output of an operator at each input by uncompiled kernels; an inverse repeats its last output beyond saturation."""
        component = self.model.component
        p = self.model.parameters
        state = self.virgin
        memory = component.new_memory(p)
        outputs = [0.0]
        for value in u.tolist():
            output, move = component.trial(state, memory, value, p)
            if math.isfinite(output):
                state = component.commit(state, memory, move, p)
            else:
                output = outputs[-1]
            outputs.append(output)
        return np.array(outputs[1:])

    def forces(self, x: np.ndarray, dt: float) -> np.ndarray:
        """Return the force at each sample, computed by the uncompiled kernels."""
        return forces_of(self.model, x, dt)


def forces_of(model: Model, x: np.ndarray, dt: float, *around: float) -> np.ndarray:
    """Return the force of a friction model at each sample, by uncompiled kernels, under a load and at a temperature."""
    component = model.component
    p = model.parameters
    at = x.tolist()
    state = component.initial_state(p)
    memory = component.new_memory(p)
    force = np.zeros(len(x))
    for k in range(1, len(x)):
        force[k], move = component.trial(
            state, memory, Motion((at[k] - at[k - 1]) / dt, at[k], *around), dt, p
        )
        state = component.commit(state, memory, move, p)
    return force


def subject_of(model: Model, constants: dict[tuple[str, float], float] | None = None) -> Subject:
    """Return a friction model, or a hysteresis operator, as functions of the tree."""
    component = model.component
    is_operator = component.family == "hysteresis"
    for function in (component.trial, component.commit):
        if not is_kernel(function):
            raise NotExportableError(
                function, None, "is not a kernel: decorate it with @kernel from bristle.core"
            )
    builder = Builder(constants or {})
    parameters = struct_type(model.parameters)
    state = struct_type(component.initial_state(model.parameters))
    moved = motion_with(() if is_operator else component.surroundings)
    motion = struct_of(moved, [REAL] * len(moved._fields))
    memories = {"memory": component.memory_size(model.parameters)}
    if isinstance(component, ScrewedModel):
        memories = {
            f"{side}_memory": size
            for side, size in component.memory_sizes(model.parameters)._asdict().items()
        }
    inputs = [motion, REAL]
    if is_operator:
        inputs = [REAL]
    trial = builder.function(component.trial, [state, _memory_type(memories), *inputs, parameters])
    parts = []
    if isinstance(trial.result, Struct) and trial.result.is_plain:
        parts = [kind for _, kind in trial.result.fields]
    if len(parts) != 2 or parts[0] != REAL or not isinstance(parts[1], Struct):
        raise NotExportableError(
            component.trial, None, "must return (force, move), with move a NamedTuple of scalars"
        )
    commit = builder.function(
        component.commit, [state, _memory_type(memories, writable=True), parts[1], parameters]
    )
    if commit.result != state:
        raise NotExportableError(component.commit, None, f"must return a {state.cls.__name__}")
    roots = [trial]
    if state.fields or commit.writes:
        roots.append(commit)
    unit = pruned(builder.unit, roots)
    return Subject(model, unit, trial, commit, state, motion, parts[1], parameters, memories)


def _memory_type(memories: Mapping[str, int], *, writable: bool = False) -> Type:
    """Return the type of the memory of a model: an array, or an array for each side of a screw."""
    arrays = [Array(size, writable) for size in memories.values()]
    if len(arrays) == 1:
        return arrays[0]
    return struct_of(Memories, arrays)


def settled_subject(
    subject: Subject, unknown: Iterable[tuple[str, ...]] = (), *, single: bool = False
) -> Subject:
    """Return the subject without the branches that its parameters rule out, except parameters at some paths."""
    roots = {"trial": subject.trial}
    if subject.commits:
        roots["commit"] = subject.commit
    if subject.derived:
        roots["derived"] = subject.derived
    fact = fact_of(subject.model.parameters, subject.parameters, unknown)
    # The name of the parameters in a kernel.
    arguments = ((subject.trial, TRIAL[subject.is_operator]), (subject.commit, COMMIT))
    named = {
        function.source.__code__.co_varnames[names.index("p")] for function, names in arguments
    } | {"p"}
    unit, written = settled(
        subject.unit, list(roots.values()), dict.fromkeys(named, fact), single=single
    )
    return replace(subject, unit=unit, **dict(zip(roots, written, strict=True)))


def arguments_left(function: Function, names: tuple[str, ...]) -> list[str]:
    """Return the arguments among `names` that a function still has, in this order."""
    arguments = dict(zip(function.source.__code__.co_varnames, names, strict=False))
    return [arguments[parameter.name] for parameter in function.parameters]


def places_of(sizes: Mapping[str, int]) -> dict[str, int]:
    """Return the place of each memory in an array of all memories, from their sizes."""
    return dict(zip(sizes, accumulate(sizes.values(), initial=0), strict=False))


def layout_of(subject: Subject, scalar: str) -> str:
    """Return the text that identifies the saved bytes of a friction model or an operator."""
    return f"{subject.model.name} {scalar} {subject.state.fields} {subject.memory_size}"


def capacity_of(name: str, memory_size: int) -> int:
    """Return the number of values of a whole number in the state, from 0: one per storable turning point."""
    if name.endswith("depth") and memory_size:
        return memory_size // 2
    return 2**31


def most_of(name: str, kind: Type, memory_size: int) -> int:
    """Return the number of values of a whole number in the state; 0 for a real number."""
    if kind == INTEGER:
        return capacity_of(name, memory_size)
    return 0


def kernels_of(model: Model) -> list[Function]:
    """Return all functions of the tree of the kernels of a friction model, also those in continuous time."""
    subject = subject_of(model)
    component = model.component
    builder = Builder()
    state = subject.state
    motion = subject.motion
    p = subject.parameters
    memory = Array(subject.memory_size)
    builder.function(component.trial, [state, memory, motion, REAL, p])
    builder.function(
        component.commit, [state, Array(subject.memory_size, writable=True), subject.move, p]
    )
    if component.rate is not None:
        builder.function(component.rate, [state, motion, p])
    if component.piece is not None and component.flow is not None and component.arrival is not None:
        contact, piece = piece_of(subject, builder)
        builder.function(component.flow, [contact, piece, motion, p])
        builder.function(component.arrival, [state, memory, contact, p])
    return builder.unit.functions


def piece_of(subject: Subject, builder: Builder) -> tuple[Struct, Struct]:
    """Return the types of the continuous state of a contact, and of its data between events."""
    kernel = subject.model.component.piece
    memory = Array(subject.memory_size)
    begun = builder.function(
        kernel, [subject.state, memory, subject.motion, subject.parameters]
    ).result
    parts = []
    if isinstance(begun, Struct):
        parts = [kind for _, kind in begun.fields if isinstance(kind, Struct)]
    if len(parts) != 2 or not isinstance(begun, Struct) or len(begun.fields) != 2:
        raise NotExportableError(
            kernel, None, "must return (contact, piece), NamedTuples of scalars"
        )
    return parts[0], parts[1]


COUNT = 2000
SEED = 20260
FACTOR = 1664525
TERM = 1013904223
# Longest step of each part of the walk, over the pre-sliding distance.
SCALES = (0.05, 0.5, 5.0, 50.0)
PART = 125  # consecutive steps of one scale
RESTS = 16  # one step in so many has length 0
FNV_OFFSET = 0xCBF29CE484222325
FNV_PRIME = 0x100000001B3
# Input of an operator: a force of an inverse, a field of a magnet.
FARTHEST = {False: 1.0, True: 1e6}
# Distance of a model without pre-sliding [m or rad]; duration of a step without viscosity [s]
USUAL = 1e-6
SLOW = 1e6


@dataclass(frozen=True)
class Walk:
    """Positions at equal time steps."""

    scales: tuple[float, ...]
    dt: float

    def positions(self, count: int = COUNT) -> np.ndarray:
        """Return the position at each sample [m or rad]; the first one is 0."""
        x = np.zeros(count)
        bits = SEED
        at = 0.0
        for k in range(1, count):
            bits = (bits * FACTOR + TERM) % 2**32
            if (bits >> 8) % RESTS:
                at = at + ((bits >> 16) - 32768.0) * self.scales[(k // PART) % len(self.scales)]
            x[k] = at
        return x


def walk_of(subject: Subject, dt: float) -> Walk:
    """Return a walk through pre-sliding and far into sliding."""
    return walk_over(presliding_distance(subject), dt)


def walk_over(reach: float, dt: float) -> Walk:
    """Return a walk with the scales of this distance [m or rad]."""
    return Walk(tuple(scale * reach / 32768.0 for scale in SCALES), dt)


def hash_of(forces: Iterable[float]) -> int:
    """Return the hash of the bytes of some numbers, lowest byte first."""
    return digest_of(b"".join(struct.pack("<d", force) for force in forces))


def digest_of(content: bytes) -> int:
    """Return the 64-bit hash of Fowler, Noll and Vo (1a) of some bytes."""
    digest = FNV_OFFSET
    for byte in content:
        digest = ((digest ^ byte) * FNV_PRIME) % 2**64
    return digest


def presliding_distance(subject: Subject) -> float:
    """Return the distance over which a virgin contact in slow motion reaches half of its largest force [m or rad]."""
    component = subject.model.component
    p = subject.model.parameters
    state = subject.virgin
    memory = component.new_memory(p)
    forces = []
    at = 0.0
    farther = np.geomspace(1e-12, FARTHEST[subject.is_operator], 120)
    for x in farther.tolist():
        inputs = (x,)
        if not subject.is_operator:
            inputs = (Motion((x - at) / SLOW, x), SLOW)
        force, move = component.trial(state, memory, *inputs, p)
        if not math.isfinite(force):
            break
        state = component.commit(state, memory, move, p)
        at = x
        forces.append(abs(force))
    reached = np.array(forces) >= 0.5 * max(forces)
    if max(forces) > 0.0 and not reached[0]:
        return float(farther[np.argmax(reached)])
    return USUAL
