"""The result of a comparison of two logs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.variable import Kind, unit_of
from bristle.logs.log import Log

Verdict = Literal["lower", "higher", "no_change", "unknown"]
ROUNDING = 1e-6  # of the larger value: a smaller change is rounding


@dataclass(frozen=True)
class Change:
    """A quantity before and after a change of the axis.

    Parameters
    ----------
    name : str
        Name of the quantity, such as ``following_error.rms``.
    quantity : str
        Dimension of the quantity: ``length`` or ``force``.
    before, after : float
        Value [m or rad, N or N*m].
    interval : tuple of float or None
        Ends of the 95 % interval of the change [m or rad, N or N*m]; None for too few cycles.
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
        """Value after minus value before [m or rad, N or N*m]."""
        return self.after - self.before

    @property
    def change_percent(self) -> float:
        """Change in percent of the value before."""
        if self.before:
            return 100.0 * self.change / abs(self.before)
        return math.nan

    @property
    def interval_percent(self) -> tuple[float, float] | None:
        """Interval of the change in percent of the value before."""
        if self.interval is None or self.before == 0.0:
            return None
        low, high = sorted(100.0 * end / abs(self.before) for end in self.interval)
        return low, high

    @property
    def verdict(self) -> Verdict:
        """Verdict: ``lower`` or ``higher`` if the interval excludes zero, else ``no_change``; ``unknown`` without an interval."""
        if self.interval is None:
            return "unknown"
        if (
            abs(self.change) <= ROUNDING * max(abs(self.before), abs(self.after))
            or math.prod(self.interval) <= 0.0
        ):
            return "no_change"
        if self.change < 0.0:
            return "lower"
        return "higher"

    def as_data(self) -> dict[str, Any]:
        """Return the change as plain data."""
        names = (
            "before",
            "after",
            "change",
            "interval",
            "change_percent",
            "interval_percent",
            "unit",
            "verdict",
        )
        values = ((name, getattr(self, name)) for name in names)
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values}


@dataclass(frozen=True)
class Shared:
    """The motion that both sides of a comparison contain.

    Parameters
    ----------
    before_percent, after_percent : float
        Share of the motion of each side that the other side also has [%].
    cycles_before, cycles_after : int
        Number of compared cycles.
    motions : int
        Number of different motions.
    complete : bool
        Whether the cycles are complete, forward and backward, and not pieces of a motion with few reversals.
    paired : bool
        Whether the resampling draws pairs of cycles of one motion, because few motions repeat.
    as_one : float
        Number of correlated neighbouring cycles per independent cycle; the median of all quantities.
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
    """The mean course of the compared signals, motion by motion; arrays of shape (sample,), in SI units of the axis.

    Parameters
    ----------
    time : ndarray
        Time from the beginning of the first motion [s].
    motion : ndarray
        Reference, or position without a reference.
    before, after : ndarray
        Following error, or effort without a reference.
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
    """The comparison of two sides.

    Parameters
    ----------
    kind : {"translational", "rotational"}
        Kind of axis.
    changes : mapping of str to Change
        Changes of the following error, its peaks at reversals, the effort and the friction level, where the logs
        determine them.
    friction_curve : sequence of tuple of float and Change
        Speed [m/s or rad/s] and friction there.
    shared : Shared
        The common part of both sides.
    window : float or None
        Time after a reversal to search for the peak error [s].
    course : Course
        Means over cycles, for a figure.
    turns : tuple of Turn
        Means around reversals, for a figure.
    logs_before, logs_after : tuple of Log
        The logs of the two sides.
    diagnostics : tuple of Diagnostic
        Warnings, and the basis of the comparison.
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
        """Whether the change reduced the rms following error; None if unknown."""
        change = self.changes.get("following_error.rms")
        if change is None or change.verdict == "unknown":
            return None
        return change.verdict == "lower"
