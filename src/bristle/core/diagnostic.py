"""Diagnostics of results, held-out errors, and unfinished work."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

from bristle.core.variable import Kind

Severity = Literal["error", "warning", "note"]
Number = float | int | str | tuple[str, ...] | tuple[float, ...]


@dataclass(frozen=True)
class Diagnostic:
    """A finding about a result.

    Parameters
    ----------
    code : str
        Stable code: in kebab case for a fit or a prediction, in snake case for a check of a log.
        `bristle.report.messages` has the sentence of each code.
    parameter : str
        The affected parameter, or empty.
    severity : {"warning", "note", "error"}
        ``error``: the result is missing or unreliable. ``warning``: the result may mislead. ``note``: an assumption of
        the result.
    numbers : mapping of str to number, str or tuple of either
        Numbers in the sentence, in SI units.
    kind : {"translational", "rotational"}
        Kind of axis; decides the units of the numbers.
    """

    code: str
    parameter: str = ""
    severity: Severity = "warning"
    numbers: Mapping[str, Number] = field(default_factory=dict)
    kind: Kind = "translational"

    def as_data(self) -> dict[str, Any]:
        """Return the data for JSON: ``code``, ``parameter``, ``severity``, ``numbers``."""
        return {
            "code": self.code,
            "parameter": self.parameter,
            "severity": self.severity,
            "numbers": dict(self.numbers),
        }


@dataclass(frozen=True)
class HeldOut:
    """Held-out error on time blocks: 100 ||y - y_hat|| / ||y|| for each of them [%]."""

    block_errors_percent: tuple[float, ...]
    mean_percent: float
    std_percent: float
    of: str = "time blocks"

    def above(self, smallest: HeldOut) -> tuple[float, float]:
        """Return the mean over all blocks of this error minus the error of `smallest`, and the standard error of this mean [%]."""
        differences = np.subtract(self.block_errors_percent, smallest.block_errors_percent)
        return float(np.mean(differences)), float(
            np.std(differences, ddof=1)
        ) / differences.size**0.5


T = TypeVar("T")
UNFINISHED = Diagnostic("unfinished")


def to_the_end(work: Callable[[], T]) -> tuple[T, bool]:
    """Return the result of short work, and whether the user interrupted it; interrupted work is repeated."""
    try:
        return work(), False
    except KeyboardInterrupt:
        return work(), True


@dataclass
class BestSoFar:
    """Best point of a search, and best completed descent."""

    at: np.ndarray | None = None
    cost: float = math.inf
    result: Any = None
    whole: bool = False

    def see(self, at: np.ndarray, cost: float) -> None:
        """Record an evaluated point."""
        if cost < self.cost:
            self.at, self.cost = at.copy(), cost

    def is_known(self, at: np.ndarray) -> bool:
        """Return whether a point is close to the end of the best descent."""
        # 0.02 in coordinates: relative to a typical magnitude, or in the natural logarithm
        return self.result is not None and bool(np.all(np.abs(at - self.result.theta) < 0.02))

    def take(self, result: Any) -> None:
        """Record a completed descent."""
        if self.result is None or result.cost < self.result.cost:
            self.result = result
