r"""Scatter of the level of friction from half-cycle to half-cycle: a prediction error with a known shape.

.. math:: e = a_k\,\varepsilon_k + w, \qquad \varepsilon_k \sim N(0, s^2), \quad w \sim N(0, \sigma^2 I)

in half-cycle :math:`k`, whose change of the prediction per relative change of the level is :math:`a_k`. Rows are whitened by

.. math:: e' = e - \Bigl[1 - \bigl(1 + s^2 |a_k|^2 / \sigma^2\bigr)^{-1/2}\Bigr] \frac{a_k a_k^T}{|a_k|^2}\, e .
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle.logs.filters import low_passed

SLOW = 25.0  # Hz: low-pass of the motion that defines half-cycles


@dataclass(frozen=True)
class LevelScatter:
    """Half-cycles: first rows, change of the prediction per relative change of the level, and share removed by whitening."""

    starts: np.ndarray
    column: np.ndarray
    share: np.ndarray

    @classmethod
    def of(
        cls, starts: np.ndarray, column: np.ndarray, scatter: float, noise: float
    ) -> LevelScatter:
        """Return the level scatter for this relative `scatter` and this noise of the prediction [m or rad]."""
        square = np.add.reduceat(column**2, starts)
        share = 1.0 - 1.0 / np.sqrt(1.0 + scatter**2 * square / noise**2)
        return cls(
            starts, column, np.divide(share, square, out=np.zeros_like(square), where=square > 0.0)
        )

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Return rows, shape (row, column), whitened of the scatter."""
        pulls = self.share[:, None] * np.add.reduceat(self.column[:, None] * rows, self.starts)
        counts = np.diff(np.append(self.starts, len(rows)))
        return rows - self.column[:, None] * np.repeat(pulls, counts, axis=0)


def starts_of(positions: Sequence[np.ndarray], settled: int, dt: float) -> np.ndarray:
    """Return the rows at which half-cycles begin, of consecutive segments without their settling rows."""
    starts, first = [np.zeros(0, dtype=int)], 0
    for position in positions:
        moving = np.diff(low_passed(position - position[0], min(SLOW, 0.2 / dt), dt), prepend=0.0)[
            settled:
        ]
        turns = np.flatnonzero(np.diff(np.signbit(moving))) + 1
        starts.append(first + np.append(0, turns))
        first += moving.size
    return np.concatenate(starts)
