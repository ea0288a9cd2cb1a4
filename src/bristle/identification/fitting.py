"""The fit of one model: values with uncertainty, held-out error, and parameters that the log does not identify."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.diagnostic import UNFINISHED, Diagnostic, Number
from bristle.core.edge import between
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.normal import NORMAL_95
from bristle.core.variable import Kind, Variable, unit_of
from bristle.engine.checks import finite
from bristle.identification import structure
from bristle.identification.element_models import estimate_elements
from bristle.identification.estimate import MATTERS, Estimate
from bristle.identification.estimation import Context, Estimation, Estimator, along_the_motion
from bristle.identification.excitation import Excitation
from bristle.identification.fixed_shape import ELEMENT_MODELS, TOTAL, ShapedModel
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import (
    OFFSET,
    Fixed,
    Role,
    Scales,
    acts_in_sliding,
    name_of,
    names_of,
)
from bristle.identification.problem import Contrast, Covariance, covariance_of
from bristle.identification.result import Fit, Traces
from bristle.identification.stribeck_element_models import estimate_stribeck_elements
from bristle.identification.validation import held_out_error
from bristle.models.friction import base_of, channel_slots_of
from bristle.models.friction.level import LEVELS, has_level
from bristle.models.friction.slots import variations_of
from bristle.simulation.statistics import relative_error_percent

ESTIMATED = 0.7  # share of the work for the fit to the whole log


ELEMENTS: dict[FrictionModel, Estimator] = dict(
    zip(ELEMENT_MODELS, (estimate_elements, estimate_stribeck_elements), strict=True)
)
"""Estimators of models whose lists are found by variable projection."""


def fit(
    context: Context, component: FrictionModel, blocks: int, report: Report
) -> tuple[Fit, Estimation]:
    """Fit one model, with `blocks` parts of the log held out in turn; return the fit and its estimation."""
    report(0.0)
    context = context.of(component)
    estimation = _estimate(context, component, between(report, 0.0, ESTIMATED))
    fit, held_out, unfinished = fit_of(estimation, context), None, estimation.solution.unfinished
    if blocks and not unfinished:
        try:
            held_out = held_out_error(
                estimation, blocks, context.settings, between(report, ESTIMATED, 1.0)
            )
        except KeyboardInterrupt:
            unfinished = True
    if not unfinished:
        report(1.0)
    diagnostics = (*((UNFINISHED,) if unfinished else ()), *fit.diagnostics)
    return replace(
        fit, held_out=held_out, unfinished=unfinished, diagnostics=diagnostics
    ), estimation


def _estimate(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of one model; `report` receives the share of the work done."""
    elements = ELEMENTS.get(base_of(component))
    slots = [slot for slot in variations_of(component) if slot in LEVELS]
    if slots and not has_level(base_of(component)):
        raise InputError(
            f"has no friction level for +{slots[0]}",
            path="model",
            value=component.name,
            mend="Take coulomb_viscous",
        )
    if elements is None:
        return (context.estimator or along_the_motion)(context, component, report)
    slots += [slot.name for slot in channel_slots_of(component)]
    if slots:
        raise InputError(
            f"consists of elements, for which bristle cannot fit +{slots[0]}",
            path="model",
            value=component.name,
            mend="Fit dahl or lugre instead",
        )
    if context.estimator is not None:
        raise InputError(
            "needs inverse dynamics",
            path="model",
            value=component.name,
            mend="Write --method inverse_dynamics",
        )
    return elements(context, component, report)


def fit_of(estimation: Estimation, context: Context) -> Fit:
    """Return the fit at a solution, without its held-out error."""
    problem, solution, settings = estimation.inverse, estimation.solution, context.settings
    dataset, component = problem.dataset, problem.parameters.component
    values = problem.parameters.complete(solution.values)
    predicted = finite(problem.predicted(values), problem.model(values))
    residual, uncertainty = dataset.effort - predicted, estimation.covariance
    if uncertainty is None and estimation.simulates:
        uncertainty = covariance_of(solution, estimation.problem.residual(solution.values))
    elif uncertainty is None:
        uncertainty = covariance_of(solution, residual, problem.found_first())
    excitation = Excitation(dataset, context.scales, values, problem.parameters.variables, settings)
    effects = effects_of(problem, values, predicted, context.scales)
    estimates = Judgement(
        problem, solution, uncertainty, excitation, effects, filtered=not estimation.simulates
    ).estimates()
    error = relative_error_percent(dataset.effort, predicted)
    rows: tuple[Diagnostic, ...] = ()
    if not estimation.simulates:
        rows = (
            *structure.about_alignment(problem, solution, residual, settings),
            *structure.about_noise(problem, estimates, settings),
            *structure.about_residual(error, settings),
        )
    errors: dict[str, Any] = estimation.problem.errors(solution.values)
    names = solution.space.reported
    return Fit(
        plant=problem.plant(values),
        friction=estimation.written(_valid(component, values, dataset.kind)),
        estimates=estimates,
        combinations=combinations_of(
            component, {estimate.name: estimate for estimate in estimates}, dataset.kind
        ),
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
            *about_level(estimates, excitation),
            *rows,
            *structure.about_rise(problem, values),
            *about_fixed(problem),
            *(estimation.diagnostics if estimation.simulates else ()),
            *structure.about_treatment(dataset),
            *(() if estimation.simulates else estimation.diagnostics),
        ),
        further=estimation.further,
        **errors,
    )


