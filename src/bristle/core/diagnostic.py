"""What results carry besides their numbers: what was found out about the data, errors held out, work left unfinished."""

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
    """One thing to know of a result.

    Parameters
    ----------
    code : str
        What it is: in kebab case of a fit or a prediction, in snake case of a check of a log. A code keeps its meaning
        from version to version; `bristle.report.messages` has the sentence of each.
    parameter : str
        The parameter it concerns; empty where it concerns none.
    severity : {"warning", "note", "error"}
        ``error``: there is no result, or none to rely on. ``warning``: the result may mislead. ``note``: what it rests
        on.
    numbers : mapping of str to number, str or tuple of either
        What the sentence needs, in SI.
    kind : {"translational", "rotational"}
        Of the axis; decides the units of the numbers.
    """

    code: str
    parameter: str = ""
    severity: Severity = "warning"
    numbers: Mapping[str, Number] = field(default_factory=dict)
    kind: Kind = "translational"

    def as_data(self) -> dict[str, Any]:
        """Return what goes into JSON: ``code``, ``parameter``, ``severity``, ``numbers``."""
        return {"code": self.code, "parameter": self.parameter, "severity": self.severity, "numbers": dict(self.numbers)}


@dataclass(frozen=True)
class HeldOut:
    """Error on time blocks, or whole logs, that were not fitted: 100 ||y - y_hat|| / ||y|| one by one [%]."""

    block_errors_percent: tuple[float, ...]
    mean_percent: float
    std_percent: float
    of: str = "time blocks"

    def above(self, smallest: HeldOut) -> tuple[float, float]:
        """Return the excess over a smaller error, block by block: mean and its standard error [%]."""
        differences = np.subtract(self.block_errors_percent, smallest.block_errors_percent)
        return float(np.mean(differences)), float(np.std(differences, ddof=1)) / differences.size**0.5


T = TypeVar("T")
UNFINISHED = Diagnostic("unfinished")


def to_the_end(work: Callable[[], T]) -> tuple[T, bool]:
    """Return what short work comes to, and whether a person interrupted it: it is then done again."""
    try:
        return work(), False
    except KeyboardInterrupt:
        return work(), True


@dataclass
class BestSoFar:
    """The best of a search: of all points that were tried, and of the descents that ended."""

    at: np.ndarray | None = None
    cost: float = math.inf
    result: Any = None
    whole: bool = False

    def see(self, at: np.ndarray, cost: float) -> None:
        """Take note of a point that was tried."""
        if cost < self.cost:
            self.at, self.cost = at.copy(), cost

    def is_known(self, at: np.ndarray) -> bool:
        """Return whether a point is where the best descent ended."""
        # 0.02 in coordinates: of a typical magnitude, or of a factor e
        return self.result is not None and bool(np.all(np.abs(at - self.result.theta) < 0.02))

    def take(self, result: Any) -> None:
        """Take note of a descent that ended."""
        if self.result is None or result.cost < self.result.cost:
            self.result = result
