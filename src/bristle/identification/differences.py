"""The Jacobian of a residual that takes a simulation: by differences, on all cores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from bristle.core.cores import Abreast

__all__ = ["STEP", "Differences"]

STEP = 1e-5  # of a coordinate, or of 1: a stick or a reversal that moves by a step of the integration is far below


@dataclass
class Differences:
    """A residual whose last value is remembered, with its Jacobian.

    Parameters
    ----------
    residual : callable
        Returns the residual at some coordinates, shape (row,); it is called from several threads.
    high : ndarray, shape (coordinate,)
        Upper bounds, beyond which no difference is taken.
    step : float
        Of a coordinate, or of 1.
    """

    residual: Callable[[np.ndarray], np.ndarray]
    high: np.ndarray
    step: float = STEP
    _at: np.ndarray | None = None
    _last: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the residual."""
        if self._at is None or not np.array_equal(x, self._at):
            self._last, self._at = self.residual(x), x.copy()
        return self._last

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivative of the residual, shape (row, coordinate)."""
        here = self(x)

        def column(index: int) -> np.ndarray:
            step = self.step * max(1.0, abs(x[index]))
            there = x.copy()
            there[index] += -step if x[index] + step > self.high[index] else step
            return (self.residual(there) - here) / (there[index] - x[index])

        with Abreast() as pool:
            return np.stack(list(pool.map(column, range(x.size))), axis=1)
