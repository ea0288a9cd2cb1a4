"""Uncertainty of a fit, for every problem: intervals from replicates of the log, and bands."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.normal import NORMAL_95
from bristle.core.variable import Kind, Variable
from bristle.identification.bootstrap import Bootstrap, bootstrap
from bristle.identification.estimate import ROUGH, Estimate
from bristle.identification.estimation import Estimation
from bristle.identification.half_cycles import BLOCKS, correlation_time, within_cycles
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import Role
from bristle.identification.refit import Refit
from bristle.identification.result import Bands, Fit, Resampling
from bristle.identification.settings import Settings
from bristle.identification.simulated_bands import half_width
from bristle.models.friction import is_static

IN_DOUBT = (
    2.5  # times the scatter of replicates: measured factor for intervals with a doubtful treatment
)
AT_REVERSALS = ("presliding", "stribeck")
TREATMENT_DOUBTS = frozenset(
    {"delay_unknown", "delay_rough", "delay_or_filter", "filter_suspect", "stages_differ"}
)
MOST_SCALE = (
    2.0  # largest factor of the errors for a model that lacks a force: the range of its validation
)


def with_uncertainty(
    fit: Fit,
    estimation: Estimation,
    draws: int,
    settings: Settings,
    report: Callable[[float], None] = lambda share: None,
) -> Fit:
    """Return a fit with intervals and bands from `draws` replicates of its log; `report` receives the share of the work done."""
    problem, solution = estimation.resampled
    linear = _refits_linearly(fit)
    scale, unsure = birge_ratio(fit), _unsure(fit.diagnostics, estimation)
    wide = (
        np.array([IN_DOUBT if name in unsure else 1.0 for name in solution.space.reported])
        if unsure
        else None
    )
    replicates = bootstrap(
        problem, solution, draws, linear=linear, scale=scale, wide=wide, report=report
    )
    bands, resolution = _bands(replicates, fit, estimation), replicates.disturbance.resolution
    blurred = any(
        estimate.reason is not None and estimate.reason.code == "coarse_elements"
        for estimate in fit.estimates
    )
    resampling = Resampling(
        bands=replace(bands, inflation=_inflation(bands, fit, estimation, linear=linear)),
        scatter=replicates.scatter,
        half_cycles=problem.half_cycles.count,
        resolution=resolution,
        curve=replicates.curve,
        curve_from=settings.zone_counts * resolution if blurred else 0.0,
    )
    wider, about = zip(
        *(_with_interval(estimate, replicates, estimation.inverse) for estimate in fit.estimates),
        strict=True,
    )
    estimates = tuple(
        _judged(estimate, problem.parameters.variables.get(estimate.name), fit.plant.kind)
        for estimate in wider
    )
    lost = (new.reason for new, old in zip(estimates, wider, strict=True) if new is not old)
    diagnostics = [
        *fit.diagnostics,
        *(diagnostic for diagnostic in (*lost, *about) if diagnostic is not None),
    ]
    if unsure:
        diagnostics.append(
            Diagnostic("widened", severity="note", numbers={"names": unsure, "times": IN_DOUBT})
        )
    # The disturbances of the replicates, and the unexplained part of the residual.
    numbers = {
        "draws": bands.count,
        "resolution": resolution,
        "scatter_percent": 100.0 * replicates.scatter.value,
        "half_cycles": resampling.half_cycles,
        "unexplained": replicates.unexplained,
        "noise": bands.noise,
        **({"loop": 1} if fit.loop_rmse is not None else {}),
    }
    code = "intervals" if fit.position_rmse is None else "intervals_motion"
    diagnostics.append(Diagnostic(code, "", "note", numbers, fit.friction.kind))
    return replace(fit, estimates=estimates, resampling=resampling, diagnostics=tuple(diagnostics))


def _refits_linearly(fit: Fit) -> bool:
    """Return whether fits to replicates are linearised around the fit: those of a position, and of a loop without pre-sliding."""
    return fit.position_rmse is not None or (fit.loop_rmse is not None and is_static(fit.friction))


def birge_ratio(fit: Fit) -> float:
    """Return the factor of the errors due to a force missing in the model, at least 1."""
    # Replicates contain only the random part of the residual. R. T. Birge, Physical Review 40(2), 1932,
    # doi:10.1103/PhysRev.40.207
    structures = (
        diagnostic.numbers for diagnostic in fit.diagnostics if diagnostic.code == "structure"
    )
    missing, chance = next(
        ((numbers["missing"], numbers["chance"]) for numbers in structures), (0.0, 1.0)
    )
    assert isinstance(missing, float)
    assert isinstance(chance, float)
    return min(math.hypot(missing, chance) / max(chance, np.finfo(float).tiny), MOST_SCALE)


def _unsure(diagnostics: Sequence[Diagnostic], estimation: Estimation) -> tuple[str, ...]:
    """Return the parameters that depend on reversals, if the treatment of the log is in doubt."""
    # Replicates are treated correctly by construction, and do not contain this doubt.
    problem, solution = estimation.resampled
    variables, doubts = (
        problem.parameters.variables,
        TREATMENT_DOUBTS.intersection(diagnostic.code for diagnostic in diagnostics),
    )
    turning = (
        name
        for name in solution.space.reported
        if name in variables and variables[name].excitation in AT_REVERSALS
    )
    return tuple(turning) if doubts else ()


def _identified(estimates: Sequence[Estimate]) -> list[str]:
    return [estimate.name for estimate in estimates if estimate.status == "identified"]


def _bands(replicates: Bootstrap, fit: Fit, estimation: Estimation) -> Bands:
    """Return the data of a band around an effort, without the error of a simulated position."""
    problem, _ = estimation.resampled
    members = [estimation.finished(member) for member in replicates.members]
    lacking, rest = (
        replicates.unexplained if fit.position_rmse is None else 0.0,
        replicates.residual,
    )
    # Lower bound of the position error until a loop is simulated.
    jitter = replicates.disturbance.jitter
    if replicates.scatter.value > 0.0:
        rest = within_cycles(problem.half_cycles, replicates.slope, rest)
    return Bands(
        draws={
            name: np.array([member[name] for member in members])
            for name in members[0]
            if name not in problem.parameters.loop
        },
        scatter=replicates.scatter.value,
        noise=replicates.disturbance.noise,
        unexplained=lacking,
        lasting=correlation_time(rest, problem.row_time, lacking),
        left_in_closed_loop=jitter,
        left_in_open_loop=jitter,
    )


def _inflation(bands: Bands, fit: Fit, estimation: Estimation, *, linear: bool) -> float:
    """Return the factor with which bands contain 95 % of held-out rows, at least 1."""
    problem, solution = estimation.resampled
    width, share = half_width(bands, fit.plant, fit.friction, problem.dataset), []
    for fold in problem.folds(BLOCKS)[1]:
        if fold.fitted.any() and fold.of_dataset.any():
            theta, residual = Refit(solution, fold.fitted, linear).solve(problem, solution.theta)
            rows = problem.effort_residual(solution.space.values(theta), residual)
            share.append(np.abs(rows[fold.of_dataset]) / width[fold.of_dataset])
    return max(float(np.quantile(np.concatenate(share), 0.95)), 1.0) if share else 1.0


def _with_interval(
    estimate: Estimate, replicates: Bootstrap, problem: InverseDynamics
) -> tuple[Estimate, Diagnostic | None]:
    """Return an estimate with its 95 % interval, if replicates were fitted; the interval contains the estimate."""
    low, high = (
        replicates.interval(estimate.name) if estimate.name in replicates.reported else (0.0, 0.0)
    )
    if low == high:  # All replicates ended on the same edge as the fit: no interval.
        return estimate, None
    warning, alignment = None, problem.dataset.alignment
    variable = problem.parameters.plant.variables.get(estimate.name)
    if (
        alignment is not None
        and alignment.mass is not None
        and alignment.mass_half_width is not None
    ):
        first = (
            alignment.mass - alignment.mass_half_width,
            alignment.mass + alignment.mass_half_width,
        )
        # If the intervals of the inertia from the fit and from the first stage are disjoint, use their union.
        if (
            variable is not None
            and Role.INERTIA.fits(variable)
            and (high < first[0] or first[1] < low)
        ):
            warning = Diagnostic(
                "stages_differ",
                estimate.name,
                "warning",
                {"first": alignment.mass, "value": estimate.value},
                problem.dataset.kind,
            )
            low, high = min(first[0], low), max(first[1], high)
    return replace(
        estimate, interval=(min(low, estimate.value), max(high, estimate.value))
    ), warning


def _judged(estimate: Estimate, variable: Variable | None, kind: Kind) -> Estimate:
    """Return an estimate, as not identified if its interval is wide because its effect on the force is small."""
    # A small force is known to be small, and a parameter that matters counts as roughly known.
    percent = 0.0 if estimate.interval is None else estimate.interval_percent or 0.0
    is_force = variable is None or variable.quantity == "force"
    if is_force or estimate.status != "identified" or estimate.is_rough or percent <= 100.0 * ROUGH:
        return estimate
    reason = Diagnostic(
        "small_effect", estimate.name, "warning", {"std_percent": percent / NORMAL_95}, kind
    )
    return replace(estimate, status="unidentifiable", reason=reason)
