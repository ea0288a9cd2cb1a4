r"""Half-cycles of a log, and how much friction differs from one to the next.

Friction that has been sliding one way is not quite the same the next time: its level scatters from reversal to
reversal by a few percent. It is the same within a half-cycle, so that no number of samples averages it out.

With the force :math:`F(c)` of a model whose forces are all scaled by :math:`c`, the scale of a half-cycle `k` is

.. math:: \hat c_k = 1 + \frac{s_k \cdot r_k}{s_k \cdot s_k}, \qquad s = \frac{\partial F}{\partial c}

from the residual `r` there. The root mean square of :math:`\hat c_k - 1`, weighted by :math:`s_k \cdot s_k`, is what is
seen of the scatter; a fit takes part of it into its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from bristle.identification.problem import Problem
from bristle.identification.regression import Regression
from bristle.identification.resampling.levels import scaled

__all__ = ["Groups", "HalfCycles", "level_slope", "scatter_seen", "turns_of"]

STEPS = 2.0  # of the encoder
DEVIATIONS = 8.0  # of the noise of the position: what a body at rest does not go beyond
NUDGE = 1e-3


@dataclass(frozen=True)
class Groups:
    """Consecutive rows that belong together.

    Parameters
    ----------
    of_rows : ndarray, shape (row,)
        Number of the group of each row, never falling.
    """

    of_rows: np.ndarray

    @property
    def count(self) -> int:
        """Number of groups with rows in them."""
        return int(self.index[-1]) + 1

    @cached_property
    def index(self) -> np.ndarray:
        """Number of the group of each row, counted among those that have any."""
        return np.unique(self.of_rows, return_inverse=True)[1]

    @cached_property
    def parts(self) -> tuple[slice, ...]:
        """The rows of each group."""
        return tuple(slice(*one) for one in pairwise([*self._first.tolist(), self.of_rows.size]))

    def summed(self, rows: np.ndarray) -> np.ndarray:
        """Return the sum of a signal over the rows of each group, shape (group, ...)."""
        return np.add.reduceat(rows, self._first, axis=0)

    @cached_property
    def _first(self) -> np.ndarray:
        return np.flatnonzero(np.diff(self.index, prepend=-1))


@dataclass(frozen=True)
class HalfCycles:
    """Where the direction of a motion really changes: not where noise or a step of the encoder turns it.

    Parameters
    ----------
    regression : Regression
        The log.
    """

    regression: Regression

    @cached_property
    def starts(self) -> tuple[tuple[int, ...], ...]:
        """First sample of each half-cycle of each stretch; the first one is 0."""
        least = max(STEPS * self.regression.resolution, DEVIATIONS * self.regression.noise)
        return tuple(
            (0, *turns_of(one.position, [k for there, k in self.regression.reversals if there == number], least))
            for number, one in enumerate(self.regression.stretches)
        )

    @cached_property
    def groups(self) -> Groups:
        """The rows of each half-cycle, counted through all stretches."""
        parts, before = [], 0
        for stretch, starts in zip(self.regression.stretches, self.starts, strict=True):
            parts.append(before + np.searchsorted(starts, np.arange(stretch.velocity.size), side="right") - 1)
            before += len(starts)
        return Groups(self.regression.sampled(parts))


def turns_of(position: np.ndarray, reversals: Sequence[int], least: float) -> list[int]:
    """Return those reversals between which the body moves by at least so much.

    Parameters
    ----------
    position : ndarray, shape (sample,)
        The motion [m or rad].
    reversals : sequence of int
        Samples at which the direction may have changed.
    least : float
        The smallest way that counts [m or rad].
    """
    kept: list[int] = []
    before, candidate = 0, None
    for point in [*reversals, position.size - 1]:
        if candidate is None:
            candidate = point if abs(position[point] - position[before]) >= least else None
            continue
        way, back = position[candidate] - position[before], position[point] - position[candidate]
        if way * back > 0.0:
            candidate = point
        elif abs(back) >= least:
            kept.append(candidate)
            before, candidate = candidate, point
    return kept


def level_slope(problem: Problem, values: Mapping[str, float]) -> np.ndarray:
    """Return by how much the effort of each row rises with the level of friction, dF/dc [N or N*m], shape (row,)."""
    nudged = problem.friction(scaled(problem.unknowns.component, values, 1.0 + NUDGE))
    return (nudged - problem.friction(values)) / NUDGE


def scatter_seen(cycles: Groups, slope: np.ndarray, residual: np.ndarray) -> float:
    """Return the standard deviation of the level of friction from half-cycle to half-cycle, as a residual shows it.

    Parameters
    ----------
    cycles : Groups
        Half-cycles of the log.
    slope, residual : ndarray, shape (row,)
        What `level_slope` returns; measured minus predicted effort [N or N*m].
    """
    weight, along = cycles.summed(slope * slope), cycles.summed(slope * residual)
    whole = float(np.sum(weight))
    if whole == 0.0:
        return 0.0
    excess = np.divide(along, weight, out=np.zeros_like(along), where=weight > 0.0)
    return float(np.sum(weight * excess * excess) / whole) ** 0.5
