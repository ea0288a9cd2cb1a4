"""From a solution to a `Fit`: values with their uncertainty, and in words what the log does not tell."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.variable import Kind, Variable
from bristle.engine.part import finite
from bristle.identification.covariance import Covariance, covariance_of
from bristle.identification.excitation import out_of_sight, why_unidentifiable
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import Scales
from bristle.identification.repetition import about_amplitudes
from bristle.identification.residual import about_held_effort, about_noise, about_residual, about_rise
from bristle.identification.result import Estimate, Fit, Traces
from bristle.identification.solution import Solution
from bristle.simulation.result import relative_error_percent

__all__ = ["fit_of"]

UNSURE = 0.5  # relative standard error above which a parameter counts as unidentifiable
NEGLIGIBLE = 0.02  # share of the effort below which the error of a constant force does not matter
BEYOND = 1.2  # of the largest effort: a friction force that never acted, the filter allowed for
HOPELESS = 100.0  # relative standard error above which no number is given
INSEPARABLE = 0.99  # correlation


def fit_of(
    problem: InverseDynamics, solution: Solution, scales: Scales, residual: np.ndarray | None = None, small: str = ""
) -> Fit:
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
    small : str
        The same in words.
    """
    dataset, component = problem.dataset, problem.parameters.component
    values = problem.parameters.complete(solution.values)
    predicted = finite(problem.predicted(values), problem.model(values))
    uncertainty = covariance_of(solution, dataset.effort - predicted if residual is None else residual)
    estimates = _Findings(problem, solution, scales, uncertainty, values, filtered=residual is None).estimates()
    names = tuple(solution.values)
    error = relative_error_percent(dataset.effort, predicted)
    about = (*about_rise(problem, values), *about_amplitudes(dataset, problem.model(values)))
    if residual is None:
        rows = about_held_effort(problem, estimates), about_noise(problem), about_residual(problem, values, error)
        about = (*(told for one in rows for told in one), *about)
    return Fit(
        plant=problem.plant(values),
        friction=_valid(component, values, dataset.kind),
        estimates=estimates,
        combinations=_combinations(component, {one.name: one for one in estimates}),
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
        warnings=(*_warnings(estimates, uncertainty, names), *about),
        assumptions=_assumptions(problem, small),
    )


def _combinations(component: FrictionModel, known: Mapping[str, Estimate]) -> tuple[Estimate, ...]:
    """Return the products of a redundant parameter with each one that it is a factor of."""
    found = []
    for redundancy in component.redundancies:
        factor = known[redundancy.name]
        for name in redundancy.factor_of:
            other = known[name]
            unit = "*".join(one for one in (factor.unit, other.unit) if one != "1") or "1"
            std, robust = (None if one is None else abs(factor.value) * one for one in (other.std, other.robust_std))
            found.append(Estimate(
                f"{factor.name}*{name}", unit, f"product of {factor.name} and {name}", factor.value * other.value, std,
                other.status, other.note, robust,
            ))  # fmt: skip
    return tuple(found)


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


