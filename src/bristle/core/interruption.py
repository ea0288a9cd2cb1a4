"""Long work that a person interrupts: the best found until then is kept, and marked unfinished."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from bristle.core.diagnostic import Diagnostic

__all__ = ["UNFINISHED", "BestSoFar", "to_the_end"]

T = TypeVar("T")
NEARNESS = 0.02  # in coordinates: of a typical magnitude, or of a factor e
UNFINISHED = Diagnostic("unfinished")


def to_the_end(work: Callable[[], T]) -> tuple[T, bool]:
    """Return what short work comes to, and whether a person interrupted it: it is then done again.

    What took long lies before it, and would be lost with it.
    """
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
        return self.result is not None and bool(np.all(np.abs(at - self.result.theta) < NEARNESS))

    def take(self, result: Any) -> None:
        """Take note of a descent that ended."""
        if self.result is None or result.cost < self.result.cost:
            self.result = result
