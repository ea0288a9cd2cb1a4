"""Parametric bootstrap: intervals from fits to logs that the fitted model made.

The error of a fit is that of the same fit to a log that the fitted model made, a replicate. Errors are turned around:
where the fits to replicates come out high, so did the first one (basic interval [1]_); those of a parameter that is
sought in its logarithm are factors. A parameter on an edge of its range has the percentiles themselves. Replicates come
in pairs, the second one with all disturbances of the first reversed (antithetic draws [1]_): what chance does to the
middle of a few hundred fits then cancels, and the bias is left.

The scatter that replicates show, over the one that they were made with, gives the interval of the scatter, and how far
that of a replicate may be from the estimate.

References
----------
.. [1] A. C. Davison, D. V. Hinkley, "Bootstrap Methods and their Application", Cambridge University Press, 1997.
   doi:10.1017/CBO9780511802843
.. [2] M. S. Bartlett, D. G. Kendall, "The statistical analysis of variance-heterogeneity and the logarithmic
   transformation", Supplement to the Journal of the Royal Statistical Society 8(1), 1946. doi:10.2307/2983618
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.cores import Abreast
from bristle.core.normal import DEVIATION_OVER_MEDIAN
from bristle.identification.disturbance import Disturbance, disturbance_of
from bristle.identification.half_cycles import Groups, scatter_in
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import Problem, Replicates
from bristle.identification.refit import Refit
from bristle.identification.result import Scatter

__all__ = ["CERTAIN", "Bootstrap", "ChiSquare", "basic_interval", "bootstrap"]

PILOT = 32  # draws by which the scatter, and then what the model lacks, are set right
SEED = 20_261_120
TAIL = 2.5  # percent
FEWEST_CYCLES = 4  # for a scatter
EDGE = 3.0  # standard deviations beyond which an estimated square went astray


@dataclass(frozen=True)
class Bootstrap:
    """Fits to logs drawn anew, by `disturbance`, of the log with this `solution`.

    Parameters
    ----------
    draws : ndarray, shape (draw, reported and curve)
        What was fitted to each replicate, as the space reports it [SI]; `members` is the same as the model takes it.
    scatter : Scatter
        From reversal to reversal.
    unexplained : float
        Root mean square of the part of the residual that neither noise, encoder nor scatter explain.
    residual, slope : ndarray, shape (row,)
        What the fit left over of the signal, and by how much that rises with the level of friction.
    """

    solution: Solution
    draws: np.ndarray
    members: tuple[Mapping[str, Any], ...]
    disturbance: Disturbance
    scatter: Scatter
    unexplained: float
    residual: np.ndarray
    slope: np.ndarray

    @property
    def reported(self) -> tuple[str, ...]:
        """The parameters that draws tell."""
        return self.solution.space.reported

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of the draws of each parameter [SI]."""
        return dict(zip(self.reported, np.std(self.draws, axis=0, ddof=1).tolist(), strict=False))

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of a parameter [SI]."""
        column, space = self.reported.index(name), self.solution.space
        if name in self.solution.at_edge:
            return _percentiles(self.draws[:, column])
        estimate = space.numbers(self.solution.theta)[column]
        return basic_interval(self.draws[:, column], estimate, logarithmic=name in space.logarithmic)

    @property
    def curve(self) -> tuple[tuple[float, float, float, float], ...]:
        """The virgin curve: displacement [m or rad], force [N or N*m], and the ends of its 95 % interval."""
        first, space = len(self.reported), self.solution.space
        forces, draws = space.numbers(self.solution.theta)[first:], self.draws[:, first:].T
        return tuple(
            (x, float(force), *basic_interval(drawn, force, logarithmic=False))
            for x, force, drawn in zip(space.curve, forces, draws, strict=True)
        )


def _percentiles(draws: np.ndarray) -> tuple[float, float]:
    low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
    return float(low), float(high)


def basic_interval(draws: np.ndarray, estimate: float, *, logarithmic: bool) -> tuple[float, float]:
    """Return the 95 % interval of an estimate from estimates of replicates, shape (draw,), whose truth it is."""
    if logarithmic:
        low, high = basic_interval(np.log(draws), float(np.log(estimate)), logarithmic=False)
        return float(np.exp(low)), float(np.exp(high))
    low, high = _percentiles(draws)
    return float(2.0 * estimate - high), float(2.0 * estimate - low)


def bootstrap(
    problem: Problem, solution: Solution, count: int, *, free: np.ndarray | None = None, linear: bool = False,
    report: Callable[[float], None] = lambda share: None,
) -> Bootstrap:  # fmt: skip
    """Return fits to `count` replicates of a log, of the `free` coordinates.

    They may be taken for `linear` around the solution; `report` is told the share of the work done.
    """
    free = np.ones(len(solution.space.names), dtype=bool) if free is None else free
    values, cycles = problem.parameters.complete(solution.values), problem.half_cycles
    residual, slope = problem.residual(solution.values), problem.friction_slope(values)
    visible = scatter_in(cycles, slope, residual) if cycles.count >= FEWEST_CYCLES else 0.0
    fits = _Fits(problem.replicates(values, slope, residual), disturbance_of(problem.dataset, visible),
                 Refit(solution, free, linear=linear), cycles, slope)  # fmt: skip
    rng = np.random.SeedSequence(SEED)
    with Abreast() as pool:
        # A fit takes part of the scatter into its parameters: what is visible of it is less than there is.
        pilot = _squares(pool.map(fits.fit, rng.spawn(PILOT)))
        scatter = visible * visible / pilot.mean**0.5 if pilot.mean > 0.0 else 0.0
        fits = fits.disturbed(scatter=scatter)
        square, pilots = float(np.mean(residual**2)), pool.map(fits.fit, rng.spawn(PILOT))
        lacking = max(square - float(np.mean([fit.square for fit in pilots])), 0.0)
        fits = fits.disturbed(unexplained=(lacking / square) ** 0.5 if square > 0.0 else 0.0)
        fits, drawn = replace(fits, squares=pilot), []
        for pair in pool.map(fits.pair, rng.spawn(-(-count // 2))):
            drawn += pair
            report(min(len(drawn) / count, 1.0))
    squares, drawn = _squares(drawn), drawn[:count]
    low, high = (scatter / squares.deviation(share) for share in (1.0 - 0.01 * TAIL, 0.01 * TAIL))
    return Bootstrap(
        solution, np.array([fit.numbers for fit in drawn]), tuple(fit.values for fit in drawn), fits.disturbance,
        Scatter(scatter, low, high), lacking**0.5, residual, slope,
    )  # fmt: skip


class ChiSquare(NamedTuple):
    r"""Squares of standard deviations that were estimated: nearly a chi-square distribution.

    .. math:: S^2 \sim \mu\, \chi^2_\nu / \nu

    with the `mean` :math:`\mu` and as many degrees of `freedom` :math:`\nu` as the variance of the logarithm asks for
    [2]_, which is :math:`\psi_1(\nu / 2)`; infinitely many where all estimates are the same.
    """

    mean: float
    freedom: float

    @classmethod
    def of(cls, squares: np.ndarray) -> ChiSquare:
        """Return the distribution of squares, shape (estimate,); nothing but zero where one of them is zero."""
        from scipy.special import psi

        if not np.all(squares > 0.0):
            return CERTAIN
        logs = np.log(squares)
        median = np.median(logs)
        reach = EDGE * DEVIATION_OVER_MEDIAN * np.median(np.abs(logs - median))
        # An estimate that went astray counts for no more than one at the edge of the others.
        logs = np.clip(logs, median - reach, median + reach)
        variance, middle = float(np.var(logs, ddof=1)), float(np.mean(logs))
        if variance == 0.0:
            return cls(math.exp(middle), math.inf)
        # The trigamma function of h is nearly 1/h + 1/(2 h^2).
        half = (1.0 + (1.0 + 2.0 * variance) ** 0.5) / (2.0 * variance)
        return cls(half * math.exp(middle - float(psi(half))), 2.0 * half)

    def deviation(self, share: float) -> float:
        """Return below which ratio to the true one a share of the estimated standard deviations lies."""
        from scipy.special import chdtri

        return float(chdtri(self.freedom, 1.0 - share) / self.freedom) ** 0.5 if math.isfinite(self.freedom) else 1.0


CERTAIN = ChiSquare(0.0, math.inf)


class _Drawn(NamedTuple):
    """A fit to one replicate: parameters as reported and as the model takes them, and the mean square of the residual.

    The scatter is the one that is visible, in units of the estimated one.
    """

    numbers: np.ndarray
    values: dict[str, Any]
    scatter: float
    square: float


def _squares(drawn: Iterable[_Drawn]) -> ChiSquare:
    return ChiSquare.of(np.array([fit.scatter**2 for fit in drawn]))


@dataclass(frozen=True)
class _Fits:
    """What fits a model to its replicates.

    Nobody knows the scatter exactly: that of a replicate is as far from the estimate as `squares` of others are.
    """

    replicates: Replicates
    disturbance: Disturbance
    refit: Refit
    cycles: Groups
    slope: np.ndarray
    squares: ChiSquare = CERTAIN

    def disturbed(self, **changes: float) -> _Fits:
        """Return the same with another disturbance."""
        return replace(self, disturbance=self.disturbance._replace(**changes))

    def pair(self, seed: np.random.SeedSequence) -> tuple[_Drawn, _Drawn]:
        """Fit the model to a replicate and to its mirror image."""
        return self.fit(seed), self.fit(seed, -1.0)

    def fit(self, seed: np.random.SeedSequence, side: float = 1.0) -> _Drawn:
        """Draw a replicate, or its mirror image (-1), and fit the model to it."""
        solution, rng = self.refit.solution, np.random.default_rng(seed)
        scatter, ratio = (
            self.disturbance.scatter,
            1.0 / self.squares.deviation(rng.uniform(0.01 * TAIL, 1.0 - 0.01 * TAIL)),
        )
        replicate = self.replicates.draw(self.disturbance._replace(scatter=ratio * scatter), rng, side)
        theta, residual = self.refit.solve(replicate, solution.theta)
        return _Drawn(
            solution.space.numbers(theta),
            solution.space.values(theta),
            scatter_in(self.cycles, self.slope, residual) / ratio if scatter > 0.0 else 0.0,
            float(np.mean(residual**2)),
        )
