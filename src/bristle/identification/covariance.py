r"""How sure a fit is of its parameters, and whether the log determines them at all.

The standard errors are those of least squares, :math:`s^2 (J^T J)^{-1}`, which take the residuals for independent.
They are not where the model misses something. Intervals, and whether a parameter counts as identified, therefore rest
on the larger of these and the errors that hold for residuals correlated over time (clustered by block [1]_), to which
those of the delay, and of what was found with it before the fit, are added. The
jackknife over half-cycles, a cross-check of the bootstrap, takes nothing for known but the model.

References
----------
.. [1] J. G. MacKinnon, M. O. Nielsen, M. D. Webb, "Cluster-robust inference: a guide to empirical practice",
   Journal of Econometrics 232(2), 2023. doi:10.1016/j.jeconom.2022.04.001
.. [2] G. M. Ljung, G. E. P. Box, "On a measure of lack of fit in time series models", Biometrika 65(2), 1978.
   doi:10.1093/biomet/65.2.297
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle.identification.half_cycles import Groups
from bristle.identification.parameter_space import Solution
from bristle.identification.settings import DEFAULT, Settings

__all__ = ["Covariance", "Jackknife", "covariance_of", "is_white"]

CLUSTERS = 40
FEWEST_CYCLES = 5  # half-cycles of a jackknife
RANK = 1e-12  # of the largest singular value of its equations
SINGULAR = 1e-7  # of the largest singular value: the accuracy of a Jacobian by differences


@dataclass(frozen=True)
class Covariance:
    """Standard errors of the free parameters, in their order."""

    std: np.ndarray
    robust_std: np.ndarray
    correlation: np.ndarray
    condition_number: float


def covariance_of(solution: Solution, residual: np.ndarray, errors: Sequence[np.ndarray] = ()) -> Covariance:
    """Return the standard errors of a solution with this residual [N or N*m], shape (row,).

    The `errors` are further ones of the rows, each of one standard error and of all rows at once, as that of a delay.
    """
    names = list(solution.space.reported)
    inner = np.array([name not in solution.at_edge for name in names], dtype=bool)
    jacobian = solution.jacobian[:, inner]
    scale = np.linalg.norm(jacobian, axis=0)
    sensitive = scale > 0.0
    columns = jacobian[:, sensitive] / scale[sensitive]
    _, singular, directions = np.linalg.svd(columns, full_matrices=False)
    regular = singular > SINGULAR * np.max(singular, initial=0.0)
    inverse = (directions[regular].T / singular[regular] ** 2) @ directions[regular]
    variance = float(residual @ residual) / max(residual.size - len(names), 1)
    plain = variance * inverse
    pulls = columns.T @ np.column_stack([*errors, np.zeros_like(residual)])
    robust = inverse @ (_scatter(columns * residual[:, None], len(names)) + pulls @ pulls.T) @ inverse
    # Columns that take part in a direction that the rows do not see, and those that no row sees.
    blind = np.any(np.abs(directions[~regular]) > 1e-3, axis=0)
    derivative = solution.derivative[:, inner]
    back, without_effect = derivative[:, sensitive] / scale[sensitive], derivative[:, ~sensitive]
    covariance = back @ plain @ back.T
    lost = (back[:, blind] != 0.0).any(axis=1) | (without_effect != 0.0).any(axis=1)
    std = np.where(lost, np.inf, _root(np.diag(covariance)))
    robust_std = np.where(lost, np.inf, _root(np.diag(back @ robust @ back.T)))
    std[~inner], robust_std[~inner] = np.nan, np.nan
    usable = np.isfinite(std) & (std > 0.0)
    correlation = np.full((len(names), len(names)), np.nan)
    correlation[np.ix_(usable, usable)] = covariance[np.ix_(usable, usable)] / np.outer(std[usable], std[usable])
    condition = float(singular[0] / max(singular[-1], np.finfo(float).tiny)) if singular.size else 1.0
    return Covariance(std, robust_std, correlation, condition)


def _root(variance: np.ndarray) -> np.ndarray:
    """Return the standard error of each variance; none is known where rounding left less than nothing of it."""
    return np.sqrt(np.where(variance < 0.0, np.inf, variance))


def _scatter(scores: np.ndarray, fitted: int) -> np.ndarray:
    """Return the scatter of the scores summed over blocks of consecutive rows, shape (column, column)."""
    rows = scores.shape[0]
    count = min(CLUSTERS, rows)
    starts = np.linspace(0, rows, count, endpoint=False).astype(int)
    sums = np.add.reduceat(scores, starts, axis=0)
    # Makes up for the freedom that the fit took from the residuals.
    factor = count / max(count - 1, 1) * (rows - 1) / max(rows - fitted, 1)
    return factor * (sums.T @ sums)


@dataclass(frozen=True)
class Jackknife:
    r"""Standard errors of parameters by leaving out one half-cycle after the other.

    Without half-cycle `k` a solution moves, to first order, by

    .. math:: \delta_k = -\left(J^T J - J_k^T J_k\right)^{-1} J_k^T r_k

    and :math:`\tfrac{n - 1}{n} \sum_k (\delta_k - \bar\delta)^2` is the variance. What is common to all half-cycles, as
    the error of the encoder is, it does not see. It takes any residual of all rows. With fewer than five half-cycles
    it tells nothing, and of `names` of reported parameters nothing where they are on an edge.
    """

    names: tuple[str, ...]
    on_edge: frozenset[str]
    cycles: Groups
    columns: np.ndarray
    moved: np.ndarray

    @classmethod
    def of(cls, solution: Solution, cycles: Groups) -> Jackknife:
        """Return the jackknife of a solution."""
        space, theta, jacobian = solution.space, solution.theta, solution.jacobian
        inner = (theta > space.low) & (theta < space.high) & (np.linalg.norm(jacobian, axis=0) > 0.0)
        scale = np.linalg.norm(jacobian[:, inner], axis=0)
        columns = jacobian[:, inner] / scale
        if cycles.count < FEWEST_CYCLES:
            return cls((), frozenset(), cycles, columns, np.zeros((cycles.count, 0, columns.shape[1])))
        parts = np.stack([part.T @ part for part in cycles.split(columns)])
        inverse = np.linalg.pinv(np.sum(parts, axis=0) - parts, rcond=RANK, hermitian=True)
        return cls(space.reported, frozenset(solution.at_edge), cycles, columns, -(solution.derivative[:, inner] / scale) @ inverse)

    def named(self, std: np.ndarray) -> dict[str, float]:
        """Return standard errors by the name of the parameter."""
        return {name: s for name, s in zip(self.names, std.tolist(), strict=True) if name not in self.on_edge}

    def std(self, residual: np.ndarray) -> np.ndarray:
        """Return the standard error of each parameter [SI], of a residual of all rows."""
        pulls = self.cycles.summed(self.columns * residual[:, None])
        changes = np.einsum("krc,kc->kr", self.moved, pulls)
        count = len(changes)
        return np.sqrt((count - 1) / count * np.sum((changes - changes.mean(axis=0)) ** 2, axis=0))


def is_white(residual: np.ndarray, settings: Settings = DEFAULT) -> bool:
    """Return whether the autocorrelation of a residual, shape (row,), is that of independent errors [2]_."""
    from scipy.stats import chi2

    most = int(settings.white_lags)
    centred = residual - np.mean(residual)
    power, count = float(centred @ centred), centred.size
    if power == 0.0 or count <= 2 * most:
        return False
    lags = np.arange(1, most + 1)
    correlation = np.array([float(centred[lag:] @ centred[:-lag]) for lag in lags]) / power
    return bool(count * (count + 2) * np.sum(correlation**2 / (count - lags)) < chi2.ppf(settings.white_level, most))
