"""One model fitted: values with their uncertainty, the error on what was held out, and what the log does not tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.diagnostic import UNFINISHED, Diagnostic
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.engine.checks import finite
from bristle.friction import base_of, channel_slots_of
from bristle.friction.level import LEVELS, has_level
from bristle.friction.slots import variations_of
from bristle.identification.element_models import estimate_elements
from bristle.identification.estimates import Judgement, about_estimates, about_fixed, about_level, combinations_of
from bristle.identification.estimation import Context, Estimation, Estimator, along_the_motion
from bristle.identification.excitation import Excitation, about_amplitudes, about_repeated_logs, about_repetition
from bristle.identification.fixed_shape import ELEMENT_MODELS
from bristle.identification.least_squares import Report, between
from bristle.identification.problem import covariance_of
from bristle.identification.result import Fit, Traces
from bristle.identification.sliding_friction import with_pitch
from bristle.identification.stribeck_element_models import estimate_stribeck_elements
from bristle.identification.structure import about_alignment, about_held_effort, about_noise, about_residual, about_rise, about_treatment
from bristle.identification.validation import held_out_error
from bristle.simulation.result import relative_error_percent

ESTIMATED = 0.7  # of the work, where a model is fitted to all of the log


ELEMENTS: dict[FrictionModel, Estimator] = dict(zip(ELEMENT_MODELS, (estimate_elements, estimate_stribeck_elements), strict=True))
"""Models whose lists are found by variable projection, and how."""


def fit(context: Context, component: FrictionModel, blocks: int, report: Report) -> tuple[Fit, Estimation]:
    """Fit one model, with `blocks` parts of the log held out in turn, and return how that is done again, too."""
    report(0.0)
    context = with_pitch(context, component)
    estimation = _estimate(context, component, between(report, 0.0, ESTIMATED))
    fit, held_out, unfinished = fit_of(estimation, context), None, estimation.solution.unfinished
    if blocks and not unfinished:
        try:
            held_out = held_out_error(estimation, blocks, context.settings, between(report, ESTIMATED, 1.0))
        except KeyboardInterrupt:
            unfinished = True
    if not unfinished:
        report(1.0)
    diagnostics = (*((UNFINISHED,) if unfinished else ()), *fit.diagnostics)
    # Whether what was held out was like what was fitted.
    if held_out is not None and held_out.of == "logs":
        diagnostics += about_repeated_logs(context.dataset, context.settings)
    elif held_out is not None and fit.position_error_percent is None:
        diagnostics += about_repetition(context.dataset, context.settings)
    return replace(fit, held_out=held_out, unfinished=unfinished, diagnostics=diagnostics), estimation


def _estimate(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of one model; `report` is told the share of the work done."""
    elements = ELEMENTS.get(base_of(component))
    slots = [slot for slot in variations_of(component) if slot in LEVELS]
    if slots and not has_level(base_of(component)):
        raise InputError(
            f"has no level of sliding friction, which +{slots[0]} raises",
            path="model",
            value=component.name,
            mend="Take one that has, such as coulomb_viscous",
        )
    if elements is None:
        return (context.estimator or along_the_motion)(context, component, report)
    slots += [slot.name for slot in channel_slots_of(component)]
    if slots:
        raise InputError(
            f"has elements, which +{slots[0]} cannot be fitted beside",
            path="model",
            value=component.name,
            mend="Ask for dahl or lugre with this slot",
        )
    if context.estimator is not None:
        raise InputError(
            "is identified by inverse dynamics only",
            path="model",
            value=component.name,
            mend="Write --method inverse_dynamics, or ask for dahl or lugre",
        )
    return elements(context, component, report)


def fit_of(estimation: Estimation, context: Context) -> Fit:
    """Return the fit at a solution, all but its error on what was held out."""
    problem, solution, settings = estimation.inverse, estimation.solution, context.settings
    dataset, component = problem.dataset, problem.parameters.component
    values = problem.parameters.complete(solution.values)
    predicted = finite(problem.predicted(values), problem.model(values))
    residual = estimation.problem.residual(solution.values) if estimation.simulates else dataset.effort - predicted
    uncertainty = covariance_of(solution, residual, () if estimation.simulates else problem.found_first())
    excitation = Excitation(dataset, context.scales, values, problem.parameters.variables, settings)
    estimates = Judgement(problem, solution, uncertainty, excitation, filtered=not estimation.simulates).estimates()
    error = relative_error_percent(dataset.effort, predicted)
    rows: tuple[Diagnostic, ...] = ()
    if not estimation.simulates:
        rows = (
            *about_alignment(problem, solution, residual, settings),
            *about_held_effort(problem, estimates, settings),
            *about_noise(problem, estimates, settings),
            *about_residual(problem, values, error, settings),
        )
    errors: dict[str, Any] = estimation.problem.errors(solution.values)
    names, friction = solution.space.reported, problem.model(values)
    return Fit(
        plant=problem.plant(values),
        friction=estimation.written(_valid(component, values, dataset.kind)),
        estimates=estimates,
        combinations=combinations_of(component, {estimate.name: estimate for estimate in estimates}, dataset.kind),
        correlation=uncertainty.correlation,
        correlation_names=names,
        condition_number=uncertainty.condition_number,
        traces=Traces(dataset.time, dataset.velocity, dataset.acceleration, dataset.effort, predicted, problem.mechanical(values)),
        force_error_percent=error,
        diagnostics=(
            *about_estimates(estimates, uncertainty.correlation, names, settings.inseparable),
            *about_level(estimates, excitation),
            *rows,
            *about_rise(problem, values),
            *about_amplitudes(dataset, friction, settings),
            *about_fixed(problem),
            *(estimation.diagnostics if estimation.simulates else ()),
            *about_treatment(dataset),
            *(() if estimation.simulates else estimation.diagnostics),
        ),
        further=estimation.further,
        **errors,
    )


def _valid(component: FrictionModel, values: Mapping[str, float], kind: Kind) -> Model:
    """Return the friction model with its values, refused where a model file with them could not be read again."""
    try:
        written = {name: variable.written(values[name]) for name, variable in component.variables.items()}
        return make_model(component, written, kind=kind, validate=True)
    except InputError as error:
        raise InputError(
            f"the best fit of {component.name} is not what the model allows: {error.path} {error.message}",
            path="model",
            value=component.name,
            mend=f"Fit another model to this log. {error.mend}".strip(),
        ) from None
