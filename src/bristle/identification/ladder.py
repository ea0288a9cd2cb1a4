r"""The answer of a ladder of observers: the mean of its rungs, each weighted by its precision.

.. math::
    \bar\theta = \sum_i w_i\,\theta_i, \qquad w_i \propto \exp\Bigl(-\tfrac{p}{n}\sum_j \ln s_{ij}\Bigr), \qquad
    V = \sum_i w_i\,\Bigl[V_i + \frac{d_i\,d_i^T}{1 - \sum_k w_k^2}\Bigr], \qquad d_i = \theta_i - \bar\theta

with :math:`p = 4`, and the standard errors :math:`s_{ij}` of the :math:`n` coordinates of rung :math:`i`, from the covariance

.. math:: V_i = A^{-1} \Bigl(\sum_b g_b g_b^T\Bigr) A^{-1}

with the information :math:`A` of the observer and the scores :math:`g_b` of blocks of time [1]_. A stiff observer
sees little but rounding, a loose observer drifts by unmodelled forces: their errors have different causes, and partly
cancel.

References
----------
.. [1] H. White, Econometrica 50(1), 1982. doi:10.2307/1912526
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.normal import NORMAL_95
from bristle.identification.observer import BEND, DELAY, Rung
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import scores_of

BLOCKS = 30  # of time
POWER = 4.0  # of precision: 2 for the least variance of a mean of independent rungs, many for the most precise rung alone
ALONE = 0.5  # most of the sum of squared weights that the spread is divided by


@dataclass(frozen=True)
class Ladder:
    """Rungs from the stiffest observer to the loosest, and the covariance of each, shape (coordinate, coordinate)."""

    rungs: tuple[Rung, ...]
    covariances: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, rungs: Sequence[Rung]) -> Ladder:
        """Return the ladder of some rungs."""
        return cls(tuple(rungs), tuple(map(sandwich, rungs)))

    @cached_property
    def weights(self) -> np.ndarray:
        """The weight of each rung, shape (rung,)."""
        names = self.rungs[0].solution.space.names
        friction = [name not in (DELAY, BEND) for name in names]
        variances = np.array([np.diag(covariance)[friction] for covariance in self.covariances])
        seen = np.all(variances > 0.0, axis=0)
        variances = variances[:, seen] / np.min(variances[:, seen], axis=0)
        precision = (
            np.exp(-0.5 * POWER * np.mean(np.log(variances), axis=1))
            if seen.any()
            else np.ones(len(self.rungs))
        )
        return precision / np.sum(precision)

    @property
    def best(self) -> Rung:
        """The rung of the greatest weight."""
        return self.rungs[int(np.argmax(self.weights))]

    @cached_property
    def solution(self) -> Solution:
        """The mean of the rungs."""
        return replace(
            self.best.solution,
            theta=self.weights @ np.array([rung.solution.theta for rung in self.rungs]),
        )

    @cached_property
    def covariance(self) -> np.ndarray:
        """The covariance within the rungs and between them, shape (coordinate, coordinate)."""
        within = np.tensordot(self.weights, np.array(self.covariances), axes=1)
        apart = np.array([rung.solution.theta for rung in self.rungs]) - self.solution.theta
        alone = min(float(np.sum(self.weights**2)), ALONE)
        return within + (self.weights * apart.T) @ apart / (1.0 - alone)


def sandwich(rung: Rung) -> np.ndarray:
    """Return the covariance, shape (coordinate, coordinate), from the scores of blocks of time and from measured parameters."""
    solution, parameters, count = rung.solution, rung.problem.parameters, rung.problem.settled_rows
    unsure = {
        name: fixed.half_width / NORMAL_95
        for name, fixed in parameters.fixed.items()
        if fixed.half_width
    }
    known = replace(
        rung.problem.inverse, parameters=replace(parameters, free=(*parameters.free, *unsure))
    )
    values = {**solution.values, **{name: parameters.fixed[name].value for name in unsure}}
    residual, derivatives = replace(rung.problem, inverse=known).linearised(values)
    scale = np.linalg.norm(solution.jacobian, axis=0)
    columns = solution.jacobian / np.where(scale > 0.0, scale, 1.0)
    inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True)
    scores = scores_of(columns[:count], residual[:count], BLOCKS)
    weights = np.array([expectation.weight for expectation in rung.problem.expected])
    # An expectation has a separate error.
    beforehand = columns[count:] * (rung.problem.unit * np.sqrt(weights))[:, None]
    pulls = columns.T @ (derivatives[:, len(parameters.free) :] * np.array([*unsure.values()]))
    # The product of a matrix with its transpose has no negative variance by rounding.
    half = inverse @ np.hstack([math.sqrt(BLOCKS / (BLOCKS - 1)) * scores.T, beforehand.T, pulls])
    matrix = half @ half.T
    return (
        matrix
        / np.where(scale > 0.0, scale, np.inf)[:, None]
        / np.where(scale > 0.0, scale, np.inf)
    )
