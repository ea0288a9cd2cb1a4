"""The Jacobian of a residual that takes a simulation: by differences, all columns at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from bristle.core.cores import Abreast

__all__ = ["STEP", "Differences", "abreast"]

A = TypeVar("A")
B = TypeVar("B")

STEP = 1e-5  # of a coordinate, or of 1: a stick or a reversal that moves by a step of the integration is far below


def abreast(function: Callable[[A], B]) -> Callable[[Sequence[A]], list[B]]:
    """Return what calls a function with each of several values, on all cores."""

    def together(values: Sequence[A]) -> list[B]:
        if len(values) == 1:
            return [function(values[0])]
        with Abreast() as pool:
            return list(pool.map(function, values))

    return together


@dataclass
class Differences:
    """A residual whose last value is remembered, with its Jacobian.

    Parameters
    ----------
    residuals : callable
        Returns the residual at each of several coordinates, shape (row,) each.
    high : ndarray, shape (coordinate,)
        Upper bounds, beyond which no difference is taken.
    step : float
        Of a coordinate, or of 1.
    """

    residuals: Callable[[Sequence[np.ndarray]], Sequence[np.ndarray]]
    high: np.ndarray
    step: float = STEP
    _at: np.ndarray | None = None
    _last: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the residual."""
        if self._at is None or not np.array_equal(x, self._at):
            self._last, self._at = self.residuals([x])[0], x.copy()
        return self._last

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivative of the residual, shape (row, coordinate)."""
        here = self(x)
        steps = self.step * np.maximum(1.0, np.abs(x))
        there = x + np.diag(np.where(x + steps > self.high, -steps, steps))
        columns = zip(self.residuals(list(there)), there.diagonal() - x, strict=True)
        return np.stack([(residual - here) / step for residual, step in columns], axis=1)
