"""Which parameters of a fit are identified, and why the others are not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.normal import NORMAL_95
from bristle.core.variable import Kind, Variable, unit_of
from bristle.identification.contrast import Contrast
from bristle.identification.excitation import Excitation
from bristle.identification.fixed_shape import TOTAL, ShapedModel
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed, Role, acts_in_sliding, names_of
from bristle.identification.problem import Covariance
from bristle.identification.result import Estimate
from bristle.identification.structure import noisy_inertia

__all__ = ["Judgement", "about_estimates", "about_fixed", "about_level", "combinations_of"]

STATED_UP_TO = 10.0  # relative standard error that is worth a number
GUESSED = "held_constant"  # a constant that is held without that anybody told it
PARTNER = {Role.FALL: Role.BREAK_AWAY, Role.BREAK_AWAY: Role.FALL}
"""What a velocity is that friction falls with says nothing without the force that it falls from, and so the force."""


@dataclass(frozen=True)
class Judgement:
    """What one fit tells of each parameter: where it ended, how sure that is, and what the log shows.

    The rows that were fitted are `filtered`, or not.
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

    @property
    def _kind(self) -> Kind:
        return self.problem.dataset.kind

    def _estimate(self, name: str) -> Estimate:
        variable, fixed = self.excitation.variables[name], self.problem.parameters.fixed.get(name)
        estimate = Estimate(name, variable.unit(self._kind), variable.description, self.excitation.values[name], None)
        if fixed is not None and fixed.half_width is not None:
            std, ends = fixed.half_width / NORMAL_95, (fixed.value - fixed.half_width, fixed.value + fixed.half_width)
            return replace(estimate, value=fixed.value, std=std, robust_std=std, interval=ends)
        if fixed is not None:
            reason, status = why_fixed(name, fixed, variable, self._kind), "held"
            if fixed.redundant:
                reason, status = replace(reason, severity="warning"), "unidentifiable"
            return replace(estimate, value=fixed.value, status=status, reason=reason)
        unsure = self._unsure(name)
        if unsure is None and name in self.solution.at_edge:
            return replace(estimate, status="at_edge", reason=self._at_edge(name))
        most = self.excitation.settings.hopeless_std * abs(estimate.value)
        std, robust = (deviation if unsure is None or deviation <= most else None for deviation in self._std[name])
        status = "identified" if unsure is None else "unidentifiable"
        return replace(estimate, std=std, robust_std=robust, status=status, reason=unsure)

    def _unsure(self, name: str) -> Diagnostic | None:
        """Return why a parameter cannot be identified; None where it can."""
        alone = self._unsure_alone(name)
        if alone is not None or name in self.solution.at_edge:
            return alone
        if self._lacks_its_partner(name):
            return self.excitation.cause(name)
        return self._hidden_by_reversals(name)

    def _unsure_alone(self, name: str) -> Diagnostic | None:
        """Return the same, whatever is known of the parameter that it goes with."""
        least, variable = self.excitation.settings, self.excitation.variables[name]
        value, std = self.excitation.values[name], max(self._std[name])
        if self.excitation.is_hidden(name, filtered=self.filtered):
            return self.excitation.cause(name)
        if (blurred := self._blurred(name)) is not None:
            return blurred
        dataset = self.problem.dataset
        if self.filtered and Role.INERTIA.fits(variable) and dataset.acceleration_noise_share > least.noisy_inertia:
            return noisy_inertia(dataset, name, least)
        if name in self.solution.at_edge:
            return self.excitation.cause(name) if Role.INERTIA.fits(variable) else None
        if acts_in_sliding(variable) and value > least.beyond_effort * self._most_of_friction:
            return Diagnostic("beyond_effort", name, "warning", {"effort": self._most_of_friction}, self._kind)
        # No value of a constant force within its error would matter.
        rms_effort = float(np.sqrt(np.mean(self.problem.dataset.effort**2)))
        small = variable.quantity == "force" and std < least.negligible_force * rms_effort
        if small or std <= least.unsure_std * abs(value):
            return None
        cause = self.excitation.cause(name)
        if not math.isfinite(std) or value == 0.0 or std > STATED_UP_TO * abs(value):
            return cause
        return replace(cause, numbers={**cause.numbers, "std_percent": 100.0 * std / abs(value)})

    @cached_property
    def _most_of_friction(self) -> float:
        """The largest part of the effort that the plant does not take [N or N*m]."""
        return float(np.max(np.abs(self.problem.dataset.effort - self.problem.mechanical(self.excitation.values))))

    def _blurred(self, name: str) -> Diagnostic | None:
        """Return that elements which slip within a few encoder steps make up the stiffness of all; None otherwise.

        Around a reversal an encoder shows nothing of the first steps: elements take up what it leaves out. Replicates
        begin from what it has shown, and do not tell by how much.
        """
        component, least = self.problem.parameters.component, self.excitation.settings
        if name != TOTAL or not isinstance(component, ShapedModel):
            return None
        values, resolution = self.excitation.values, self.problem.dataset.resolution
        level = float(np.mean([values[level] for level in names_of(Role.LEVEL, self.excitation.variables)]))
        share = component.share_within(least.zone_counts * resolution, values[name], level)
        if share <= least.blurred_share:
            return None
        numbers = {"percent": 100.0 * share, "counts": least.zone_counts, "resolution": resolution}
        return Diagnostic("coarse_elements", name, "warning", numbers, self._kind)

    def _lacks_its_partner(self, name: str) -> bool:
        """Return whether a velocity tells how a force falls, or a force from where, and no such partner is known."""
        variables = self.excitation.variables
        role = next((role for role in PARTNER if role.fits(variables[name])), None)
        if role is None:
            return False
        partners = [partner for partner, variable in variables.items() if PARTNER[role].fits(variable)]
        unknown = [partner for partner in partners if self.problem.parameters.is_redundant(partner)]
        free = [partner for partner in partners if partner in self.solution.values]
        unknown += [partner for partner in free if partner in self.solution.at_edge or self._unsure_alone(partner) is not None]
        return bool(unknown) and set(free) <= set(unknown)

    def _hidden_by_reversals(self, name: str) -> Diagnostic | None:
        """Return why a fall of friction is not seen: by rows near reversals only, whose stiffness is not either."""
        variables, names = self.excitation.variables, self.solution.space.names
        fall = [part for part in names if any(role.fits(variables[part]) for role in PARTNER)]
        stiff = [part for part in self.solution.values if Role.STIFFNESS.fits(variables[part])]
        if name not in fall or not stiff or not self.filtered:
            return None
        if all(self._tells_away[names.index(part)] for part in fall):
            return None
        reasons = [reason for reason in map(self._unsure_alone, stiff) if reason is not None]
        return replace(reasons[0], parameter=name) if len(reasons) == len(stiff) else None

    @cached_property
    def _tells_away(self) -> np.ndarray:
        """Which coordinates rows far from reversals tell nearly as well as all do."""
        away, free = self.problem.away, np.ones(len(self.solution.space.names), dtype=bool)
        return Contrast.of(self.solution, replace(away, rows=away.far), free).determined

    @cached_property
    def _opposes_nothing(self) -> bool:
        """Whether neither a level of friction nor a damping takes any effort."""
        roles, variables = (Role.LEVEL, Role.BREAK_AWAY, Role.VISCOUS), self.excitation.variables
        names = (name for role in roles for name in names_of(role, variables))
        return all(self.solution.at_edge.get(name) == "smallest" or not self.excitation.values[name] for name in names)

    def _at_edge(self, name: str) -> Diagnostic:
        edge, variable = self.solution.at_edge[name], self.excitation.variables[name]
        value = self.excitation.values[name]
        numbers: dict[str, Number] = {"value": value, "unit": variable.unit(self._kind)}
        if edge == "smallest" and Role.BREAK_AWAY.fits(variable):
            return Diagnostic("edge_no_fall", name, "warning", numbers, self._kind)
        if edge == "smallest" and Role.LEVEL.fits(variable) and self._opposes_nothing:
            return Diagnostic("no_friction", name, "warning", numbers, self._kind)
        cause = self.excitation.cause(name)
        numbers |= {"edge": edge, "cause": cause.code, **cause.numbers}
        bound, small = variable.min if edge == "smallest" else variable.max, self.excitation.scales.magnitude(variable)
        of_model = math.isclose(value, bound, rel_tol=1e-2, abs_tol=1e-9 * abs(small))
        return Diagnostic("edge_of_model" if of_model else "edge_of_search", name, "warning", numbers, self._kind)


