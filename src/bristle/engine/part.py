"""One component of a run: its model as flat vectors, and how to name and compile what runs it."""

from __future__ import annotations

import numbers
import warnings
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dispatch import functions_of
from bristle.core.errors import InputError, InputWarning
from bristle.core.packing import pack, structure_of, unpacker

__all__ = ["Part", "check_run", "memory_of", "vector", "warn_of_lost"]


def vector(values: Any, name: str = "signal") -> np.ndarray:
    """Return values as compiled entries take them: contiguous, writable, of floating point.

    Raises
    ------
    InputError
        If they are no real numbers, or some of them are masked; it tells `name`.
    """
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=name, mend="Fill them, or leave those samples out")
    try:
        numeric = np.asarray(values).dtype.kind in "fiub"
    except ValueError:  # rows of different lengths
        numeric = False
    if not numeric:
        raise InputError("must hold real numbers in SI", path=name, value=values)
    return np.require(values, dtype=float, requirements=("C", "W"))


@dataclass
class Part:
    """One component of a run: its vectors, of which the run changes `state`, and how to name and compile it."""

    model: Model
    parameters: np.ndarray = field(init=False)
    state: np.ndarray = field(init=False)
    structures: tuple[Any, Any] = field(init=False)

    def __post_init__(self) -> None:
        if not isinstance(self.model, Model):
            raise InputError("must be a model with parameters", path="model", value=self.model,
                             mend='Give them, as in friction.coulomb(F_C="20 N")')  # fmt: skip
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
        return int(sum(self.state[place] for place in _places_of("lost", self.structures[1])))

    @property
    def state_now(self) -> Any:
        """The state, as the component has it."""
        return unpacker(self.structures[1])(self.state)

    @property
    def functions(self) -> tuple[Any, ...]:
        """Functions of the component and of those that it holds: what a user may have written."""
        return _functions(self.structures[0])


@cache
def _places_of(field: str, structure: Any, first: int = 0) -> tuple[int, ...]:
    """Return where fields of this name stand in the vector of a NamedTuple of scalars, nested ones included."""
    found: list[int] = []
    at = first
    for name, part in zip(structure[0]._fields, structure[1], strict=True):
        if isinstance(part, tuple):
            found += _places_of(field, part, at)
        elif name == field:
            found.append(at)
        at += _count(part)
    return tuple(found)


def _count(part: Any) -> int:
    return sum(_count(one) for one in part[1]) if isinstance(part, tuple) else 1


def warn_of_lost(part: Part) -> None:
    """Warn where the memory of a component had too little room."""
    if part.lost:
        warnings.warn(
            f"{part.model.name}: the memory of turning points was full and forgot its innermost pair {part.lost} "
            f"times, so loops do not close as they should. Raise capacity, now {part.model.values.get('capacity')}",
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
    found = functions_of(cls)
    for part in parts:
        if isinstance(part, tuple):
            found += _functions(part)
    return found


def memory_of(model: Model, given: Any) -> np.ndarray:
    """Return the memory of a friction model: a copy of what is given, or that of a virgin model.

    Raises
    ------
    InputError
        If its size is not that which the model reads and writes.
    """
    fresh = model.component.new_memory(model.parameters)
    if given is None:
        return fresh
    memory = np.array(given, dtype=float)
    if memory.shape != fresh.shape:
        raise InputError("has the wrong size", path="memory", value=memory.shape, allowed=f"shape {fresh.shape}")
    return memory


def check_run(dt: float, steps: int = 1, *, count: int | None = None, delay: int = 0, **signals: Any) -> None:
    """Refuse what compiled code would run out of bounds with, or turn into nonsense.

    Parameters
    ----------
    dt : float
        Time step [s], which must be positive.
    steps, delay : int
        Integration steps in a sample, at least 1; samples of delay, at least 0.
    count : int, optional
        Length that each signal must have.
    **signals : float or ndarray
        Signals by name, which must be finite.

    Raises
    ------
    InputError
        With the name, what was found, and what is allowed.
    """
    if not (isinstance(dt, numbers.Real) and 0.0 < dt < np.inf):
        raise InputError("must be positive", path="dt", value=dt, allowed="> 0 s")
    for name, number, least in (("steps", steps, 1), ("delay", delay, 0)):
        if number != int(number) or number < least:
            raise InputError("must be a whole number", path=name, value=number, allowed=f">= {least}")
    for name, signal in signals.items():
        if not _is_finite(signal):
            raise InputError("is not finite throughout", path=name, mend="Remove NaN and infinity first")
        if count is not None and np.ndim(signal) and name != "reference" and np.shape(signal) != (count,):
            raise InputError("has the wrong length", path=name, value=np.shape(signal), allowed=f"shape ({count},)")


def _is_finite(signal: Any) -> bool:
    # A sum is finite only if every term is, and costs a fraction of a test of each; one that overflows decides nothing.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.sum(signal)
    return bool(np.isfinite(total)) or bool(np.all(np.isfinite(signal)))
