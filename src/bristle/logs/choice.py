"""Which columns of a file are read: those that an axis names, and no others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bristle.core.axis import Axis
from bristle.logs.table import spellings, without_index

__all__ = ["ALL", "NONE", "USUAL_NAMES", "Choice", "columns_named", "columns_of"]

# What a column may be called where no axis file says which channel it is.
USUAL_NAMES = {
    "time": ("time", "t"),
    "position": ("position", "pos", "q", "x"),
    "velocity": ("velocity", "vel", "v"),
    "effort": ("effort", "force", "torque"),
    "reference": ("reference", "position_ref", "setpoint"),
}


@dataclass(frozen=True)
class Choice:
    """Names of columns; None for all. Where they are `usual` ones, their case does not matter."""

    names: frozenset[str] | None = None
    usual: bool = False

    def __call__(self, name: str) -> bool:
        """Return whether this column is chosen."""
        if self.names is None:
            return True
        return name.lower() in self.names if self.usual else name in self.names or without_index(name) in self.names


ALL, NONE = Choice(), Choice(frozenset())


def columns_named(names: Iterable[str]) -> Choice:
    """Return the choice of columns of these names, each with or without the unit behind it."""
    return Choice(frozenset(spelt for name in names for spelt in spellings(name)))


def columns_of(axis: Axis | None) -> Choice:
    """Return the choice of the columns that an axis names; without one, of those that are called as usual."""
    if axis is None:
        return Choice(frozenset(name for names in USUAL_NAMES.values() for name in names), usual=True)
    return columns_named(
        [*(column.name for column in axis.columns.values()), *(channel.column for channel in (*axis.injected, *axis.regressors))]
    )
