"""Parametric bootstrap: intervals from fits to replicates.

A replicate is a log simulated with the fitted model. The error of a fit to a replicate is known, and estimates the
error of the fit to the log. Errors are reflected: if fits to replicates are too high, so is the estimate. Each
reflected fit is one draw of the parameters, and intervals are percentiles of the draws (basic interval [1]_). Errors
of a parameter that is sought in its logarithm are factors. Replicates come in pairs with opposite disturbances
(antithetic draws [1]_). The random error of the mean of a few hundred fits then cancels, and the bias remains. A
parameter on an edge of its range is not reflected. It takes the value of the other replicate of the pair.

The visible scatter of replicates, divided by the scatter they were made with, gives the interval of the scatter.

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
from bristle.identification.half_cycles import Disturbance, Groups, disturbance_of, scatter_in
from bristle.identification.parameter_space import ParameterSpace, Solution, Turned
from bristle.identification.problem import Contrast, Problem, Replicates, between
from bristle.identification.refit import Refit
from bristle.identification.result import Scatter

QUIET = 8  # draws without scatter, which show the apparent scatter
PILOT = 32  # draws that calibrate the scatter, then the unexplained force
SEED = 20_261_120
TAIL = 2.5  # percent
# Half-cycles for a scatter; share of half-cycles with rows away from reversals.
FEWEST_CYCLES, MOST_CYCLES = (4, 0.5)
CENTRING, ROUNDS = 8, 4  # pairs of replicates that centre the fits, and the rounds of it
OFF = 0.5  # allowed offset of the fits, in standard deviations
EDGE = 3.0  # standard deviations beyond which an estimated square is an outlier


@dataclass(frozen=True)
class Bootstrap:
    """Fits to replicates, drawn with a `disturbance`, of the log with this `solution`."""

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
        """The parameters that the draws contain."""
        return self.solution.space.reported

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of the draws of each parameter [SI]."""
        return dict(zip(self.reported, np.std(self.draws, axis=0, ddof=1).tolist(), strict=False))

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % interval of a parameter [SI]."""
        return _percentiles(self.draws[:, self.reported.index(name)])

    @property
    def curve(self) -> tuple[tuple[float, float, float, float], ...]:
        """The virgin curve: displacement [m or rad], force [N or N*m], and its 95 % interval."""
        return curve_of(self.solution.space, self.solution.theta, self.draws)


def curve_of(
    space: ParameterSpace, theta: np.ndarray, draws: np.ndarray
) -> tuple[tuple[float, float, float, float], ...]:
    """Return the virgin curve at these coordinates, with its 95 % intervals from draws of the reported numbers."""
    first = len(space.reported)
    forces, drawn = space.numbers(theta)[first:], draws[:, first:].T
    return tuple(
        (x, float(force), *_percentiles(sample))
        for x, force, sample in zip(space.curve, forces, drawn, strict=True)
    )


def _percentiles(draws: np.ndarray) -> tuple[float, float]:
    low, high = np.percentile(draws, [TAIL, 100.0 - TAIL])
    return float(low), float(high)


def turned(
    solution: Solution,
    thetas: np.ndarray,  # shape (draw, coordinate)
    centre: np.ndarray,
    doubt: float = 0.0,  # standard error of the mean offset of the fits, as a share of it
    moved: np.ndarray | float = 0.0,  # subtracted from the draws
    scale: float = 1.0,  # of the distances of the draws
    wide: np.ndarray
    | None = None,  # factors of the deviations of the reported numbers, shape (reported,)
) -> list[Turned]:
    """Return the fits to replicates, with pairs in sequence, reflected from their `centre` to the other side of a solution."""
    pair = np.minimum(np.arange(len(thetas)) ^ 1, len(thetas) - 1)
    middle = 0.5 * (solution.theta + centre)
    off = doubt * (np.mean(thetas, axis=0) - centre)
    spread = np.random.default_rng(SEED).standard_normal(len(thetas) // 2 + 1)
    drawn = (
        thetas
        + np.multiply.outer(np.repeat(spread, 2) * np.tile([1.0, -1.0], spread.size), off)[
            : len(thetas)
        ]
    )
    drawn = np.where(_on_edge(solution), 2.0 * middle - thetas[pair], drawn) - moved
    drawn = centre + scale * (drawn - centre)
    if wide is not None:
        size = np.linalg.norm(solution.derivative, axis=1, keepdims=True)
        reported = solution.derivative / np.where(size > 0.0, size, 1.0)
        values = (drawn - np.mean(drawn, axis=0)) @ reported.T
        drawn += (values * (wide - 1.0)) @ np.linalg.pinv(reported).T
    return [solution.space.turned(theta, middle) for theta in drawn]


def _on_edge(solution: Solution) -> np.ndarray:
    return np.array([name in solution.at_edge for name in solution.space.names])


def bootstrap(
    problem: Problem,
    solution: Solution,
    count: int,
    *,
    linear: bool = False,
    scale: float = 1.0,
    wide: np.ndarray | None = None,
    report: Callable[[float], None] = lambda share: None,
) -> Bootstrap:
    """Return fits to `count` replicates of a log; `scale` multiplies all errors, `wide` the spread of each reported number."""
    values, cycles = problem.parameters.complete(solution.values), problem.half_cycles
    residual, slope = problem.residual(solution.values), problem.friction_slope(values)
    levels = Levels.of(cycles, slope, problem.away.rows)
    visible = levels.scatter(residual)
    fits = _Fits(
        problem.replicates(values, slope, residual),
        disturbance_of(problem.dataset, visible),
        Refit(solution, linear=linear),
        levels,
        solution.theta,
        Contrast.of(solution, problem.away, residual),
    )
    rng = np.random.SeedSequence(SEED)
    first, second, pairs = rng.spawn(PILOT), rng.spawn(PILOT), rng.spawn(-(-count // 2))
    with Abreast() as pool:
        # Noise and the treatment look like scatter, and the parameters of a fit absorb part of it: visible and true scatter differ.
        quiet = (
            _squares(pool.map(fits.disturbed(scatter=0.0).fit, first[:QUIET])).mean
            if visible > 0.0
            else 0.0
        )
        pilot = _squares(pool.map(fits.fit, first))
        # Two of the rounds suffice mostly, of pairs.
        whole = QUIET + 2 * PILOT + ROUNDS * CENTRING + count
        report((QUIET + PILOT) / whole)
        level = Level(
            visible**2,
            quiet,
            max(pilot.mean - quiet, 0.0) / visible**2 if visible > 0.0 else 0.0,
            pilot,
        )
        fits = fits.disturbed(scatter=level.scatter())
        # Centre the replicates: choose parameters whose replicates give fits near the fit to the log. The error of a fit to the
        # estimate equals that of a fit to the truth only if both are close together.
        for _ in range(0 if linear or solution.space.linear else ROUNDS):
            thetas = np.array(
                [fit.theta for pair in pool.map(fits.pair, pairs[:CENTRING]) for fit in pair]
            )
            off = np.where(_on_edge(solution), 0.0, np.mean(thetas, axis=0) - solution.theta)
            centre = np.clip(fits.centre - off, solution.space.low, solution.space.high)
            if np.all(np.abs(centre - fits.centre) <= OFF * np.std(thetas, axis=0, ddof=1)):
                break
            replicates = fits.replicates.made_with(
                problem.parameters.complete(solution.space.values(centre))
            )
            fits = replace(fits, replicates=replicates, centre=centre)
        square, pilots = float(np.mean(residual**2)), pool.map(fits.fit, second)
        lacking = max(square - float(np.mean([fit.square for fit in pilots])), 0.0)
        fits = fits.disturbed(unexplained=(lacking / square) ** 0.5 if square > 0.0 else 0.0)
        fits, drawn = replace(fits, level=level), []
        for pair in pool.map(fits.pair, pairs):
            drawn += pair
            report(1.0 - max(count - len(drawn), 0) / whole)
    thetas, changes = (
        np.array([getattr(fit, part) for fit in drawn[:count]]) for part in ("theta", "change")
    )
    moved = between(
        fits.contrast.change(residual), changes, thetas - fits.centre, np.random.default_rng(SEED)
    )
    level = level._replace(squares=_squares(drawn))
    draws = turned(solution, thetas, fits.centre, fits.replicates.doubt, moved, scale, wide)
    ends = (
        level.scatter(level.squares.deviation(share)) for share in (1.0 - 0.01 * TAIL, 0.01 * TAIL)
    )
    return Bootstrap(
        solution,
        np.array([draw.numbers for draw in draws]),
        tuple(draw.values for draw in draws),
        fits.disturbance,
        Scatter(level.scatter(), *ends),
        lacking**0.5,
        residual,
        slope,
    )


class ChiSquare(NamedTuple):
    r"""Squares of estimated standard deviations: nearly a chi-square distribution.

    .. math:: S^2 \sim \mu\, \chi^2_\nu / \nu

    with the `mean` :math:`\mu` and the degrees of `freedom` :math:`\nu` that give the variance
    :math:`\psi_1(\nu / 2)` of the logarithm [2]_; infinite if all estimates are equal.
    """

    mean: float
    freedom: float

    @classmethod
    def of(cls, squares: np.ndarray) -> ChiSquare:
        """Return the distribution of squares, shape (estimate,); `CERTAIN` if any square is zero."""
        from scipy.special import psi

        if not np.all(squares > 0.0):
            return CERTAIN
        logs = np.log(squares)
        median = np.median(logs)
        reach = EDGE * DEVIATION_OVER_MEDIAN * np.median(np.abs(logs - median))
        # An outlier counts as an estimate at the edge of the others.
        logs = np.clip(logs, median - reach, median + reach)
        variance, middle = float(np.var(logs, ddof=1)), float(np.mean(logs))
        if variance == 0.0:
            return cls(math.exp(middle), math.inf)
        # The trigamma function of h is nearly 1/h + 1/(2 h^2).
        half = (1.0 + (1.0 + 2.0 * variance) ** 0.5) / (2.0 * variance)
        return cls(half * math.exp(middle - float(psi(half))), 2.0 * half)

    def deviation(self, share: float) -> float:
        """Return the quantile `share` of the ratio of estimated to true standard deviation."""
        from scipy.special import chdtri

        return (
            float(chdtri(self.freedom, 1.0 - share) / self.freedom) ** 0.5
            if math.isfinite(self.freedom)
            else 1.0
        )


CERTAIN = ChiSquare(0.0, math.inf)


class Levels(NamedTuple):
    """Half-cycles of some rows that show the scatter of the level, and the slope of each row with the level."""

    cycles: Groups
    slope: np.ndarray
    rows: np.ndarray

    @classmethod
    def of(cls, cycles: Groups, slope: np.ndarray, away: np.ndarray) -> Levels:
        """Return the half-cycles of rows away from reversals if most half-cycles have such rows, else of all rows."""
        beyond = Groups(cycles.of_rows[away])
        rows = (
            away
            if away.any() and beyond.count >= MOST_CYCLES * cycles.count
            else np.ones_like(away)
        )
        return cls(Groups(cycles.of_rows[rows]), slope[rows], rows)

    def scatter(self, residual: np.ndarray) -> float:
        """Return the visible scatter in a residual, shape (row,); 0 for too few half-cycles."""
        if self.cycles.count < FEWEST_CYCLES:
            return 0.0
        return scatter_in(self.cycles, self.slope, residual[self.rows])


class Level(NamedTuple):
    """Squares of the visible scatter: the ratio of the visible to the expected square has the distribution `squares`."""

    visible: float  # in the log
    quiet: float  # without true scatter
    gain: float  # per square of the true scatter
    squares: ChiSquare = CERTAIN

    def scatter(self, deviation: float = 1.0) -> float:
        """Return the true scatter if the visible scatter is this ratio times the expected scatter."""
        return (
            (max(self.visible / deviation**2 - self.quiet, 0.0) / self.gain) ** 0.5
            if self.gain > 0.0
            else 0.0
        )

    def visible_of(self, scatter: float) -> float:
        """Return the visible scatter expected for a true scatter."""
        return (self.quiet + self.gain * scatter**2) ** 0.5 or 1.0


class _Drawn(NamedTuple):
    """A fit to one replicate: its coordinates, mean square of the residual."""

    # The scatter is the visible scatter over the expected scatter; the `change` is that of the contrast.

    theta: np.ndarray
    change: np.ndarray
    scatter: float
    square: float


def _squares(drawn: Iterable[_Drawn]) -> ChiSquare:
    return ChiSquare.of(np.array([fit.scatter**2 for fit in drawn]))


@dataclass(frozen=True)
class _Fits:
    """Fits of a model to its replicates."""

    # The true scatter is uncertain: each replicate has a scatter that is compatible with the `level` of the log.
    # Replicates are made with the coordinates `centre`.

    replicates: Replicates
    disturbance: Disturbance
    refit: Refit
    levels: Levels
    centre: np.ndarray
    contrast: Contrast
    level: Level | None = None

    def disturbed(self, **changes: float) -> _Fits:
        """Return these fits with another disturbance."""
        return replace(self, disturbance=self.disturbance._replace(**changes))

    def pair(self, seed: np.random.SeedSequence) -> tuple[_Drawn, _Drawn]:
        """Fit the model to a replicate and to its mirror image."""
        return self.fit(seed), self.fit(seed, -1.0)

    def fit(self, seed: np.random.SeedSequence, side: float = 1.0) -> _Drawn:
        """Draw a replicate, or its mirror image (-1), and fit the model to it."""
        solution, rng = self.refit.solution, np.random.default_rng(seed)
        scatter, usual, share = (
            self.disturbance.scatter,
            1.0,
            rng.uniform(0.01 * TAIL, 1.0 - 0.01 * TAIL),
        )
        if self.level is not None:
            scatter = self.level.scatter(self.level.squares.deviation(share))
            usual = self.level.visible_of(scatter)
        theta, residual = self.refit.solve(
            self.replicates.draw(self.disturbance._replace(scatter=scatter), rng, side),
            solution.theta,
        )
        return _Drawn(
            theta,
            self.contrast.change(residual),
            self.levels.scatter(residual) / usual,
            float(np.mean(residual**2)),
        )
