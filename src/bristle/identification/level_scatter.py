r"""Scatter of the level of friction from half-cycle to half-cycle: an error of prediction that has a shape.

.. math:: e = a_k\,\varepsilon_k + w, \qquad \varepsilon_k \sim N(0, s^2), \quad w \sim N(0, \sigma^2 I)

in half-cycle :math:`k`, whose change of the prediction per relative change of the level is :math:`a_k`. Rows are whitened by

.. math:: e' = e - \Bigl[1 - \bigl(1 + s^2 |a_k|^2 / \sigma^2\bigr)^{-1/2}\Bigr] \frac{a_k a_k^T}{|a_k|^2}\, e .
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle.logs.filters import low_passed

SLOW = 25.0  # Hz: of the motion that says where a half-cycle begins


@dataclass(frozen=True)
class LevelScatter:
    """Rows of half-cycles: where each begins, the change of the prediction per relative change of the level, how much of it is left out."""

    starts: np.ndarray
    column: np.ndarray
    share: np.ndarray

    @classmethod
    def of(cls, starts: np.ndarray, column: np.ndarray, scatter: float, noise: float) -> LevelScatter:
        """Return the scatter of a level by this share, beside so much noise of the prediction [m or rad]."""
        square = np.add.reduceat(column**2, starts)
        share = 1.0 - 1.0 / np.sqrt(1.0 + scatter**2 * square / noise**2)
        return cls(starts, column, np.divide(share, square, out=np.zeros_like(square), where=square > 0.0))

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Return rows, shape (row, column), without what the scatter makes of them."""
        pulls = self.share[:, None] * np.add.reduceat(self.column[:, None] * rows, self.starts)
        counts = np.diff(np.append(self.starts, len(rows)))
        return rows - self.column[:, None] * np.repeat(pulls, counts, axis=0)


def starts_of(positions: Sequence[np.ndarray], settled: int, dt: float) -> np.ndarray:
    """Return the rows at which half-cycles begin, of segments that follow each other without their first, settling, rows."""
    starts, first = [np.zeros(0, dtype=int)], 0
    for position in positions:
        moving = np.diff(low_passed(position - position[0], min(SLOW, 0.2 / dt), dt), prepend=0.0)[settled:]
        turns = np.flatnonzero(np.diff(np.signbit(moving))) + 1
        starts.append(first + np.append(0, turns))
        first += moving.size
    return np.concatenate(starts)
