"""How sure a fit is: intervals from twins of the log, a cross-check, and what the log does not see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of
from bristle.identification.bands import Bands, half_width
from bristle.identification.problem import Problem
from bristle.identification.resampling.bootstrap import Bootstrap, bootstrap
from bristle.identification.resampling.half_cycles import HalfCycles
from bristle.identification.resampling.jackknife import jackknife_std
from bristle.identification.resampling.refit import Refit, Space, space_of
from bristle.identification.resampling.sight import Unseen, unseen
from bristle.identification.resampling.whiteness import is_white
from bristle.identification.result import Estimate, Fit, Resampling
from bristle.identification.solution import Solution
from bristle.identification.unknowns import Scales
from bristle.logs.log import Log

__all__ = ["assessed"]

BLOCKS = 5
FLAT = 0.1  # rise of the held-out error, in units of its variance, below which a parameter does nothing at all
AT_ODDS = 3.0  # ratio of the jackknife to the bootstrap from which the reader is told


def assessed(
    log: Log, fit: Fit, problem: Problem, solution: Solution, scales: Scales, draws: int,
    report: Callable[[float], None] = lambda share: None,
) -> Fit:  # fmt: skip
    """Return a fit with what resampling says of it.

    Parameters
    ----------
    log : Log
        The log.
    fit : Fit
        The fit.
    problem, solution, scales : Problem, Solution, Scales
        How it came about.
    draws : int
        Number of twins.
    report : callable
        Is told the share of the work done.
    """
    space = space_of(problem, solution, scales)
    residual = fit.traces.residual
    asked = frozenset(one.name for one in fit.estimates if one.status == "identified")
    blind = unseen(problem, space, asked)
    # What is only weakly seen stays free: held, it would make the others look surer than they are.
    flat = {one.name for one in blind if one.rise < FLAT}
    free = np.array([name not in flat for name in space.names])
    found = bootstrap(log, problem, space, draws, free=free, report=report)
    bands = Bands(
        draws={name: found.draws[:, column] for column, name in enumerate(space.names)},
        scatter=found.scatter.value, noise=found.disturbance.noise, unexplained=found.unexplained,
    )  # fmt: skip
    jackknife = _jackknife(space, HalfCycles(problem.regression), residual, free, solution)
    resampling = Resampling(
        bands=replace(bands, inflation=_inflation(bands, fit, problem, space, free)),
        scatter=found.scatter,
        half_cycles=HalfCycles(problem.regression).count,
        resolution=found.disturbance.resolution,
        white=is_white(residual),
        jackknife=jackknife,
    )
    estimates = tuple(_estimate(one, found, blind, solution) for one in fit.estimates)
    told = [f"{one.name} cannot be identified: {one.note}" for one in blind]
    return replace(
        fit, estimates=estimates, resampling=resampling,
        warnings=(*fit.warnings, *told, *_at_odds(estimates, found, jackknife)),
        assumptions=(*fit.assumptions, _how(fit, resampling)),
    )  # fmt: skip


def _inflation(bands: Bands, fit: Fit, problem: Problem, space: Space, free: np.ndarray) -> float:
    """Return the factor that makes bands hold 95 % of the rows of blocks that were held out, at least 1."""
    regression = problem.regression
    width = half_width(bands, fit.plant, fit.friction, regression)
    count, reach = regression.effort.size, regression.reach
    share = []
    for first, last in pairwise(np.linspace(0, count, BLOCKS + 1).astype(int).tolist()):
        fitted = np.ones(count, dtype=bool)
        fitted[max(first - reach, 0) : last + reach] = False
        if fitted.any():
            _, residual = Refit(space, free, fitted).solve(problem, space.phi)
            share.append(np.abs(residual[first:last]) / width[first:last])
    return max(float(np.quantile(np.concatenate(share), 0.95)), 1.0) if share else 1.0


def _jackknife(
    space: Space, cycles: HalfCycles, residual: np.ndarray, free: np.ndarray, solution: Solution
) -> dict[str, float]:
    """Return the standard error of each parameter [SI] by the jackknife, where there are half-cycles enough."""
    inner = free & np.array([name not in solution.at_edge for name in space.names])
    std = jackknife_std(space, cycles, residual, inner)
    if std is None:
        return {}
    slopes = np.abs(np.diag(solution.derivative))
    return {name: float(slope * one) for name, slope, one in zip(space.names, slopes, std, strict=True) if one > 0.0}


def _estimate(one: Estimate, found: Bootstrap, blind: tuple[Unseen, ...], solution: Solution) -> Estimate:
    lost = next((other for other in blind if other.name == one.name), None)
    if lost is not None:
        one = replace(one, status="unidentifiable", note=lost.note)
    if one.name not in found.space.names:
        return one
    return replace(one, interval=found.interval(one.name, at_edge=one.name in solution.at_edge))


def _at_odds(
    estimates: tuple[Estimate, ...], found: Bootstrap, jackknife: dict[str, float]
) -> list[str]:  # fmt: skip
    """Return a warning for what scatters more from half-cycle to half-cycle than the twins do."""
    spread = dict(zip(found.space.names, found.std.tolist(), strict=True))
    names = [
        one.name
        for one in estimates
        if one.status == "identified" and jackknife.get(one.name, 0.0) > AT_ODDS * spread.get(one.name, np.inf)
    ]
    if not names:
        return []
    return [
        f"leaving out half-cycles changes {', '.join(names)} by more than noise, encoder and scatter do: the model "
        "lacks something that differs between the half-cycles, and these intervals are too narrow"
    ]


def _how(fit: Fit, resampling: Resampling) -> str:
    kind = fit.friction.kind
    bands = resampling.bands
    noise, left = (with_unit(one, unit_of("force", kind)) for one in (bands.noise, bands.unexplained))
    step = with_unit(resampling.resolution, unit_of("length", kind))
    scatter = number(100.0 * resampling.scatter.value, digits=2)
    return (
        f"95 % intervals from {bands.count} fits to logs simulated with the model: "
        f"noise of {noise}, encoder steps of {step}, friction that scatters by {scatter} % over "
        f"{resampling.half_cycles} half-cycles; {left} of the residual (root mean square) is none of these, and comes "
        "back block by block with a sign drawn by chance"
    )