def effects_of(
    problem: InverseDynamics, values: Mapping[str, float], predicted: np.ndarray, scales: Scales
) -> dict[str, float]:
    """Return the change of the effort per unit of each parameter alone, as a share of the friction force (root mean squares)."""
    parameters, friction, effects = (
        problem.parameters,
        float(np.linalg.norm(problem.friction(values))),
        dict[str, float](),
    )
    held = {
        name
        for name, entry in parameters.fixed.items()
        if not (entry.redundant or entry.half_width)
    }
    for name, variable in (
        {**parameters.plant.variables, **parameters.component.variables}
    ).items():
        if friction > 0.0 and name not in held and not variable.choices:
            step = STEP * (abs(values[name]) or scales.magnitude(variable))
            change = problem.predicted({**values, name: values[name] + step}) - predicted
            effects[name] = float(np.linalg.norm(change)) / (step * friction)
    # A force that is not finite near these values may be large.
    return {name: effect if math.isfinite(effect) else math.inf for name, effect in effects.items()}


def _valid(component: FrictionModel, values: Mapping[str, float], kind: Kind) -> Model:
    """Return the friction model with its values; reject values that a model file could not hold."""
    try:
        written = {
            name: variable.written(values[name]) for name, variable in component.variables.items()
        }
        return make_model(component, written, kind=kind, validate=True)
    except InputError as error:
        raise InputError(
            f"the best fit of {component.name} has values that the model does not allow: {error.path} {error.message}",
            path="model",
            value=component.name,
            mend=f"Fit another model to this log. {error.mend}".strip(),
        ) from None


STEP = 1e-3  # relative change of a parameter to compute its effect
GUESSED = "held_constant"  # a constant that is fixed without being given
PARTNER = {Role.FALL: Role.BREAK_AWAY, Role.BREAK_AWAY: Role.FALL}
"""The Stribeck velocity has no meaning without the break-away force, and vice versa."""


