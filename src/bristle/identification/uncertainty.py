"""How sure a fit is: intervals from replicates of the log, a cross-check, and what the log does not see.

It is the same for every problem, whatever the signal that it makes small.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Sequence
from dataclasses import replace

import numpy as np

from bristle.core.diagnostic import Diagnostic, Number
from bristle.identification.bootstrap import Bootstrap, bootstrap
from bristle.identification.estimation import Estimation
from bristle.identification.excitation import shortest_zone
from bristle.identification.global_search import Refit
from bristle.identification.half_cycles import BLOCKS, correlation_time, within_cycles
from bristle.identification.identifiability import as_soft, unidentifiable
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import Role, names_of
from bristle.identification.problem import Problem, is_white
from bristle.identification.result import Estimate, Fit, Resampling
from bristle.identification.settings import Settings
from bristle.identification.simulated_bands import Bands, half_width

__all__ = ["with_uncertainty"]

NEARLY = 4.0  # times the least pre-sliding that is told: what is so short is asked about once more
IN_DOUBT = 2.5  # times the scatter of replicates: what it takes to hold where the treatment is in doubt, as measured
AT_REVERSALS = ("presliding", "stribeck")
TREATMENT_DOUBTS = frozenset({"delay_unknown", "delay_rough", "delay_or_filter", "filter_suspect", "stages_differ"})
MOST_SCALE = 2.0  # of errors, of a model that lacks a force: what that was measured for


def with_uncertainty(
    fit: Fit, estimation: Estimation, draws: int, settings: Settings, report: Callable[[float], None] = lambda share: None
) -> Fit:
    """Return a fit with what so many replicates of its log say of it; `report` is told the share of the work done."""
    problem, solution = estimation.resampled
    clear = frozenset(estimate.name for estimate in fit.estimates if _is_clear(estimate, settings.clear_std))
    lost = unidentifiable(problem, solution, clear, settings)
    # What is only weakly seen stays free: held, it would make the others look surer than they are.
    flat = {parameter.name for parameter in lost if parameter.flat}
    free = np.array([name not in flat for name in solution.space.names])
    linear = problem.refits_linearly(fit.friction)
    scale = _scale(fit.diagnostics)
    unsure = _unsure(fit.diagnostics, estimation)
    wide = np.array([IN_DOUBT if name in unsure else 1.0 for name in solution.space.reported]) if unsure else None
    replicates = bootstrap(problem, solution, draws, free=free, linear=linear, scale=scale, wide=wide, report=report)
    residual, cycles = replicates.residual, problem.half_cycles
    bands = _bands(replicates, estimation)
    resampling = Resampling(
        bands=replace(bands, inflation=_inflation(bands, fit, estimation, free, linear=linear)),
        scatter=replicates.scatter,
        half_cycles=cycles.count,
        resolution=replicates.disturbance.resolution,
        white=is_white(residual, settings),
        jackknife=replicates.jackknife,
        curve=replicates.curve,
        curve_from=_curve_from(fit.estimates, settings.zone_counts * replicates.disturbance.resolution),
    )
    reasons = {parameter.name: parameter.diagnostic for parameter in lost}
    reasons |= as_soft(problem, replicates, free, _blurred(fit.estimates, reasons, estimation, settings), settings)
    reasons |= _without_stiffness(fit.estimates, reasons, estimation.inverse)
    judged = (
        replace(estimate, status="unidentifiable", reason=reasons[name]) if name in reasons else estimate
        for name, estimate in fit.parameters.items()
    )
    fitted = [_with_interval(estimate, replicates) for estimate in judged]
    estimates, about = zip(*(_of_both_stages(estimate, estimation.inverse) for estimate in fitted), strict=True)
    return replace(
        fit,
        estimates=estimates,
        resampling=resampling,
        diagnostics=(
            *fit.diagnostics,
            *reasons.values(),
            *(diagnostic for diagnostic in about if diagnostic is not None),
            *_at_odds(estimates, replicates, settings),
            *_shifted(estimates),
            *_widened(unsure),
            _how_sure(problem, fit, resampling, replicates.unexplained),
        ),
    )


def _blurred(estimates: Sequence[Estimate], lost: Container[str], estimation: Estimation, settings: Settings) -> list[str]:
    """Return the stiffnesses that seem to be identified though their pre-sliding is few steps of the encoder.

    They are those that were sought one by one along a measured motion.
    """
    problem, solution = estimation.resampled
    if estimation.simulates or solution.space.linear:
        return []
    variables, values = problem.parameters.variables, problem.parameters.complete(solution.values)
    level = max((values[name] for name in names_of(Role.LEVEL, variables)), default=np.inf)
    least = shortest_zone(problem.dataset, settings)
    seen = (estimate.name for estimate in estimates if estimate.status == "identified" and estimate.name not in lost)
    sought = set(names_of(Role.STIFFNESS, variables)).intersection(solution.space.names)
    return [name for name in seen if name in sought and level < NEARLY * least * values[name]]


def _without_stiffness(estimates: Sequence[Estimate], lost: Container[str], problem: InverseDynamics) -> dict[str, Diagnostic]:
    """Return why what damps a stiffness is not identified, where no stiffness is: beside another one it is another."""
    variables, kind = problem.parameters.variables, problem.dataset.kind
    names = [estimate.name for estimate in estimates if estimate.status in ("identified", "held") and estimate.name not in lost]
    stiff = names_of(Role.STIFFNESS, variables)
    damping = set(names).intersection(names_of(Role.MICRO_DAMPING, variables))
    if not stiff or not set(stiff).isdisjoint(names):
        return {}
    numbers: dict[str, Number] = {"stiffness": stiff[0]}
    return {name: Diagnostic("as_soft", name, "warning", numbers, kind) for name in damping}


def _scale(diagnostics: Sequence[Diagnostic]) -> float:
    """Return by how much errors are larger where a force is missing: replicates know of what chance leaves over.

    The square root of what is left over, the force and chance, over chance alone (Birge's ratio).
    """
    structures = (diagnostic.numbers for diagnostic in diagnostics if diagnostic.code == "structure")
    missing, chance = next(((numbers["missing"], numbers["chance"]) for numbers in structures), (0.0, 1.0))
    assert isinstance(missing, float)
    assert isinstance(chance, float)
    return min(math.hypot(missing, chance) / max(chance, np.finfo(float).tiny), MOST_SCALE)


def _unsure(diagnostics: Sequence[Diagnostic], estimation: Estimation) -> tuple[str, ...]:
    """Return the parameters that show where friction turns, where it is in doubt how a log is to be treated.

    A replicate is treated as it is made, so that replicates know nothing of such a doubt.
    """
    problem, solution = estimation.resampled
    if not TREATMENT_DOUBTS.intersection(diagnostic.code for diagnostic in diagnostics):
        return ()
    variables = problem.parameters.variables
    return tuple(name for name in solution.space.reported if name in variables and variables[name].excitation in AT_REVERSALS)


def _widened(names: tuple[str, ...]) -> tuple[Diagnostic, ...]:
    """Return by how much intervals are wider than those of replicates."""
    return (Diagnostic("widened", severity="note", numbers={"names": names, "times": IN_DOUBT}),) if names else ()


def _curve_from(estimates: Sequence[Estimate], least: float) -> float:
    """Return from which displacement on a virgin curve is identified: beyond `least` where a stiffness is blurred."""
    reasons = (estimate.reason for estimate in estimates if estimate.reason is not None)
    return least if any(reason.code == "coarse_elements" for reason in reasons) else 0.0


def _bands(replicates: Bootstrap, estimation: Estimation) -> Bands:
    """Return what a band around an effort is made of; what a position lacks is none of it."""
    problem, _ = estimation.resampled
    members = [estimation.finished(member) for member in replicates.members]
    lacking, rest = replicates.unexplained if problem.is_effort else 0.0, replicates.residual
    jitter = replicates.disturbance.jitter  # until a loop is simulated, the least that it leaves over
    if replicates.scatter.value > 0.0:
        rest = within_cycles(problem.half_cycles, replicates.slope, rest)
    return Bands(
        draws={name: np.array([member[name] for member in members]) for name in members[0] if name not in problem.parameters.loop},
        scatter=replicates.scatter.value,
        noise=replicates.disturbance.noise,
        unexplained=lacking,
        lasting=correlation_time(rest, problem.row_time, lacking),
        left_in_closed_loop=jitter,
        left_in_open_loop=jitter,
    )


def _inflation(bands: Bands, fit: Fit, estimation: Estimation, free: np.ndarray, *, linear: bool) -> float:
    """Return the factor that makes bands hold 95 % of the rows of parts that were held out, at least 1."""
    problem, solution = estimation.resampled
    width, share = half_width(bands, fit.plant, fit.friction, problem.dataset), []
    for fold in problem.folds(BLOCKS)[1]:
        if fold.fitted.any() and fold.of_dataset.any():
            theta, residual = Refit(solution, free, fold.fitted, linear).solve(problem, solution.theta)
            rows = problem.effort_residual(solution.space.values(theta), residual)
            share.append(np.abs(rows[fold.of_dataset]) / width[fold.of_dataset])
    return max(float(np.quantile(np.concatenate(share), 0.95)), 1.0) if share else 1.0


def _is_clear(estimate: Estimate, most: float) -> bool:
    """Return whether 30 % of a value mean anything: not so where it is known to be next to nothing."""
    std = estimate.larger_std
    return estimate.status == "identified" and std is not None and std <= most * abs(estimate.value)


def _with_interval(estimate: Estimate, replicates: Bootstrap) -> Estimate:
    """Return an estimate with its 95 % interval, where it was fitted to replicates."""
    low, high = replicates.interval(estimate.name) if estimate.name in replicates.reported else (0.0, 0.0)
    # Where all replicates end on the edge where the fit ended, there is no interval.
    return estimate if low == high else replace(estimate, interval=(low, high))


def _of_both_stages(estimate: Estimate, problem: InverseDynamics) -> tuple[Estimate, Diagnostic | None]:
    """Return an inertia whose interval reaches over that of the first stage where both have nothing in common."""
    alignment, variable = problem.dataset.alignment, problem.parameters.plant.variables.get(estimate.name)
    if alignment is None or alignment.mass is None or alignment.mass_half_width is None or estimate.interval is None:
        return estimate, None
    low, high = alignment.mass - alignment.mass_half_width, alignment.mass + alignment.mass_half_width
    apart = estimate.interval[1] < low or high < estimate.interval[0]
    if variable is None or not Role.INERTIA.fits(variable) or not apart:
        return estimate, None
    numbers = {"first": alignment.mass, "value": estimate.value}
    warning = Diagnostic("stages_differ", estimate.name, "warning", numbers, problem.dataset.kind)
    interval = min(low, estimate.interval[0]), max(high, estimate.interval[1])
    return replace(estimate, interval=interval), warning


def _at_odds(estimates: Sequence[Estimate], replicates: Bootstrap, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning for what scatters more from half-cycle to half-cycle than replicates do, or theirs do."""
    std, usual = replicates.std, replicates.usual_jackknife
    names = tuple(
        estimate.name
        for estimate in estimates
        if estimate.status == "identified"
        and replicates.jackknife.get(estimate.name, 0.0)
        > settings.at_odds * max(std.get(estimate.name, np.inf), usual.get(estimate.name, 0.0))
    )
    return (Diagnostic("half_cycles_differ", numbers={"names": names}),) if names else ()


def _shifted(estimates: Sequence[Estimate]) -> tuple[Diagnostic, ...]:
    """Return a note on what lies outside its own interval: fits to replicates err the same way again."""
    names = tuple(
        estimate.name
        for estimate in estimates
        if estimate.interval is not None and not estimate.interval[0] <= estimate.value <= estimate.interval[1]
    )
    return (Diagnostic("shifted", severity="note", numbers={"names": names}),) if names else ()


def _how_sure(problem: Problem, fit: Fit, resampling: Resampling, unexplained: float) -> Diagnostic:
    """Return how intervals were found: what disturbed the replicates, and what of the residual is none of it."""
    numbers = {
        "draws": resampling.bands.count,
        "resolution": resampling.resolution,
        "scatter_percent": 100.0 * resampling.scatter.value,
        "half_cycles": resampling.half_cycles,
        "unexplained": unexplained,
        "noise": resampling.bands.noise,
    }
    return Diagnostic(problem.intervals_code, "", "note", numbers, fit.friction.kind)