def why_fixed(name: str, fixed: Fixed, variable: Variable, kind: Kind) -> Diagnostic:
    """Return why a parameter is fixed, with its value."""
    value = variable.written(fixed.value) if variable.choices else fixed.value
    numbers: dict[str, Number] = {"value": value, "unit": variable.unit(kind), **fixed.numbers}
    return Diagnostic(fixed.reason, name, "note", numbers, kind)


def about_fixed(problem: InverseDynamics) -> tuple[Diagnostic, ...]:
    """Return which parameters were fixed, and why; a weight that nobody told is a doubt of what holds beside it."""
    variables, kind = problem.parameters.variables, problem.dataset.kind
    fixed = {name: entry for name, entry in problem.parameters.fixed.items() if entry.half_width is None}
    weights = [entry for entry in fixed.values() if entry.reason == GUESSED]
    return (
        *(Diagnostic("weight_guessed", "", "warning", {"weight": entry.value, **entry.numbers}, kind) for entry in weights),
        *(why_fixed(name, entry, variables[name], kind) for name, entry in fixed.items() if entry.reason != "no_fall"),
    )


def about_estimates(
    estimates: Sequence[Estimate], correlation: np.ndarray, names: Sequence[str], inseparable: float
) -> tuple[Diagnostic, ...]:
    """Return what is to be known of parameters: those not identified, and pairs of these `names` that go together."""
    reasons = [estimate.reason for estimate in estimates if estimate.status != "held" and estimate.reason is not None]
    sure = {estimate.name for estimate in estimates if estimate.status == "identified"}
    pairs = [
        Diagnostic("correlated", name, "warning", {"other": second, "correlation": float(coefficient)})
        for row, name in enumerate(names)
        for second, coefficient in zip(names[:row], correlation[row], strict=False)
        if {name, second} <= sure and abs(coefficient) > inseparable
    ]
    return (*reasons, *pairs)