@dataclass(frozen=True)
class Judgement:
    """The judgement of each parameter of a fit to rows, `filtered` or not, from its value, uncertainty, effect and the excitation."""

    problem: InverseDynamics
    solution: Solution
    uncertainty: Covariance
    excitation: Excitation
    effects: Mapping[str, float]
    filtered: bool

    def estimates(self) -> tuple[Estimate, ...]:
        """Return every parameter, plant first."""
        estimates, kind, at_edge = (
            list[Estimate](),
            self.problem.dataset.kind,
            self.solution.at_edge,
        )
        for name, variable in self.excitation.variables.items():
            if variable.choices:
                continue
            fixed, value = self.problem.parameters.fixed.get(name), self.excitation.values[name]
            estimate = Estimate(
                name,
                variable.unit(kind),
                variable.description,
                value if fixed is None else fixed.value,
                None,
            )
            estimate = replace(estimate, effect=self.effects.get(name, math.inf))
            if fixed is not None and fixed.half_width is not None:
                std, ends = (
                    fixed.half_width / NORMAL_95,
                    (fixed.value - fixed.half_width, fixed.value + fixed.half_width),
                )
                estimates.append(replace(estimate, std=std, robust_std=std, interval=ends))
                continue
            if fixed is not None:
                reason, status = why_fixed(name, fixed, variable, kind), "held"
                if fixed.redundant:
                    reason, status = replace(reason, severity="warning"), "unidentifiable"
                estimates.append(replace(estimate, status=status, reason=reason))
                continue
            unsure = self._unsure_alone[name]
            if unsure is None and name not in at_edge:
                unsure = self._unsure_beside(name)
            if unsure is None and name in at_edge:
                estimates.append(replace(estimate, status="at_edge", reason=self._at_edge(name)))
                continue
            most = 100.0 * abs(value)  # a larger standard error has no meaning
            std, robust = (
                deviation if unsure is None or deviation <= most else None
                for deviation in self._std[name]
            )
            status = "identified" if unsure is None else "unidentifiable"
            estimates.append(
                replace(estimate, std=std, robust_std=robust, status=status, reason=unsure)
            )
        return tuple(estimates)

    @cached_property
    def _std(self) -> dict[str, tuple[float, float]]:
        """Both standard errors of each free parameter [SI]."""
        deviations = zip(
            self.uncertainty.std.tolist(), self.uncertainty.robust_std.tolist(), strict=True
        )
        return dict(zip(self.solution.values, deviations, strict=True))

    def _unsure_beside(self, name: str) -> Diagnostic | None:
        """Return why a parameter that is certain alone is uncertain with others, or None."""
        # The Stribeck velocity needs the break-away force, and vice versa. A fall that only rows near reversals show is as
        # uncertain as the stiffness there.
        variables, names = self.excitation.variables, self.solution.space.names
        role = next((role for role in PARTNER if role.fits(variables[name])), None)
        if role is None:
            return None
        unsure_count, sure_count = 0, 0
        for partner, variable in variables.items():
            if PARTNER[role].fits(variable) and partner in self.solution.values:
                is_unsure = (
                    partner in self.solution.at_edge or self._unsure_alone[partner] is not None
                )
                unsure_count, sure_count = unsure_count + is_unsure, sure_count + (not is_unsure)
            elif PARTNER[role].fits(variable):
                unsure_count += self.problem.parameters.is_redundant(partner)
        if unsure_count and not sure_count:
            return self.excitation.cause(name)
        stiff = [part for part in self.solution.values if Role.STIFFNESS.fits(variables[part])]
        if name not in names or not stiff or not self.filtered:
            return None
        fall = [
            place
            for place, part in enumerate(names)
            if any(role.fits(variables[part]) for role in PARTNER)
        ]
        away = self.problem.away
        determined = Contrast.of(self.solution, replace(away, rows=away.far)).determined
        reasons = [reason for part in stiff if (reason := self._unsure_alone[part]) is not None]
        return (
            replace(reasons[0], parameter=name)
            if not determined[fall].all() and len(reasons) == len(stiff)
            else None
        )

    @cached_property
    def _unsure_alone(self) -> dict[str, Diagnostic | None]:
        """Why each free parameter is not identifiable, apart from its partner; None if it is identifiable."""
        # The largest effort without that of the plant.
        largest = float(
            np.max(
                np.abs(
                    self.problem.dataset.effort - self.problem.mechanical(self.excitation.values)
                )
            )
        )
        return {name: self._doubt(name, largest) for name in self.solution.values}

    def _doubt(self, name: str, largest: float) -> Diagnostic | None:
        least, variable, dataset = (
            self.excitation.settings,
            self.excitation.variables[name],
            self.problem.dataset,
        )
        value, std, is_inertia = (
            self.excitation.values[name],
            max(self._std[name]),
            Role.INERTIA.fits(variable),
        )
        if self.excitation.is_hidden(name, filtered=self.filtered):
            return self.excitation.cause(name)
        component = self.problem.parameters.component
        if name == TOTAL and isinstance(component, ShapedModel):
            # Around a reversal an encoder does not show the first steps, and the elements absorb the error.
            # Replicates start from the recorded positions, and do not show its size.
            level = float(
                np.mean(
                    [
                        self.excitation.values[level]
                        for level in names_of(Role.LEVEL, self.excitation.variables)
                    ]
                )
            )
            share = component.share_within(least.zone_counts * dataset.resolution, value, level)
            if share > least.blurred_share:
                return Diagnostic(
                    "coarse_elements",
                    name,
                    "warning",
                    {
                        "percent": 100.0 * share,
                        "counts": least.zone_counts,
                        "resolution": dataset.resolution,
                    },
                    dataset.kind,
                )
        if self.filtered and is_inertia and dataset.acceleration_noise_share > least.noisy_inertia:
            return structure.noisy_inertia(dataset, name, least)
        if name in self.solution.at_edge:
            return self.excitation.cause(name) if is_inertia else None
        if acts_in_sliding(variable) and value > least.beyond_effort * largest:
            return Diagnostic("beyond_effort", name, "warning", {"effort": largest}, dataset.kind)
        # No force within this interval would matter.
        small = (
            variable.quantity == "force"
            and NORMAL_95 * std * self.effects.get(name, math.inf) <= MATTERS
        )
        if small or std <= least.unsure_std * abs(value):
            return None
        cause = self.excitation.cause(name)
        # Largest relative standard error that is reported.
        if not math.isfinite(std) or value == 0.0 or std > 10.0 * abs(value):
            return cause
        return replace(cause, numbers={**cause.numbers, "std_percent": 100.0 * std / abs(value)})

    def _at_edge(self, name: str) -> Diagnostic:
        edge, variable, kind = (
            self.solution.at_edge[name],
            self.excitation.variables[name],
            self.problem.dataset.kind,
        )
        value = self.excitation.values[name]
        numbers: dict[str, Number] = {"value": value, "unit": variable.unit(kind)}
        if edge == "smallest" and Role.BREAK_AWAY.fits(variable):
            return Diagnostic("edge_no_fall", name, "warning", numbers, kind)
        # Neither a friction level nor a damping contributes to the effort.
        roles = (Role.LEVEL, Role.BREAK_AWAY, Role.VISCOUS)
        opposing = (part for role in roles for part in names_of(role, self.excitation.variables))
        frictionless = all(
            self.solution.at_edge.get(part) == "smallest" or not self.excitation.values[part]
            for part in opposing
        )
        if edge == "smallest" and Role.LEVEL.fits(variable) and frictionless:
            numbers |= (
                {"offset_identified": 1}
                if name_of(OFFSET, self.excitation.variables) in self.solution.space.names
                else {}
            )
            return Diagnostic("no_friction", name, "warning", numbers, kind)
        cause = self.excitation.cause(name)
        numbers |= {"edge": edge, "cause": cause.code, **cause.numbers}
        bound, small = (
            variable.min if edge == "smallest" else variable.max,
            self.excitation.scales.magnitude(variable),
        )
        of_model = math.isclose(value, bound, rel_tol=1e-2, abs_tol=1e-9 * abs(small))
        return Diagnostic(
            "edge_of_model" if of_model else "edge_of_search", name, "warning", numbers, kind
        )


