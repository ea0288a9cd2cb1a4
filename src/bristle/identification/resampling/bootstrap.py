"""Parametric bootstrap: intervals from fits to twins of the log.

The error of a fit is that of the same fit to a log that the fitted model made. Errors are turned around: where the
fits to twins come out high, so did the first one (basic interval [1]_); those of a parameter that is sought in
its logarithm are factors. A parameter on an edge of its range has the percentiles themselves. Twins come in pairs, the
second one with all disturbances of the first reversed (antithetic draws [1]_): what chance does to the middle of a few
hundred fits then cancels, and the bias is left.

The scatter that twins show, over the one that they were made with, gives the interval of the scatter, and how far that
of a twin may be from the estimate.

References
----------
.. [1] A. C. Davison, D. V. Hinkley, "Bootstrap Methods and their Application", Cambridge University Press, 1997.
   doi:10.1017/CBO9780511802843
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from bristle.core.cores import Abreast
from bristle.identification.inverse_dynamics import InverseDynamics, Residual
from bristle.identification.resampling.chi_square import CERTAIN, ChiSquare
from bristle.identification.resampling.half_cycles import Groups, HalfCycles, level_slope, scatter_seen
from bristle.identification.resampling.refit import Refit, Space
from bristle.identification.resampling.replicate import Disturbance, Replicates, disturbance_of
from bristle.identification.result import Scatter

__all__ = ["Bootstrap", "Drawing", "basic_interval", "bootstrap", "fitted_to_twins", "seen_in"]

PILOT = 32  # draws by which the scatter, and then what the model lacks, are set right
SEED = 20_261_120
TAIL = 2.5  # percent
FEWEST_CYCLES = 4  # for a scatter


class Drawing(Protocol):
    """What draws twins of a log."""

    @property
    def disturbance(self) -> Disturbance:
        """What they are drawn with."""
        ...

    @property
    def groups(self) -> Groups:
        """The half-cycles of the log."""
        ...

    def disturbed(self, **changes: float) -> Drawing:
        """Return the same with another disturbance."""
        ...

    def drawn(self, rng: np.random.Generator, ratio: float = 1.0, side: float = 1.0) -> Residual:
        """Return the same problem on a log drawn anew, with `ratio` times the scatter, or on its mirror image (-1)."""
        ...


@dataclass(frozen=True)
class Bootstrap:
    """Fits to logs drawn anew.

    Parameters
    ----------
    space : Space
        The coordinates of the fit to the log itself.
    draws : ndarray, shape (draw, told and curve)
        What was fitted to each twin, as `Space.numbers` tells it [SI].
    members : tuple of mapping
        The same, as the model takes it.
    free : ndarray, shape (free,) of bool
        Coordinates that were fitted.
    disturbance : Disturbance
        What the logs were drawn with.
    scatter : Scatter
        From reversal to reversal.
    unexplained : float
        Root mean square of the part of the residual that neither noise, encoder nor scatter explain [N or N*m].
    """

    space: Space
    draws: np.ndarray
    members: tuple[Mapping[str, Any], ...]
    free: np.ndarray
    disturbance: Disturbance
    scatter: Scatter
    unexplained: float

    @property
    def estimate(self) -> np.ndarray:
        """What was fitted to the log itself [SI], shape (told and curve,)."""
        return self.space.numbers(self.space.theta)

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of the draws [SI], shape (told and curve,)."""
        return np.std(self.draws, axis=0, ddof=1)

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of a parameter [SI]."""
        column = self.space.told.index(name)
        draws = self.draws[:, column]
        if name in self.space.at_edge:
            low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
            return float(low), float(high)
        return basic_interval(draws, self.estimate[column], logarithmic=name in self.space.logarithmic)

    @property
    def curve(self) -> tuple[tuple[float, float, float, float], ...]:
        """The virgin curve: displacement [m or rad], force [N or N*m], and the ends of its 95 % interval."""
        first, found = len(self.space.told), self.estimate
        return tuple(
            (x, float(found[first + place]),
             *basic_interval(self.draws[:, first + place], found[first + place], logarithmic=False))
            for place, x in enumerate(self.space.curve)
        )  # fmt: skip


def basic_interval(draws: np.ndarray, estimate: float, *, logarithmic: bool) -> tuple[float, float]:
    """Return the 95 % interval of an estimate from estimates of twins, shape (draw,), whose truth it is."""
    if logarithmic:
        low, high = basic_interval(np.log(draws), float(np.log(estimate)), logarithmic=False)
        return float(np.exp(low)), float(np.exp(high))
    low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
    return float(2.0 * estimate - high), float(2.0 * estimate - low)


def bootstrap(
    problem: InverseDynamics, space: Space, count: int, *, free: np.ndarray | None = None, seed: int = SEED,
    report: Callable[[float], None] = lambda share: None,
) -> Bootstrap:  # fmt: skip
    """Return fits to twins of a log.

    Parameters
    ----------
    problem : InverseDynamics
        What was fitted.
    space : Space
        The coordinates of the solution.
    count : int
        Number of twins.
    free : ndarray, shape (free,) of bool, optional
        Coordinates that are fitted; all where not given.
    seed : int
        Of the random numbers.
    report : callable
        Is told the share of the work done.
    """
    free = np.ones(len(space.names), dtype=bool) if free is None else free
    values = problem.parameters.complete(space.values(space.theta))
    cycles = HalfCycles(problem.dataset)
    residual = problem.dataset.effort - problem.predicted(values)
    slope = level_slope(problem, values)
    twin = Replicates(problem, cycles, values, disturbance_of(problem.dataset, seen_in(cycles.groups, slope, residual)))
    return fitted_to_twins(twin, Refit(space, free, slice(None)), slope, residual, count, seed, report)


def seen_in(cycles: Groups, slope: np.ndarray, residual: np.ndarray) -> float:
    """Return the scatter that a residual shows, none where there are too few half-cycles for one."""
    return scatter_seen(cycles, slope, residual) if cycles.count >= FEWEST_CYCLES else 0.0


def fitted_to_twins(
    twin: Drawing, refit: Refit, slope: np.ndarray, residual: np.ndarray, count: int, seed: int = SEED,
    report: Callable[[float], None] = lambda share: None,
) -> Bootstrap:  # fmt: skip
    """Return fits to so many twins.

    Parameters
    ----------
    twin : Drawing
        Draws them, with the scatter that is seen in the residual.
    refit : Refit
        Fits the model to each.
    slope, residual : ndarray, shape (row,)
        By how much the signal rises with the level of friction; what the first fit left over.
    count, seed, report
        As for `bootstrap`.
    """
    space, free, seen = refit.space, refit.free, twin.disturbance.scatter
    fits, rng = _Fits(twin, refit, slope), np.random.SeedSequence(seed)
    with Abreast() as pool:
        # A fit takes part of the scatter into its parameters: what is seen of it is less than there is.
        pilot = _squares(pool.map(fits.one, rng.spawn(PILOT)))
        scatter = seen * seen / pilot.mean**0.5 if pilot.mean > 0.0 else 0.0
        fits = fits.disturbed(scatter=scatter)
        square, residuals = float(np.mean(residual**2)), pool.map(fits.one, rng.spawn(PILOT))
        lacking = max(square - float(np.mean([one.square for one in residuals])), 0.0)
        fits = fits.disturbed(unexplained=(lacking / square) ** 0.5 if square > 0.0 else 0.0)
        fits = replace(fits, shown=pilot)
        found = []
        for pair in pool.map(fits.pair, rng.spawn(-(-count // 2))):
            found += pair
            report(min(len(found) / count, 1.0))
    shown, found = _squares(found), found[:count]
    return Bootstrap(
        space, np.array([one.numbers for one in found]), tuple(one.values for one in found), free,
        fits.twin.disturbance, _interval(scatter, shown), lacking**0.5,
    )  # fmt: skip


def _squares(drawn: Iterable[_Drawn]) -> ChiSquare:
    return ChiSquare.of(np.array([one.scatter**2 for one in drawn]))


def _interval(scatter: float, shown: ChiSquare) -> Scatter:
    return Scatter(scatter, *(scatter / shown.deviation(share) for share in (1.0 - 0.01 * TAIL, 0.01 * TAIL)))


class _Drawn(NamedTuple):
    """A fit to one twin.

    The parameters as a person is told and as the model takes them, the scatter that is seen of the estimated one, and
    the mean square of the residual.
    """

    numbers: np.ndarray
    values: dict[str, Any]
    scatter: float
    square: float


@dataclass(frozen=True)
class _Fits:
    """What fits a model to its twins.

    Nobody knows the scatter exactly: each twin has another one, as far from the estimate as what others `shown` lies
    from theirs.
    """

    twin: Drawing
    refit: Refit
    slope: np.ndarray
    shown: ChiSquare = CERTAIN

    def disturbed(self, **changes: float) -> _Fits:
        """Return the same with another disturbance."""
        return replace(self, twin=self.twin.disturbed(**changes))

    def pair(self, seed: np.random.SeedSequence) -> tuple[_Drawn, _Drawn]:
        """Draw a twin and its mirror image, and fit the model to both."""
        return self.one(seed), self.one(seed, -1.0)

    def one(self, seed: np.random.SeedSequence, side: float = 1.0) -> _Drawn:
        """Draw a twin, or its mirror image, and fit the model to it."""
        space, rng = self.refit.space, np.random.default_rng(seed)
        ratio = 1.0 / self.shown.deviation(rng.uniform(0.01 * TAIL, 1.0 - 0.01 * TAIL))
        theta, residual = self.refit.solve(self.twin.drawn(rng, ratio, side), space.theta)
        scatters = self.twin.disturbance.scatter > 0.0
        return _Drawn(
            space.numbers(theta),
            space.values(theta),
            scatter_seen(self.twin.groups, self.slope, residual) / ratio if scatters else 0.0,
            float(np.mean(residual**2)),
        )
