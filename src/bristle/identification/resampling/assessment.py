"""How sure a fit is: intervals from twins of the log, a cross-check, and what the log does not see."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.variable import Variable
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.prediction_interval import Bands, half_width
from bristle.identification.resampling.bootstrap import Bootstrap, bootstrap
from bristle.identification.resampling.half_cycles import Groups, HalfCycles, level_slope, within_cycles
from bristle.identification.resampling.identifiability import Unidentifiable, unidentifiable
from bristle.identification.resampling.jackknife import jackknife_std
from bristle.identification.resampling.refit import Refit, Space
from bristle.identification.resampling.replicate import lasting_of
from bristle.identification.resampling.whiteness import is_white
from bristle.identification.result import Estimate, Fit, Resampling
from bristle.identification.settings import Settings
from bristle.identification.time_blocks import BLOCKS, beside, time_blocks

__all__ = ["assessed", "at_odds", "how_sure", "with_interval"]


def assessed(
    fit: Fit, problem: InverseDynamics, space: Space, draws: int, settings: Settings,
    report: Callable[[float], None] = lambda share: None,
) -> Fit:  # fmt: skip
    """Return a fit with what resampling says of it.

    Parameters
    ----------
    fit : Fit
        The fit.
    problem, space : InverseDynamics, Space
        What was fitted, and the coordinates of the solution.
    draws : int
        Number of twins.
    settings : Settings
        The thresholds.
    report : callable
        Is told the share of the work done.
    """
    residual, cycles = fit.traces.residual, HalfCycles(problem.dataset).groups
    clear = frozenset(one.name for one in fit.estimates if _is_clear(one, settings.clear_std))
    blind = unidentifiable(problem, space, clear, settings)
    # What is only weakly seen stays free: held, it would make the others look surer than they are.
    flat = {one.name for one in blind if one.flat}
    free = np.array([name not in flat for name in space.names])
    found = bootstrap(problem, space, draws, free=free, report=report)
    members = [space.finished(one) for one in found.members]
    bands = Bands(
        draws={name: np.array([one[name] for one in members]) for name in members[0]},
        scatter=found.scatter.value, noise=found.disturbance.noise, unexplained=found.unexplained,
        lasting=_lasting(found, problem, space, cycles, residual),
    )  # fmt: skip
    resampling = Resampling(
        bands=replace(bands, inflation=_inflation(bands, fit, problem, space, free)),
        scatter=found.scatter,
        half_cycles=cycles.count,
        resolution=found.disturbance.resolution,
        white=is_white(residual, settings),
        jackknife=jackknife_std(space, cycles, residual),
        curve=found.curve,
    )
    variables = problem.parameters.variables
    estimates = tuple(_estimate(one, found, blind, variables.get(one.name)) for one in fit.estimates)
    return replace(
        fit, estimates=estimates, resampling=resampling,
        diagnostics=(
            *fit.diagnostics,
            *(one.diagnostic for one in blind),
            *at_odds(estimates, found, resampling.jackknife, settings),
            how_sure("intervals", fit, resampling, bands.unexplained, noise=bands.noise),
        ),
    )  # fmt: skip


def _lasting(
    found: Bootstrap, problem: InverseDynamics, space: Space, cycles: Groups, residual: np.ndarray
) -> float:  # fmt: skip
    """Return how long what the model lacks keeps its side [s]."""
    dataset, left = problem.dataset, residual
    if found.scatter.value > 0.0:
        slope = level_slope(problem, problem.parameters.complete(space.values(space.theta)))
        left = within_cycles(cycles, slope, residual)
    return lasting_of(left, dataset.decimation * dataset.sample_time, found.unexplained)


def _inflation(bands: Bands, fit: Fit, problem: InverseDynamics, space: Space, free: np.ndarray) -> float:
    """Return the factor that makes bands hold 95 % of the rows of blocks that were held out, at least 1."""
    dataset = problem.dataset
    width = half_width(bands, fit.plant, fit.friction, dataset)
    share = []
    for part in time_blocks(dataset, BLOCKS)[1]:
        fitted = beside(part, dataset.reach)
        if fitted.any():
            _, residual = Refit(space, free, fitted).solve(problem, space.theta)
            share.append(np.abs(residual[part]) / width[part])
    return max(float(np.quantile(np.concatenate(share), 0.95)), 1.0) if share else 1.0


def _is_clear(one: Estimate, most: float) -> bool:
    """Return whether 30 % of a value mean anything: not so where it is known to be next to nothing."""
    return one.status == "identified" and one.larger_std is not None and one.larger_std <= most * abs(one.value)


def _estimate(
    one: Estimate, found: Bootstrap, blind: tuple[Unidentifiable, ...], variable: Variable | None
) -> Estimate:
    lost = next((other for other in blind if other.name == one.name), None)
    if lost is not None:
        one = replace(one, status="unidentifiable", reason=lost.diagnostic)
    return with_interval(one, found, variable)


def with_interval(one: Estimate, found: Bootstrap, variable: Variable | None) -> Estimate:
    """Return an estimate with its 95 % interval from twins, where it was fitted to them, within what is allowed."""
    if one.name not in found.space.told:
        return one
    low, high = found.interval(one.name)
    if low == high:
        # All twins end on the edge where the fit ended: that is no interval.
        return one
    # Errors that are turned around may reach beyond what the model allows.
    least, most = (variable.min, variable.max) if variable else (-np.inf, np.inf)
    return replace(one, interval=(min(max(low, least), most), min(max(high, least), most)))


def at_odds(
    estimates: tuple[Estimate, ...], found: Bootstrap, jackknife: Mapping[str, float], settings: Settings
) -> tuple[Diagnostic, ...]:
    """Return a warning for what scatters more from half-cycle to half-cycle than the twins do."""
    spread = dict(zip(found.space.told, found.std.tolist(), strict=False))
    names = tuple(
        one.name
        for one in estimates
        if one.status == "identified" and jackknife.get(one.name, 0.0) > settings.at_odds * spread.get(one.name, np.inf)
    )
    return (Diagnostic("half-cycles-differ", numbers={"names": names}),) if names else ()


def how_sure(code: str, fit: Fit, resampling: Resampling, unexplained: float, **numbers: float) -> Diagnostic:
    """Return how intervals were found: what disturbed the twins, and what of the residual is none of it."""
    found = {
        "draws": resampling.bands.count, "resolution": resampling.resolution,
        "scatter_percent": 100.0 * resampling.scatter.value, "half_cycles": resampling.half_cycles,
        "unexplained": unexplained, **numbers,
    }  # fmt: skip
    return Diagnostic(code, "", "note", found, fit.friction.kind)