def about_level(estimates: Sequence[Estimate], excitation: Excitation) -> tuple[Diagnostic, ...]:
    """Return a warning where a level of friction is told, and nothing of how friction falls or rises with speed."""
    variables = excitation.variables
    names = {estimate.name for estimate in estimates if estimate.status in ("identified", "held")}
    curve = [name for role in (Role.FALL, Role.VISCOUS) for name in names_of(role, variables)]
    levels = tuple(name for name in names_of(Role.LEVEL, variables) if name in names)
    if not levels or not names_of(Role.FALL, variables) or not names.isdisjoint(curve):
        return ()
    numbers: dict[str, Number] = {"names": levels, "speed": excitation.scales.speed}
    return (Diagnostic("level_as_seen", levels[0], "warning", numbers, excitation.dataset.kind),)


def combinations_of(component: FrictionModel, by_name: Mapping[str, Estimate], kind: Kind) -> tuple[Estimate, ...]:
    """Return the products of a redundant parameter with each one that it is a factor of."""
    combinations = []
    for redundancy in component.redundancies:
        factor = by_name[redundancy.name]
        for name in redundancy.factor_of:
            member = by_name[name]
            unit = unit_of("*".join(component.variables[part].quantity for part in (factor.name, name)), kind)
            std, robust = (None if deviation is None else abs(factor.value) * deviation for deviation in (member.std, member.robust_std))
            combinations.append(
                Estimate(
                    f"{factor.name}*{name}",
                    unit,
                    f"product of {factor.name} and {name}",
                    factor.value * member.value,
                    std,
                    member.status,
                    member.reason,
                    robust,
                )
            )
    return tuple(combinations)
