"""From a solution to a `Fit`: values with their uncertainty, and what the log does not tell."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.engine.part import finite
from bristle.identification.covariance import covariance_of
from bristle.identification.diagnostics.estimates import Judgement, about_estimates, about_held, combinations_of
from bristle.identification.diagnostics.excitation import Excitation
from bristle.identification.diagnostics.noise import about_held_effort, about_noise
from bristle.identification.diagnostics.repetition import about_amplitudes
from bristle.identification.diagnostics.residual import about_residual, about_rise
from bristle.identification.diagnostics.treatment import about_treatment
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import Scales
from bristle.identification.result import Fit, Traces
from bristle.identification.settings import DEFAULT, Settings
from bristle.identification.solution import Solution
from bristle.simulation.result import relative_error_percent

__all__ = ["fit_of"]


def fit_of(
    problem: InverseDynamics, solution: Solution, scales: Scales, residual: np.ndarray | None = None,
    simulated: Diagnostic | None = None, settings: Settings = DEFAULT,
) -> Fit:  # fmt: skip
    """Return the fit at a solution, all but its error on held-out blocks.

    Parameters
    ----------
    problem : InverseDynamics
        Inverse dynamics of the model.
    solution : Solution
        Where the search ended.
    scales : Scales
        Typical magnitudes of the log.
    residual : ndarray, optional
        What the solution made small, where that is not the error of the effort of each row.
    simulated : Diagnostic, optional
        What that is.
    settings : Settings
        The thresholds.
    """
    dataset, component = problem.dataset, problem.parameters.component
    values = problem.parameters.complete(solution.values)
    predicted = finite(problem.predicted(values), problem.model(values))
    uncertainty = covariance_of(solution, dataset.effort - predicted if residual is None else residual)
    excitation = Excitation(dataset, scales, values, problem.parameters.variables, settings)
    estimates = Judgement(problem, solution, uncertainty, excitation, filtered=residual is None).estimates()
    names = tuple(solution.values)
    error = relative_error_percent(dataset.effort, predicted)
    rows: tuple[Diagnostic, ...] = ()
    if residual is None:
        rows = (
            *about_held_effort(problem, estimates, settings), *about_noise(problem, settings),
            *about_residual(problem, values, error, settings),
        )  # fmt: skip
    return Fit(
        plant=problem.plant(values),
        friction=_valid(component, values, dataset.kind),
        estimates=estimates,
        combinations=combinations_of(component, {one.name: one for one in estimates}),
        correlation=uncertainty.correlation,
        correlation_names=names,
        condition_number=uncertainty.condition_number,
        traces=Traces(
            dataset.time,
            dataset.velocity,
            dataset.acceleration,
            dataset.effort,
            predicted,
            problem.mechanical(values),
        ),
        force_error_percent=error,
        diagnostics=(
            *about_estimates(estimates, uncertainty.correlation, names, settings.inseparable),
            *rows,
            *about_rise(problem, values),
            *about_amplitudes(dataset, problem.model(values), settings),
            *about_held(problem),
            *((simulated,) if simulated is not None else ()),
            *about_treatment(dataset),
        ),
    )


def _valid(component: FrictionModel, values: Mapping[str, float], kind: Kind) -> Model:
    """Return the friction model with its values, refused where a model file with them could not be read again."""
    try:
        written = {name: variable.written(values[name]) for name, variable in component.variables.items()}
        return make_model(component, written, kind=kind, validate=True)
    except InputError as error:
        raise InputError(
            f"the best fit of {component.name} is not what the model allows: {error.path} {error.message}",
            path="model", value=component.name,
            mend=f"Fit another model to this log. {error.mend}".strip(),
        ) from None  # fmt: skip