def why_fixed(name: str, fixed: Fixed, variable: Variable, kind: Kind) -> Diagnostic:
    """Return why a parameter is fixed, with its value."""
    value = variable.written(fixed.value) if variable.choices else fixed.value
    numbers: dict[str, Number] = {"value": value, "unit": variable.unit(kind), **fixed.numbers}
    return Diagnostic(fixed.reason, name, "note", numbers, kind)


def about_fixed(problem: InverseDynamics) -> tuple[Diagnostic, ...]:
    """Return the fixed parameters with their reasons, and warnings about a weight that was not given."""
    variables, kind = problem.parameters.variables, problem.dataset.kind
    weights, reasons = list[Diagnostic](), list[Diagnostic]()
    for name, entry in problem.parameters.fixed.items():
        if entry.half_width is None and entry.reason == GUESSED:
            weights.append(
                Diagnostic(
                    "weight_guessed", "", "warning", {"weight": entry.value, **entry.numbers}, kind
                )
            )
        if entry.half_width is None and entry.reason != "no_fall":
            reasons.append(why_fixed(name, entry, variables[name], kind))
    return (*weights, *reasons)


def about_estimates(
    estimates: Sequence[Estimate], correlation: np.ndarray, names: Sequence[str], inseparable: float
) -> tuple[Diagnostic, ...]:
    """Return diagnostics of unidentified parameters, and of pairs among `names` that are correlated."""
    reasons = [
        estimate.reason
        for estimate in estimates
        if estimate.status != "held" and estimate.reason is not None
    ]
    sure = {estimate.name for estimate in estimates if estimate.status == "identified"}
    pairs = [
        Diagnostic(
            "correlated", name, "warning", {"other": second, "correlation": float(coefficient)}
        )
        for row, name in enumerate(names)
        for second, coefficient in zip(names[:row], correlation[row], strict=False)
        if {name, second} <= sure and abs(coefficient) > inseparable
    ]
    return (*reasons, *pairs)


def about_level(estimates: Sequence[Estimate], excitation: Excitation) -> tuple[Diagnostic, ...]:
    """Return a warning if a friction level is identified without a dependence of friction on speed."""
    variables = excitation.variables
    names = {estimate.name for estimate in estimates if estimate.status in ("identified", "held")}
    curve = [name for role in (Role.FALL, Role.VISCOUS) for name in names_of(role, variables)]
    levels = tuple(name for name in names_of(Role.LEVEL, variables) if name in names)
    if not levels or not names_of(Role.FALL, variables) or not names.isdisjoint(curve):
        return ()
    return (
        Diagnostic(
            "level_as_seen",
            levels[0],
            "warning",
            {"names": levels, "speed": excitation.scales.speed},
            excitation.dataset.kind,
        ),
    )


def combinations_of(
    component: FrictionModel, by_name: Mapping[str, Estimate], kind: Kind
) -> tuple[Estimate, ...]:
    """Return the products of each redundant parameter with the parameters that it multiplies."""
    combinations = []
    for redundancy in component.redundancies:
        factor = by_name[redundancy.name]
        for name in redundancy.factor_of:
            member = by_name[name]
            unit = unit_of(
                "*".join(component.variables[part].quantity for part in (factor.name, name)), kind
            )
            std, robust = (
                None if deviation is None else abs(factor.value) * deviation
                for deviation in (member.std, member.robust_std)
            )
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
