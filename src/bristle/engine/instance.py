"""One component of a run: its model as flat vectors, and the name and compilation of its entry."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from bristle.core import InputError, InputWarning, Model
from bristle.core.dispatch import functions_of
from bristle.core.packing import number_count, pack, structure_of, unpacker
from bristle.core.surroundings import motion_with
from bristle.engine.compilation import compiled


@dataclass
class Instance:
    """One component of a run with its vectors; the run changes `state`."""

    model: Model
    component: Any = field(init=False)
    parameters: np.ndarray = field(init=False)
    state: np.ndarray = field(init=False)
    structures: tuple[Any, Any] = field(init=False)

    def __post_init__(self) -> None:
        if not isinstance(self.model, Model):
            raise InputError(
                "must be a model with parameters",
                path="model",
                value=self.model,
                mend='Write, for example, friction.coulomb(F_C="20 N")',
            )
        p, self.component = self.model.parameters, self.model.component
        state = self.component.initial_state(p)
        self.parameters, self.state = pack(p), pack(state)
        self.structures = (structure_of(p), structure_of(state))

    def begin(self, state: Any) -> None:
        """Set the initial state, if it is given."""
        if state is None:
            return
        if structure_of(state) != self.structures[1]:
            raise InputError(
                "belongs to a different model",
                path="state",
                value=state,
                allowed=f"a state of {self.model.name}",
            )
        self.state = pack(state)

    @property
    def motion(self) -> Any:
        """Class of the motion argument of a friction model."""
        return motion_with(self.component.surroundings)

    @property
    def key(self) -> str:
        """Name of the component with its inner components."""
        return f"{self.model.component.module}.{_name_of(self.structures[0])}"

    @property
    def lost(self) -> int:
        """Number of pairs of turning points that were lost because the memory was full."""
        return int(sum(map(self.state.__getitem__, _places_of("lost", self.structures[1]))))

    @property
    def state_now(self) -> Any:
        """The state in the type of the component."""
        return unpacker(self.structures[1])(self.state)

    @property
    def functions(self) -> tuple[Any, ...]:
        """Functions of the component and its inner components, which a user may have written."""
        return _functions(self.structures[0])


def entry_of(name: str, part: Instance, kind: Any, make: Callable[..., Any], *further: Any) -> Any:
    """Return the entry of this name for this component, which `make` creates from its structures."""
    return compiled(
        f"{name}-{part.key}", lambda: make(*part.structures, *further), kind, part.functions
    )


@cache
def _places_of(field: str, structure: Any, first: int = 0) -> tuple[int, ...]:
    """Return the indices of the fields of this name in the vector of a NamedTuple of scalars, also in nested tuples."""
    places: list[int] = []
    at = first
    for name, part in zip(structure[0]._fields, structure[1], strict=True):
        if isinstance(part, tuple):
            places += _places_of(field, part, at)
        elif name == field:
            places.append(at)
        at += number_count(part)
    return tuple(places)


def warn_of_lost(part: Instance) -> None:
    """Warn if the memory of a component was too small."""
    if lost := part.lost:
        warnings.warn(
            f"{part.model.name}: the memory of turning points was full and lost its innermost pair {lost} "
            f"times, so some loops do not close. Raise the parameter capacity above {part.model.values.get('capacity')}",
            InputWarning,
            stacklevel=4,
        )


@cache
def _name_of(structure: Any) -> str:
    cls, parts = structure
    return cls.__qualname__ + "".join(_name_of(part) for part in parts if isinstance(part, tuple))


@cache
def _functions(structure: Any) -> tuple[Any, ...]:
    cls, parts = structure
    functions = functions_of(cls)
    for part in parts:
        if isinstance(part, tuple):
            functions += _functions(part)
    return functions


def memory_of(model: Model, memory: Any) -> np.ndarray:
    """Return the memory of a friction model: a copy of the given memory, or that of a virgin model."""
    fresh = model.component.new_memory(model.parameters)
    if memory is None:
        return fresh
    memory = np.array(memory)  # a copy: a run writes into it
    if memory.shape != fresh.shape:
        raise InputError(
            "has the wrong size", path="memory", value=memory.shape, allowed=f"shape {fresh.shape}"
        )
    return memory