class _Findings:
    """Judges each parameter of one fit."""

    def __init__(
        self, problem: InverseDynamics, solution: Solution, scales: Scales, uncertainty: Covariance,
        values: dict[str, float], *, filtered: bool,
    ) -> None:  # fmt: skip
        self.problem, self.solution, self.scales, self.values = problem, solution, scales, values
        self.filtered = filtered
        self.variables = problem.parameters.variables
        self.kind: Kind = problem.dataset.kind
        free = tuple(solution.values)
        self.std = dict(zip(free, uncertainty.std.tolist(), strict=True))
        self.robust_std = dict(zip(free, uncertainty.robust_std.tolist(), strict=True))
        self.effort = float(np.sqrt(np.mean(problem.dataset.effort**2)))

    def estimates(self) -> tuple[Estimate, ...]:
        """Return every parameter, plant first."""
        return tuple(self._estimate(name) for name, variable in self.variables.items() if not variable.choices)

    def _estimate(self, name: str) -> Estimate:
        variable, held = self.variables[name], self.problem.parameters.fixed.get(name)
        unit, value = variable.unit(self.kind), self.values[name]
        if held is not None:
            status = "unidentifiable" if held.redundant else "held"
            return Estimate(name, unit, variable.description, held.value, None, status, held.note)
        unsure = self._why_unsure(name)
        if not unsure and name in self.solution.at_edge:
            return Estimate(name, unit, variable.description, value, None, "at_edge", self._why_at_edge(name))
        status = "unidentifiable" if unsure else "identified"
        std, robust = (
            one[name] if not unsure or one[name] <= HOPELESS * abs(value) else None
            for one in (self.std, self.robust_std)
        )
        return Estimate(name, unit, variable.description, value, std, status, unsure, robust)

    def _why_unsure(self, name: str) -> str:
        """Return why a parameter cannot be identified, or nothing where it can."""
        value, std = self.values[name], max(self.std[name], self.robust_std[name])
        if out_of_sight(*self._context(name), filtered=self.filtered):
            return self._why(name)
        if name in self.solution.at_edge:
            return self._why(name) if name == "M" else ""
        if self._lacks_its_force(name):
            return self._why(name)
        if self._is("force", name) and value > BEYOND * self.scales.peak:
            peak = with_unit(self.scales.peak, self.variables[name].unit(self.kind))
            return f"the best value is far beyond the largest effort of the log, {peak}"
        if std <= UNSURE * abs(value) or self._known_to_be_small(name, std):
            return ""
        return self._why(name) + self._how_unsure(value, std)

    def _lacks_its_force(self, name: str) -> bool:
        """Return whether a velocity tells how a force falls, and no such force is known."""
        if not self._is("length/time", name):
            return False
        forces = [one for one in self.solution.values if self._is("force", one)]
        return bool(forces) and all(one in self.solution.at_edge or self._why_unsure(one) for one in forces)

    def _is(self, quantity: str, name: str) -> bool:
        """Return whether a parameter of the Stribeck curve is of this quantity."""
        return (self.variables[name].excitation, self.variables[name].quantity) == ("stribeck", quantity)

    @staticmethod
    def _how_unsure(value: float, std: float) -> str:
        if not math.isfinite(std) or value == 0.0 or std > 10.0 * abs(value):
            return ""
        return f"; standard error {100.0 * std / abs(value):.0f} %, with residuals correlated over time"

    def _why(self, name: str) -> str:
        return why_unidentifiable(*self._context(name))

    def _context(self, name: str) -> tuple[Any, ...]:
        return self.variables[name], self.problem.dataset, self.scales, self.values, self.variables

    def _known_to_be_small(self, name: str, std: float) -> bool:
        """Return whether a constant force is known to be small: no value within its error would matter."""
        return self.variables[name].quantity == "force" and std < NEGLIGIBLE * self.effort

    def _why_at_edge(self, name: str) -> str:
        edge, variable = self.solution.at_edge[name], self.variables[name]
        told = with_unit(self.values[name], variable.unit(self.kind))
        if edge == "smallest" and variable.excitation == "stribeck" and variable.quantity == "force":
            return (
                f"the best value is the smallest that is allowed, {told}: in this log friction does not fall with speed"
            )
        bound = variable.min if edge == "smallest" else variable.max
        if math.isclose(self.values[name], bound, rel_tol=1e-2, abs_tol=1e-9 * abs(self.scales.magnitude(variable))):
            return f"the best value is the {edge} that is allowed, {told}; {self._why(name)}"
        return f"the search ran to the {edge} value that this log could show, {told}: {self._why(name)}"


def _told(value: float, variable: Variable, kind: Kind) -> str:
    return variable.written(value) if variable.choices else with_unit(value, variable.unit(kind))


def _warnings(estimates: tuple[Estimate, ...], uncertainty: Covariance, names: tuple[str, ...]) -> tuple[str, ...]:
    found = []
    for estimate in estimates:
        if estimate.status == "unidentifiable":
            found.append(f"{estimate.name} cannot be identified: {estimate.note}")
        elif estimate.status == "at_edge":
            found.append(f"{estimate.name} has no standard error: {estimate.note}")
    sure = {estimate.name for estimate in estimates if estimate.status == "identified"}
    for row, one in enumerate(names):
        for column, other in enumerate(names[:row]):
            both = uncertainty.correlation[row, column]
            if {one, other} <= sure and abs(both) > INSEPARABLE:
                found.append(f"{other} and {one} can hardly be told apart in this log (correlation {both:.3f})")
    return tuple(found)


def _assumptions(problem: InverseDynamics, small: str) -> tuple[str, ...]:
    dataset, variables = problem.dataset, problem.parameters.variables
    found = [
        f"{name} is held at {_told(held.value, variables[name], dataset.kind)}: {held.note}"
        for name, held in problem.parameters.fixed.items()
    ]
    found += [small] if small else []
    rows = "a row for each sample" if dataset.decimation == 1 else f"one row for {dataset.decimation} samples"
    found.append(
        f"position, effort and friction filtered at {dataset.cutoff:g} Hz without phase, {dataset.dropped} "
        f"samples dropped at each edge, {rows}"
    )
    if dataset.delay:
        found.append(
            f"the effort lags the position by {with_unit(dataset.delay, 's')} "
            f"({dataset.delay / dataset.sample_time:.2f} samples), found where simple friction explains it best"
        )
    if dataset.rest_share > 0.0 and not dataset.keeps_rests:
        found.append(
            f"{100.0 * dataset.rest_share:.3g} % of the samples are at rest and left out: there friction balances "
            "whatever effort there is"
        )
    found.append(
        "standard errors take the residuals for independent; intervals rest on those that hold for residuals "
        "correlated over time, where these are larger"
    )
    return tuple(found)
