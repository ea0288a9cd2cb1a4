"""The interface of an estimator, the only interface that search, bootstrap, judgement, validation and ranking use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import apart_from
from bristle.identification.dataset import Dataset
from bristle.identification.half_cycles import Disturbance, Groups
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import ParameterSet
from bristle.identification.settings import Settings
from bristle.logs.waves import frequency_in, waves

SINGULAR = 1e-7  # of the largest singular value: the accuracy of a Jacobian by differences
FEWEST = 50  # rows
LEAST_TURNS, WAVE_SHARE = 3.0, 0.05  # of waves: turns over the range, share of the squared residual
CHANCE = 2.0  # standard deviations of fits to replicates: a smaller change is not significant
BETWEEN = (-0.2, 1.2)  # range of the share of the way between both fits


@dataclass(frozen=True)
class Away:
    """Rows without the influence of friction reversals."""

    rows: np.ndarray
    far: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    turns: float = 0.0

    @classmethod
    def nowhere(cls, count: int) -> Away:
        """Return the empty selection, for a signal in which reversals affect all later rows."""
        none = np.zeros(count, dtype=bool)
        return cls(none, none, np.zeros(count), np.zeros(count))

    def beside(self, residual: np.ndarray | None = None) -> np.ndarray:
        """Return forces additional to friction, shape (row, force): directional damping, and the cogging in a residual."""
        speed, x = np.abs(self.velocity)[:, None], self.position
        if residual is None or np.count_nonzero(self.rows) < FEWEST:
            return speed
        left = np.where(self.rows, residual, 0.0)
        frequency = frequency_in(x, None, left, self.turns, LEAST_TURNS)
        if frequency is None:
            return speed
        pair = waves(x, None, frequency)
        basis = np.linalg.qr(pair[self.rows])[0]
        square = float(np.sum((basis.T @ left[self.rows]) ** 2))
        return np.hstack([speed, pair]) if square > WAVE_SHARE * float(left @ left) else speed


@dataclass(frozen=True)
class Contrast:
    r"""The difference between a fit and a fit without reversals, with directional damping.

    A filter in a channel, an uncertain delay or stiction cause errors around reversals, and bias a fit. Least squares
    uses all rows; away from reversals

    .. math:: \min_\delta \sum_\text{away} \left(r - J \delta - \gamma\, |\dot q|\right)^2

    is the change of its parameters. Replicates of the log do not have those errors. If the change exceeds that in
    replicates, it is significant (Hausman's contrast, Econometrica 46(6), 1978, doi:10.2307/1913827), and the truth
    may lie with either fit. Parameters that rows away from reversals do not determine are not changed.

    `matrix`, shape (coordinate, row), maps the residual of the selected rows to the change of coordinates.
    """

    matrix: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, solution: Solution, away: Away, residual: np.ndarray | None = None) -> Contrast:
        """Return the contrast of a solution."""
        space, theta, jacobian = solution.space, solution.theta, solution.jacobian
        at_edge = np.array([name in solution.at_edge for name in space.names])
        inner = ~at_edge & (theta > space.low) & (theta < space.high)
        inner &= np.linalg.norm(jacobian, axis=0) > 0.0
        empty = cls(np.zeros((theta.size, 0)), np.zeros(0, dtype=int))
        if np.count_nonzero(away.rows) < FEWEST or not inner.any():
            return empty
        places, columns = (
            np.flatnonzero(inner),
            jacobian[:, inner] / np.linalg.norm(jacobian[:, inner], axis=0),
        )
        # The standard errors of all coordinates for unit white noise; only forces that the columns do not contain.
        usual, forces = (
            np.linalg.norm(np.linalg.pinv(columns, rcond=SINGULAR), axis=1),
            away.beside(residual)[away.rows],
        )
        length, basis = np.linalg.norm(forces, axis=0), np.linalg.qr(columns[away.rows])[0]
        beside = forces[:, length > 0.0] / length[length > 0.0]
        # Share of a force outside the columns.
        beside = beside[:, np.linalg.norm(apart_from(basis, beside), axis=0) > 0.02]
        while places.size:
            inverse = np.linalg.pinv(np.hstack([columns[away.rows], beside]), rcond=SINGULAR)
            share = np.linalg.norm(inverse[: places.size], axis=1) / usual
            worst = int(np.argmax(share))
            # Times the standard error: limit for parameters determined away from reversals.
            if share[worst] <= 3.0:
                matrix = np.zeros((theta.size, inverse.shape[1]))
                matrix[places] = (
                    inverse[: places.size] / np.linalg.norm(jacobian[:, places], axis=0)[:, None]
                )
                return cls(matrix, np.flatnonzero(away.rows))
            places, columns, usual = (
                np.delete(part, worst, axis=-1) for part in (places, columns, usual)
            )
        return empty

    @property
    def determined(self) -> np.ndarray:
        """Mask of the coordinates that rows away from reversals determine, shape (coordinate,) of bool."""
        return np.asarray(np.any(self.matrix != 0.0, axis=1))

    def change(self, residual: np.ndarray) -> np.ndarray:
        """Return the difference of the other fit for this residual, shape (coordinate,)."""
        return self.matrix @ residual[self.rows]


def between(
    change: np.ndarray, usual: np.ndarray, errors: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Return the shifts of draws towards the other fit, shape (draw, coordinate).

    `usual` are the changes in fits to replicates, `errors` are the errors of these fits, both in pairs and of the
    same shape. If the other fit is more certain in replicates, draws spread over the whole difference; else over its
    significant part.
    """
    beyond, variance = change - np.mean(usual, axis=0), np.var(usual, axis=0)
    square = np.maximum(beyond**2, np.finfo(float).tiny)
    clear = np.sqrt(np.maximum(1.0 - CHANCE**2 * variance / square, 0.0))
    surer = np.var(errors + usual, axis=0) < np.var(errors, axis=0)
    low, high = BETWEEN
    share = rng.uniform(low, high, len(usual) // 2 + 1)
    shares = np.stack([share, low + high - share], axis=1).ravel()[: len(usual)]
    return shares[:, None] * np.where(surer, change - usual, clear * beyond)


class Residual(Protocol):
    """The residual of a signal."""

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus predicted signal, shape (row,), from the free parameters."""
        ...


class Fold(NamedTuple):
    """Masks of a held-out part: held-out rows of the signal, fitted rows, held-out rows of the data set, shape (row,) of bool."""

    held_out: np.ndarray
    fitted: np.ndarray
    of_dataset: np.ndarray


class Replicates(Protocol):
    """Simulated records of the same axis with the fitted model as the truth."""

    @property
    def doubt(self) -> float:
        """Standard error of the mean offset of fits, as a share of the offset in replicates."""
        ...

    def draw(
        self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0
    ) -> Residual:
        """Return the same problem on a new random log, or on its mirror image with reversed disturbances (-1)."""
        ...

    def made_with(self, values: Mapping[str, float]) -> Replicates:
        """Return replicates of the same model with other parameters; the residual of the fit is kept."""
        ...


def has_own(problem: Residual, base: type[Residual], *methods: str) -> bool:
    """Return whether the class of a problem overrides any of these methods of its base."""
    return any(getattr(type(problem), name) is not getattr(base, name) for name in methods)


class Sought(Residual, Protocol):
    """The interface of a problem for a search."""

    @property
    def parameters(self) -> ParameterSet:
        """The free and fixed parameters."""
        ...

    @cached_property
    def measured(self) -> np.ndarray:
        """The signal, shape (row,)."""
        ...

    def excerpt(self) -> Sought | None:
        """Return the problem for a part of a long log, for the start of a search, or None."""
        ...

    def linearised(self, free: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray | None]:
        """Return the residual and the derivative of the signal, shape (row, free), or None if only differences are available."""
        ...


class Problem(Sought, Protocol):
    """The interface of a problem for least squares and resampling."""

    @property
    def dataset(self) -> Dataset:
        """The log as rows of inverse dynamics."""
        ...

    @property
    def row_time(self) -> float:
        """Time from row to row of the signal [s]."""
        ...

    @cached_property
    def half_cycles(self) -> Groups:
        """The rows of each half-cycle."""
        ...

    @cached_property
    def away(self) -> Away:
        """The rows without the influence of friction reversals."""
        ...

    def errors(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the errors of the signal and further results, by their names in `Fit`."""
        ...

    def effort_residual(self, free: Mapping[str, float], residual: np.ndarray) -> np.ndarray:
        """Return measured minus predicted effort of each row of the data set [N or N*m] for this residual."""
        ...

    def friction_slope(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the derivative of the signal of each row by the relative friction level, from all parameters."""
        ...

    def replicates(
        self, values: Mapping[str, float], slope: np.ndarray, residual: np.ndarray
    ) -> Replicates:
        """Return the replicates of the fitted model; `slope` and `residual` belong to these parameters."""
        ...

    def folds(self, count: int, settings: Settings | None = None) -> tuple[str, list[Fold]]:
        """Return the name of the parts of the logs, and the parts to hold out in turn; with `settings`, reject logs that are too short."""
        ...


CLUSTERS = 40


@dataclass(frozen=True)
class Covariance:
    """Standard errors of the free parameters, in their order."""

    std: np.ndarray
    robust_std: np.ndarray
    correlation: np.ndarray
    condition_number: float


def covariance_of(
    solution: Solution, residual: np.ndarray, errors: Sequence[np.ndarray] = ()
) -> Covariance:
    """Return the standard errors of a solution with this residual [N or N*m], and with systematic `errors` of all rows."""
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
    # The scatter of the scores, summed over blocks of consecutive rows.
    rows, count = residual.size, min(CLUSTERS, residual.size)
    sums = scores_of(columns, residual, count)
    # Correction for the degrees of freedom of the fit.
    factor = count / max(count - 1, 1) * (rows - 1) / max(rows - len(names), 1)
    robust = inverse @ (factor * (sums.T @ sums) + pulls @ pulls.T) @ inverse
    # Columns in a direction without effect on the rows, and columns without any effect.
    blind = np.any(np.abs(directions[~regular]) > 1e-3, axis=0)
    derivative = solution.derivative[:, inner]
    back, without_effect = derivative[:, sensitive] / scale[sensitive], derivative[:, ~sensitive]
    covariance = back @ plain @ back.T
    lost = (back[:, blind] != 0.0).any(axis=1) | (without_effect != 0.0).any(axis=1)
    std, robust_std = np.where(
        lost, np.inf, _root(np.stack([np.diag(covariance), np.diag(back @ robust @ back.T)]))
    )
    std[~inner], robust_std[~inner] = np.nan, np.nan
    usable = np.isfinite(std) & (std > 0.0)
    correlation = np.full((len(names), len(names)), np.nan)
    correlation[np.ix_(usable, usable)] = covariance[np.ix_(usable, usable)] / np.outer(
        std[usable], std[usable]
    )
    condition = (
        float(singular[0] / max(singular[-1], np.finfo(float).tiny)) if singular.size else 1.0
    )
    return Covariance(std, robust_std, correlation, condition)


def scores_of(columns: np.ndarray, residual: np.ndarray, blocks: int) -> np.ndarray:
    """Return the scores of columns, shape (row, column), summed over blocks of consecutive rows, shape (block, column)."""
    starts = np.linspace(0, residual.size, blocks, endpoint=False).astype(int)
    return np.add.reduceat(columns * residual[:, None], starts, axis=0)


def _root(variance: np.ndarray) -> np.ndarray:
    """Return the standard error of each variance; infinite if rounding made the variance negative."""
    return np.sqrt(np.where(variance < 0.0, np.inf, variance))
