"""Which parameters of a fit are identified, and why the others are not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind, Variable, unit_of
from bristle.identification.covariance import Covariance
from bristle.identification.diagnostics.excitation import Excitation
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed
from bristle.identification.result import Estimate
from bristle.identification.roles import Role

__all__ = ["Judgement", "about_estimates", "about_held", "combinations_of"]

STATED_UP_TO = 10.0  # relative standard error that is worth a number


@dataclass(frozen=True)
class Judgement:
    """What one fit tells of each parameter.

    Parameters
    ----------
    problem, solution, uncertainty : InverseDynamics, Solution, Uncertainty
        What was fitted, where it ended, and how sure that is.
    excitation : Excitation
        What the log shows, with the values of the fit and the thresholds.
    filtered : bool
        Whether the rows that were fitted are filtered.
    """

    problem: InverseDynamics
    solution: Solution
    uncertainty: Covariance
    excitation: Excitation
    filtered: bool

    def estimates(self) -> tuple[Estimate, ...]:
        """Return every parameter, plant first."""
        variables = self.excitation.variables
        return tuple(self._estimate(name) for name, variable in variables.items() if not variable.choices)

    @cached_property
    def _std(self) -> dict[str, tuple[float, float]]:
        """Both standard errors of each free parameter [SI]."""
        deviations = zip(self.uncertainty.std.tolist(), self.uncertainty.robust_std.tolist(), strict=True)
        return dict(zip(self.solution.values, deviations, strict=True))

    @cached_property
    def _rms_effort(self) -> float:
        return float(np.sqrt(np.mean(self.problem.dataset.effort**2)))

    @property
    def _kind(self) -> Kind:
        return self.problem.dataset.kind

    def _estimate(self, name: str) -> Estimate:
        variable, held = self.excitation.variables[name], self.problem.parameters.fixed.get(name)
        estimate = Estimate(name, variable.unit(self._kind), variable.description, self.excitation.values[name], None)
        if held is not None:
            reason = held_because(name, held, variable, self._kind)
            if not held.redundant:
                return replace(estimate, value=held.value, status="held", reason=reason)
            return replace(
                estimate, value=held.value, status="unidentifiable", reason=replace(reason, severity="warning")
            )
        unsure = self._unsure(name)
        if unsure is None and name in self.solution.at_edge:
            return replace(estimate, status="at_edge", reason=self._at_edge(name))
        most = self.excitation.settings.hopeless_std * abs(estimate.value)
        std, robust = (deviation if unsure is None or deviation <= most else None for deviation in self._std[name])
        status = "identified" if unsure is None else "unidentifiable"
        return replace(estimate, std=std, robust_std=robust, status=status, reason=unsure)

    def _unsure(self, name: str) -> Diagnostic | None:
        """Return why a parameter cannot be identified; None where it can."""
        least, value, std = self.excitation.settings, self.excitation.values[name], max(self._std[name])
        if self.excitation.is_hidden(name, filtered=self.filtered):
            return self.excitation.cause(name)
        if name in self.solution.at_edge:
            return self.excitation.cause(name) if Role.INERTIA.fits(self.excitation.variables[name]) else None
        if self._lacks_its_force(name):
            return self.excitation.cause(name)
        peak = self.excitation.scales.peak
        if self._is_stribeck("force", name) and value > least.beyond_effort * peak:
            return Diagnostic("beyond-effort", name, "warning", {"effort": peak}, self._kind)
        if std <= least.unsure_std * abs(value) or self._known_to_be_small(name, std):
            return None
        cause = self.excitation.cause(name)
        if not math.isfinite(std) or value == 0.0 or std > STATED_UP_TO * abs(value):
            return cause
        return replace(cause, numbers={**cause.numbers, "std_percent": 100.0 * std / abs(value)})

    def _lacks_its_force(self, name: str) -> bool:
        """Return whether a velocity tells how a force falls, and no such force is known."""
        if not self._is_stribeck("length/time", name):
            return False
        forces = [name for name in self.solution.values if self._is_stribeck("force", name)]
        return bool(forces) and all(
            force_name in self.solution.at_edge or self._unsure(force_name) is not None for force_name in forces
        )

    def _is_stribeck(self, quantity: str, name: str) -> bool:
        """Return whether a parameter of the Stribeck curve is of this quantity."""
        variable = self.excitation.variables[name]
        return (variable.excitation, variable.quantity) == ("stribeck", quantity)

    def _known_to_be_small(self, name: str, std: float) -> bool:
        """Return whether a constant force is known to be small: no value within its error would matter."""
        least = self.excitation.settings.negligible_force * self._rms_effort
        return self.excitation.variables[name].quantity == "force" and std < least

    def _at_edge(self, name: str) -> Diagnostic:
        edge, variable, value = (
            self.solution.at_edge[name], self.excitation.variables[name], self.excitation.values[name],
        )  # fmt: skip
        numbers: dict[str, Number] = {"value": value, "unit": variable.unit(self._kind)}
        if edge == "smallest" and self._is_stribeck("force", name):
            return Diagnostic("edge-no-fall", name, "warning", numbers, self._kind)
        cause = self.excitation.cause(name)
        numbers |= {"edge": edge, "cause": cause.code, **cause.numbers}
        bound, small = variable.min if edge == "smallest" else variable.max, self.excitation.scales.magnitude(variable)
        if math.isclose(value, bound, rel_tol=1e-2, abs_tol=1e-9 * abs(small)):
            return Diagnostic("edge-of-model", name, "warning", numbers, self._kind)
        return Diagnostic("edge-of-search", name, "warning", numbers, self._kind)


def held_because(name: str, held: Fixed, variable: Variable, kind: Kind) -> Diagnostic:
    """Return why a parameter is held, with its value."""
    value = variable.written(held.value) if variable.choices else held.value
    numbers: dict[str, Number] = {"value": value, "unit": variable.unit(kind), **held.numbers}
    return Diagnostic(held.reason, name, "note", numbers, kind)


def about_held(problem: InverseDynamics) -> tuple[Diagnostic, ...]:
    """Return which parameters were held, and why."""
    variables, kind = problem.parameters.variables, problem.dataset.kind
    return tuple(held_because(name, held, variables[name], kind) for name, held in problem.parameters.fixed.items())


def about_estimates(
    estimates: Sequence[Estimate], correlation: np.ndarray, names: Sequence[str], inseparable: float
) -> tuple[Diagnostic, ...]:
    """Return what is to be known of parameters: those that are not identified, and pairs that go together.

    Parameters
    ----------
    estimates : sequence of Estimate
        The parameters.
    correlation, names : ndarray, sequence of str
        Correlation of those of these names.
    inseparable : float
        Correlation above which two go together.
    """
    diagnostics = [
        estimate.reason for estimate in estimates if estimate.status != "held" and estimate.reason is not None
    ]
    sure = {estimate.name for estimate in estimates if estimate.status == "identified"}
    for row, name in enumerate(names):
        for column, second in enumerate(names[:row]):
            coefficient = float(correlation[row, column])
            if {name, second} <= sure and abs(coefficient) > inseparable:
                diagnostics.append(
                    Diagnostic("correlated", name, "warning", {"other": second, "correlation": coefficient})
                )
    return tuple(diagnostics)


def combinations_of(
    component: FrictionModel, by_name: Mapping[str, Estimate], kind: Kind
) -> tuple[Estimate, ...]:  # fmt: skip
    """Return the products of a redundant parameter with each one that it is a factor of."""
    combinations = []
    for redundancy in component.redundancies:
        factor = by_name[redundancy.name]
        for name in redundancy.factor_of:
            member = by_name[name]
            unit = unit_of("*".join(component.variables[part].quantity for part in (factor.name, name)), kind)
            std, robust = (
                None if deviation is None else abs(factor.value) * deviation
                for deviation in (member.std, member.robust_std)
            )
            combinations.append(Estimate(
                f"{factor.name}*{name}", unit, f"product of {factor.name} and {name}", factor.value * member.value, std,
                member.status, member.reason, robust,
            ))  # fmt: skip
    return tuple(combinations)
