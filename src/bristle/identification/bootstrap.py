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
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.cores import Abreast
from bristle.identification.chi_square import CERTAIN, ChiSquare
from bristle.identification.disturbance import disturbance_of
from bristle.identification.half_cycles import Groups, scatter_seen
from bristle.identification.problem import Disturbance, Problem, Replicates
from bristle.identification.refit import Refit
from bristle.identification.result import Scatter
from bristle.identification.solution import Solution

__all__ = ["Bootstrap", "basic_interval", "bootstrap"]

PILOT = 32  # draws by which the scatter, and then what the model lacks, are set right
SEED = 20_261_120
TAIL = 2.5  # percent
FEWEST_CYCLES = 4  # for a scatter


@dataclass(frozen=True)
class Bootstrap:
    """Fits to logs drawn anew.

    Parameters
    ----------
    solution : Solution
        The fit to the log itself.
    draws : ndarray, shape (draw, reported and curve)
        What was fitted to each replicate, as the space of the solution reports it [SI].
    members : tuple of mapping
        The same, as the model takes it.
    free : ndarray, shape (free,) of bool
        Coordinates that were fitted.
    disturbance : Disturbance
        What the logs were drawn with.
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
    free: np.ndarray
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
    def estimate(self) -> np.ndarray:
        """What was fitted to the log itself [SI], shape (reported and curve,)."""
        return self.solution.space.numbers(self.solution.theta)

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of the draws [SI], shape (reported and curve,)."""
        return np.std(self.draws, axis=0, ddof=1)

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of a parameter [SI]."""
        column = self.reported.index(name)
        draws = self.draws[:, column]
        if name in self.solution.at_edge:
            low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
            return float(low), float(high)
        return basic_interval(draws, self.estimate[column], logarithmic=name in self.solution.space.logarithmic)

    @property
    def curve(self) -> tuple[tuple[float, float, float, float], ...]:
        """The virgin curve: displacement [m or rad], force [N or N*m], and the ends of its 95 % interval."""
        first, estimate = len(self.reported), self.estimate
        return tuple(
            (x, float(estimate[first + place]),
             *basic_interval(self.draws[:, first + place], estimate[first + place], logarithmic=False))
            for place, x in enumerate(self.solution.space.curve)
        )  # fmt: skip


def basic_interval(draws: np.ndarray, estimate: float, *, logarithmic: bool) -> tuple[float, float]:
    """Return the 95 % interval of an estimate from estimates of replicates, shape (draw,), whose truth it is."""
    if logarithmic:
        low, high = basic_interval(np.log(draws), float(np.log(estimate)), logarithmic=False)
        return float(np.exp(low)), float(np.exp(high))
    low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
    return float(2.0 * estimate - high), float(2.0 * estimate - low)


def bootstrap(
    problem: Problem, solution: Solution, count: int, *, free: np.ndarray | None = None, linear: bool = False,
    seed: int = SEED, report: Callable[[float], None] = lambda share: None,
) -> Bootstrap:  # fmt: skip
    """Return fits to replicates of a log.

    Parameters
    ----------
    problem, solution : Problem, Solution
        What was fitted, and where that ended.
    count : int
        Number of replicates.
    free : ndarray, shape (free,) of bool, optional
        Coordinates that are fitted; all where not given.
    linear : bool
        Whether a fit to a replicate may be taken for linear around the solution.
    seed : int
        Of the random numbers.
    report : callable
        Is told the share of the work done.
    """
    free = np.ones(len(solution.space.names), dtype=bool) if free is None else free
    values, cycles = problem.parameters.complete(solution.values), problem.half_cycles
    residual, slope = problem.residual(solution.values), problem.friction_slope(values)
    seen = scatter_seen(cycles, slope, residual) if cycles.count >= FEWEST_CYCLES else 0.0
    replicates = problem.replicates(values, disturbance_of(problem.dataset, seen), slope, residual)
    fits, rng = _Fits(replicates, Refit(solution, free, linear=linear), cycles, slope), np.random.SeedSequence(seed)
    with Abreast() as pool:
        # A fit takes part of the scatter into its parameters: what is seen of it is less than there is.
        pilot = _squares(pool.map(fits.one, rng.spawn(PILOT)))
        scatter = seen * seen / pilot.mean**0.5 if pilot.mean > 0.0 else 0.0
        fits = fits.disturbed(scatter=scatter)
        square, residuals = float(np.mean(residual**2)), pool.map(fits.one, rng.spawn(PILOT))
        lacking = max(square - float(np.mean([fit.square for fit in residuals])), 0.0)
        fits = fits.disturbed(unexplained=(lacking / square) ** 0.5 if square > 0.0 else 0.0)
        fits, drawn = replace(fits, shown=pilot), []
        for pair in pool.map(fits.pair, rng.spawn(-(-count // 2))):
            drawn += pair
            report(min(len(drawn) / count, 1.0))
    shown, drawn = _squares(drawn), drawn[:count]
    return Bootstrap(
        solution, np.array([fit.numbers for fit in drawn]), tuple(fit.values for fit in drawn), free,
        fits.replicates.disturbance, _interval(scatter, shown), lacking**0.5,
        residual, slope,
    )  # fmt: skip


def _squares(drawn: Iterable[_Drawn]) -> ChiSquare:
    return ChiSquare.of(np.array([fit.scatter**2 for fit in drawn]))


def _interval(scatter: float, shown: ChiSquare) -> Scatter:
    return Scatter(scatter, *(scatter / shown.deviation(share) for share in (1.0 - 0.01 * TAIL, 0.01 * TAIL)))


class _Drawn(NamedTuple):
    """A fit to one replicate.

    The parameters as they are reported and as the model takes them, the scatter that is seen of the estimated one, and
    the mean square of the residual.
    """

    numbers: np.ndarray
    values: dict[str, Any]
    scatter: float
    square: float


@dataclass(frozen=True)
class _Fits:
    """What fits a model to its replicates.

    Nobody knows the scatter exactly: each replicate has another one, as far from the estimate as what others `shown`
    lies from theirs.
    """

    replicates: Replicates
    refit: Refit
    cycles: Groups
    slope: np.ndarray
    shown: ChiSquare = CERTAIN

    def disturbed(self, **changes: float) -> _Fits:
        """Return the same with another disturbance."""
        return replace(self, replicates=self.replicates.disturbed(**changes))

    def pair(self, seed: np.random.SeedSequence) -> tuple[_Drawn, _Drawn]:
        """Draw a replicate and its mirror image, and fit the model to both."""
        return self.one(seed), self.one(seed, -1.0)

    def one(self, seed: np.random.SeedSequence, side: float = 1.0) -> _Drawn:
        """Draw a replicate, or its mirror image, and fit the model to it."""
        solution, rng = self.refit.solution, np.random.default_rng(seed)
        ratio = 1.0 / self.shown.deviation(rng.uniform(0.01 * TAIL, 1.0 - 0.01 * TAIL))
        theta, residual = self.refit.solve(self.replicates.draw(rng, ratio, side), solution.theta)
        scatters = self.replicates.disturbance.scatter > 0.0
        return _Drawn(
            solution.space.numbers(theta),
            solution.space.values(theta),
            scatter_seen(self.cycles, self.slope, residual) / ratio if scatters else 0.0,
            float(np.mean(residual**2)),
        )
