"""One component of a run: its model as flat vectors, and how to name and compile what runs it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dispatch import functions_of
from bristle.core.errors import InputWarning
from bristle.core.packing import pack, structure_of

__all__ = ["Part", "vector", "warn_of_lost"]


def vector(values: Any) -> np.ndarray:
    """Return values as compiled entries take them: contiguous, writable, of floating point."""
    return np.require(values, dtype=float, requirements=("C", "W"))


@dataclass
class Part:
    """One component of a run: its vectors, of which the run changes `state`, and how to name and compile it."""

    model: Model
    parameters: np.ndarray = field(init=False)
    state: np.ndarray = field(init=False)
    structures: tuple[Any, Any] = field(init=False)

    def __post_init__(self) -> None:
        p = self.model.parameters
        state = self.model.component.initial_state(p)
        self.parameters, self.state = pack(p), pack(state)
        self.structures = (structure_of(p), structure_of(state))

    @property
    def component(self) -> Any:
        """The descriptor."""
        return self.model.component

    @property
    def key(self) -> str:
        """Name of the component with those that it holds."""
        return f"{self.model.component.module}.{_name_of(self.structures[0])}"

    @property
    def lost(self) -> int:
        """How many pairs of turning points its memory had no room for; 0 for one that forgets nothing."""
        fields = self.structures[1][0]._fields
        return int(self.state[fields.index("lost")]) if "lost" in fields else 0

    @property
    def functions(self) -> tuple[Any, ...]:
        """Functions of the component and of those that it holds: what a user may have written."""
        return _functions(self.structures[0])


def warn_of_lost(part: Part) -> None:
    """Warn where the memory of a component had too little room."""
    if part.lost:
        warnings.warn(
            f"{part.model.name}: the memory of turning points was full and forgot its innermost pair {part.lost} "
            f"times, so loops do not close as they should. Raise capacity, now {part.model.values.get('capacity')}",
            InputWarning,
            stacklevel=4,
        )


def _name_of(structure: Any) -> str:
    cls, parts = structure
    return cls.__qualname__ + "".join(_name_of(part) for part in parts if isinstance(part, tuple))


@cache
def _functions(structure: Any) -> tuple[Any, ...]:
    cls, parts = structure
    found = functions_of(cls)
    for part in parts:
        if isinstance(part, tuple):
            found += _functions(part)
    return found
