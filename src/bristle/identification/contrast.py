r"""What a fit would say without its reversals, and beside a damping that differs by direction.

A filter in a channel, a delay that is hardly known, a body that sticks: around reversals a log errs by all of it, and
so does a fit. Least squares asks all rows alike; away from reversals

.. math:: \min_\delta \sum_\text{away} \left(r - J \delta - \gamma\, |\dot q|\right)^2

says by how much its parameters would be others. Where that is more than it is in replicates of the log, which have none
of those errors, it is no chance (Hausman's contrast [1]_), and the truth may lie with either; so it may where the rows
beside reversals do nothing but disturb. A parameter that rows away from reversals do not tell well stays what it is.

References
----------
.. [1] J. A. Hausman, "Specification tests in econometrics", Econometrica 46(6), 1978. doi:10.2307/1913827
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.identification.parameter_space import Solution
from bristle.logs.waves import frequency_in, waves

AS_WELL = 3.0  # times the standard error: what rows away from reversals tell of a parameter
APART = 0.02  # of a force: what the columns cannot take
SINGULAR = 1e-7  # of the largest singular value: the accuracy of a Jacobian by differences
FEWEST = 50  # rows
LEAST_TURNS, WAVE_SHARE = 3.0, 0.05  # of waves: turns over the range, share of the squares that are left over
CHANCE = 2.0  # standard deviations, by which fits to replicates may differ: no more than that is none
BETWEEN = (-0.2, 1.2)  # of the way from one fit to the other


@dataclass(frozen=True)
class Away:
    """Where nothing of how friction turns disturbs a signal."""

    rows: np.ndarray
    far: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    turns: float = 0.0

    @classmethod
    def nowhere(cls, count: int) -> Away:
        """Return that of a signal of so many rows which keeps the traces of each reversal."""
        none = np.zeros(count, dtype=bool)
        return cls(none, none, np.zeros(count), np.zeros(count))

    def beside(self, residual: np.ndarray | None = None) -> np.ndarray:
        """Return forces beside friction, shape (row, force): a damping by direction, and waves that a residual shows.

        Waves over the position that are alike in both directions are cogging.
        """
        speed, x = np.abs(self.velocity)[:, None], self.position
        if residual is None or np.count_nonzero(self.rows) < FEWEST:
            return speed
        left = np.where(self.rows, residual, 0.0)
        frequency = frequency_in(x, np.ones_like(x), left, self.turns, LEAST_TURNS)
        if frequency is None:
            return speed
        pair = waves(x, np.ones_like(x), frequency)[:, :2]
        basis = np.linalg.qr(pair[self.rows])[0]
        square = float(np.sum((basis.T @ left[self.rows]) ** 2))
        return np.hstack([speed, pair]) if square > WAVE_SHARE * float(left @ left) else speed


@dataclass(frozen=True)
class Contrast:
    """The change of coordinates by a residual, `matrix`, shape (coordinate, row); of some rows only."""

    matrix: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, solution: Solution, away: Away, free: np.ndarray, residual: np.ndarray | None = None) -> Contrast:
        """Return the contrast of a solution of which some coordinates are free, shape (coordinate,) of bool."""
        space, theta, jacobian = solution.space, solution.theta, solution.jacobian
        at_edge = np.array([name in solution.at_edge for name in space.names])
        inner = free & ~at_edge & (theta > space.low) & (theta < space.high)
        inner &= np.linalg.norm(jacobian, axis=0) > 0.0
        empty = cls(np.zeros((theta.size, 0)), np.zeros(0, dtype=int))
        if np.count_nonzero(away.rows) < FEWEST or not inner.any():
            return empty
        places, columns = np.flatnonzero(inner), jacobian[:, inner] / np.linalg.norm(jacobian[:, inner], axis=0)
        # The standard errors of all coordinates, of white noise of 1; of the forces those that are none of the columns.
        usual, forces = np.linalg.norm(np.linalg.pinv(columns, rcond=SINGULAR), axis=1), away.beside(residual)[away.rows]
        length, basis = np.linalg.norm(forces, axis=0), np.linalg.qr(columns[away.rows])[0]
        beside = forces[:, length > 0.0] / length[length > 0.0]
        beside = beside[:, np.linalg.norm(beside - basis @ (basis.T @ beside), axis=0) > APART]
        while places.size:
            inverse = np.linalg.pinv(np.hstack([columns[away.rows], beside]), rcond=SINGULAR)
            share = np.linalg.norm(inverse[: places.size], axis=1) / usual
            worst = int(np.argmax(share))
            if share[worst] <= AS_WELL:
                matrix = np.zeros((theta.size, inverse.shape[1]))
                matrix[places] = inverse[: places.size] / np.linalg.norm(jacobian[:, places], axis=0)[:, None]
                return cls(matrix, np.flatnonzero(away.rows))
            places, columns, usual = (np.delete(part, worst, axis=-1) for part in (places, columns, usual))
        return empty

    @property
    def determined(self) -> np.ndarray:
        """Which coordinates rows away from reversals tell, shape (coordinate,) of bool."""
        return np.asarray(np.any(self.matrix != 0.0, axis=1))

    def change(self, residual: np.ndarray) -> np.ndarray:
        """Return by how much the other fit lies beside one that leaves this residual, shape (coordinate,)."""
        return self.matrix @ residual[self.rows]


def between(change: np.ndarray, usual: np.ndarray, errors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return how far draws move towards the other fit, shape (draw, coordinate).

    `usual` are the changes in fits to replicates and `errors` those of the fits, in pairs, of the same shape. Where the
    other fit is the surer one of replicates, draws go all the way between both; else as far as chance does not.
    """
    beyond, variance = change - np.mean(usual, axis=0), np.var(usual, axis=0)
    square = np.maximum(beyond**2, np.finfo(float).tiny)
    clear = np.sqrt(np.maximum(1.0 - CHANCE**2 * variance / square, 0.0))
    surer = np.var(errors + usual, axis=0) < np.var(errors, axis=0)
    low, high = BETWEEN
    share = rng.uniform(low, high, len(usual) // 2 + 1)
    shares = np.stack([share, low + high - share], axis=1).ravel()[: len(usual)]
    return shares[:, None] * np.where(surer, change - usual, clear * beyond)
