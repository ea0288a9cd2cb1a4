"""What a comparison of two logs says."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.variable import Kind, unit_of
from bristle.logs.log import Log

Verdict = Literal["lower", "higher", "no_change", "unknown"]
ROUNDING = 1e-6  # of the larger value: a change that is rounding


@dataclass(frozen=True)
class Change:
    """A quantity before and after.

    Parameters
    ----------
    name : str
        Such as ``following_error.rms``.
    quantity : str
        What it is of: ``length`` or ``force``.
    before, after : float
        Its value [m or rad, N or N*m].
    interval : tuple of float or None
        Ends of the 95 % interval of the change [m or rad, N or N*m]; None where too few cycles tell.
    kind : {"translational", "rotational"}
        Kind of axis.
    """

    name: str
    quantity: str
    before: float
    after: float
    interval: tuple[float, float] | None
    kind: Kind = "translational"

    @property
    def unit(self) -> str:
        """SI unit."""
        return unit_of(self.quantity, self.kind)

    @property
    def change(self) -> float:
        """What it is after less what it was before [m or rad, N or N*m]."""
        return self.after - self.before

    @property
    def change_percent(self) -> float:
        """Change in percent of the value before."""
        return 100.0 * self.change / abs(self.before) if self.before else math.nan

    @property
    def interval_percent(self) -> tuple[float, float] | None:
        """Interval of the change in percent of the value before."""
        if self.interval is None or self.before == 0.0:
            return None
        low, high = sorted(100.0 * end / abs(self.before) for end in self.interval)
        return low, high

    @property
    def verdict(self) -> Verdict:
        """Whether its size is lower or higher, by an interval without zero; ``no_change`` that these logs can tell."""
        if self.interval is None:
            return "unknown"
        if abs(self.change) <= ROUNDING * max(abs(self.before), abs(self.after)) or math.prod(self.interval) <= 0.0:
            return "no_change"
        return "lower" if self.change < 0.0 else "higher"

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data."""
        names = ("before", "after", "change", "interval", "change_percent", "interval_percent", "unit", "verdict")
        values = ((name, getattr(self, name)) for name in names)
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values}


@dataclass(frozen=True)
class Shared:
    """What two sides have in common.

    Parameters
    ----------
    before_percent, after_percent : float
        Share of the motion of each side that the other has too [%].
    cycles_before, cycles_after : int
        How many cycles were compared.
    motions : int
        How many different ones.
    complete : bool
        Whether they are whole cycles, to and fro, and not pieces of a motion that hardly turns.
    paired : bool
        Whether cycles of one motion were drawn together, because each motion comes once.
    as_one : float
        How many neighbouring cycles count as one, being alike; the median of all quantities.
    """

    before_percent: float
    after_percent: float
    cycles_before: int
    cycles_after: int
    motions: int
    complete: bool
    paired: bool
    as_one: float


@dataclass(frozen=True)
class Course:
    """The mean course of what is compared, motion by motion; arrays of shape (sample,), in SI of the axis.

    Parameters
    ----------
    time : ndarray
        Time from the beginning of the first motion [s].
    motion : ndarray
        Reference, or position where there is none.
    before, after : ndarray
        Following error, or effort where there is none.
    """

    time: np.ndarray
    motion: np.ndarray
    before: np.ndarray
    after: np.ndarray


@dataclass(frozen=True)
class Turn:
    """The mean following error around the reversals of one direction; arrays of shape (sample,).

    Parameters
    ----------
    name : {"forward_to_backward", "backward_to_forward"}
        Direction.
    time : ndarray
        Time from the reversal [s].
    before, after : ndarray
        Following error [m or rad].
    """

    name: str
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two sides, held against each other.

    Parameters
    ----------
    kind : {"translational", "rotational"}
        Kind of axis.
    changes : mapping of str to Change
        What changed: following error, its peaks at reversals, effort, friction level; only what the logs tell.
    friction_curve : sequence of tuple of float and Change
        Speed [m/s or rad/s] and friction there.
    shared : Shared
        What was compared.
    window : float or None
        Time behind a reversal in which its peak is looked for [s].
    course : Course
        Means over cycles, to be drawn.
    turns : tuple of Turn
        Means around reversals, to be drawn.
    logs_before, logs_after : tuple of Log
        The two sides.
    diagnostics : tuple of Diagnostic
        What may mislead, and what the comparison rests on.
    """

    kind: Kind
    changes: Mapping[str, Change]
    friction_curve: Sequence[tuple[float, Change]]
    shared: Shared
    window: float | None
    course: Course
    turns: tuple[Turn, ...]
    logs_before: tuple[Log, ...]
    logs_after: tuple[Log, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def helped(self) -> bool | None:
        """Whether the following error, root mean square, is lower; None where nothing tells of it."""
        change = self.changes.get("following_error.rms")
        return None if change is None or change.verdict == "unknown" else change.verdict == "lower"
