"""The estimation of one model, repeatable on other rows or data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from bristle.core.axis import Axis, Cogging
from bristle.core.contracts import FrictionModel, Model, Plant
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.least_squares import apart_from, unbounded
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.identification.dataset import Dataset
from bristle.identification.elasticity import Elastic
from bristle.identification.excitation import Excitation
from bristle.identification.found_terms import Beside
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import (
    EVALUATIONS,
    Report,
    Search,
    Sliding,
    linear,
    silent,
)
from bristle.identification.missing_force import Missing
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import (
    Fixed,
    ParameterSet,
    PriorKnowledge,
    Role,
    Scales,
    acts_in_sliding,
    names_of,
    offset_of,
    parameters_of,
    scales_of,
)
from bristle.identification.problem import Covariance, Problem, Sought
from bristle.identification.settings import DEFAULT, Settings
from bristle.models.friction import find, is_static
from bristle.models.friction.next_model import nested_in
from bristle.models.friction.slots import by_direction
from bristle.models.friction.variation import PITCH
from bristle.models.plants.terms import DEGREES, TURNS, TermedPlant, with_terms


@dataclass(frozen=True)
class Context:
    """Data that the fits of all models to one log share."""

    dataset: Dataset
    prior: PriorKnowledge
    sliding: Sliding  # friction of the log from a linear fit
    scales: Scales  # typical magnitudes
    settings: Settings = DEFAULT
    estimator: Estimator | None = None  # replaces `along_the_motion`
    coupling: Elastic | None = None
    beside: Beside | None = None  # the terms beside friction, out of the effort or in a slot
    # Of simpler models: starts of richer models.
    optima: dict[FrictionModel, dict[str, float]] = field(default_factory=dict)

    def of(self, component: FrictionModel) -> Context:
        """Return the context for a model: rows without the terms that are no part of it, and the pitch of a screw if it needs one."""
        context = self
        if self.beside is not None:
            context = replace(self, dataset=self.beside.dataset_for(component, self.dataset))
        return with_pitch(context, component)

    def parameters(self, component: FrictionModel) -> ParameterSet:
        """Return the free and fixed parameters of a model."""
        return parameters_of(component, self.prior, self.dataset)

    def problem(self, component: FrictionModel) -> InverseDynamics:
        """Return the problem of inverse dynamics for a model."""
        return InverseDynamics(self.dataset, self.parameters(component))

    def nested_starts(self, parameters: ParameterSet) -> list[dict[str, float]]:
        """Return the parameters of a model equal to the best fit of each model with one slot less."""
        starts = list[dict[str, float]]()
        for component in nested_in(parameters.component):
            if (
                component not in self.optima
                and along_the_motion(self, component, silent).solution.unfinished
            ):
                raise KeyboardInterrupt
            starts.append(richer(parameters, component, self.optima[component]))
        return starts

    def search(self, problem: Sought, unit: float = 0.0, *, simulates: bool = False) -> Search:
        """Return the search for the parameters of a problem; a `unit` of 0 means the friction force."""
        return Search(problem, self.scales, self.sliding, unit or self.scales.force, simulates)


@dataclass(frozen=True)
class Estimation:
    """The estimation of one model: `inverse` dynamics along the measured motion, and the minimised `problem`."""

    inverse: InverseDynamics
    solution: Solution
    problem: Problem
    resampled: tuple[Problem, Solution]
    residual_without: Callable[[np.ndarray], np.ndarray]
    finished: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict
    written: Callable[[Model], Model] = lambda friction: friction
    further: int = 0
    diagnostics: tuple[Diagnostic, ...] = ()
    covariance: Covariance | None = None
    # Result of `structure.missing_in`; a changed copy begins without it.
    missing: list[tuple[tuple[Missing, ...], float]] = field(
        default_factory=list, init=False, repr=False
    )

    @property
    def simulates(self) -> bool:
        """Whether the minimised error is that of a simulated signal."""
        return self.problem is not self.inverse


ALIKE = 1e-7  # Relative difference below which two sums of squares are equal
FLAT = 1e-4  # Allowed relative rise of a sum of squares if a parameter that the log does not show is held constant

Estimator = Callable[[Context, FrictionModel, Report], Estimation]


def along_the_motion(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of least squares along the measured motion."""
    problem = context.problem(component)
    if problem.parameters.is_linear:
        solution, on_rows = linear(problem), partial(linear, problem)
    else:
        search = context.search(problem)
        solution = search.solve(report, context.nested_starts(problem.parameters))
        problem, search, solution = _with_offset(context, problem, search, solution)
        problem, search, solution = _without_flat(context, problem, search, solution)
        on_rows = partial(search.refit, solution.values)
    context.optima[component] = problem.parameters.complete(solution.values)
    return Estimation(
        problem,
        solution,
        problem,
        (problem, solution),
        lambda rows: problem.residual(on_rows(rows).values),
    )


def richer(
    parameters: ParameterSet, nested: FrictionModel, optimum: Mapping[str, float]
) -> dict[str, float]:
    """Return the parameters with which a model equals a nested model at its optimum; forces by direction absorb a fixed offset."""
    component = parameters.component
    first, nested_first = (
        names_of(Role.BREAK_AWAY, model.variables) for model in (component, nested)
    )
    values: dict[str, float] = {**component.defaults, **optimum, **parameters.held}
    values |= {
        name: optimum[level]
        for name, level in zip(first, nested_first, strict=False)
        if name not in optimum
    }
    shift = offset_of(nested.variables, optimum) - offset_of(component.variables, values)
    for name, variable in nested.variables.items():
        for part, sign in zip(by_direction(component, name), (1.0, -1.0), strict=False):
            if part not in optimum:
                values[part] = optimum[name] + sign * shift * acts_in_sliding(variable)
    return values


def _with_offset(
    context: Context, problem: InverseDynamics, search: Search, solution: Solution
) -> tuple[InverseDynamics, Search, Solution]:
    """Return the same fit with a free offset and levels by direction, if a model without levels by direction fits better."""
    # Unlike levels by direction, a weight shifts the reversal of friction: only a model with memory shows the difference.
    parameters, values = problem.parameters, problem.parameters.complete(solution.values)
    held = {name: entry for name, entry in parameters.fixed.items() if "levels" in entry.numbers}

    def with_fixed(offsets: Mapping[str, Fixed]) -> InverseDynamics:
        fixed = {
            name: entry for name, entry in parameters.fixed.items() if name not in held
        } | dict(offsets)
        free = tuple(name for name in parameters.variables if name not in fixed)
        return replace(problem, parameters=replace(parameters, free=free, fixed=fixed))

    if not held or solution.unfinished:
        return problem, search, solution
    together = with_fixed({})
    again = context.search(together)
    least, start = again.lowest(context.nested_starts(together.parameters))
    if again.lowest([values])[0] <= (1.0 + ALIKE) * least:
        return problem, search, solution
    if is_static(problem.model(values)):
        together = with_fixed(
            {
                name: entry._replace(value=start[name], reason="held_constant")
                for name, entry in held.items()
            }
        )
        again = context.search(together)
    return together, again, again.refit(start, limit=EVALUATIONS)


def _without_flat(
    context: Context, problem: InverseDynamics, search: Search, solution: Solution
) -> tuple[InverseDynamics, Search, Solution]:
    """Return the same fit with the Stribeck velocity held constant if the log does not show it."""
    # If friction does not fall, the sum of squares is the same for every Stribeck velocity: rounding decides where in this flat
    # valley a search ends, and with it the status and all standard errors. Therefore the velocity is held at the smallest value
    # that the log could show, if the fit is as good there.
    parameters, nested = problem.parameters, context.nested_starts(problem.parameters)
    for name in names_of(Role.FALL, parameters.component.variables):
        if solution.unfinished or name not in solution.space.logarithmic:
            continue
        edge = math.exp(search.space.low[search.space.names.index(name)])
        cause = Excitation(
            context.dataset,
            context.scales,
            parameters.complete(solution.values) | {name: edge},
            parameters.variables,
            context.settings,
        ).cause(name)
        fixed = Fixed(edge, cause.code, redundant=True, numbers=cause.numbers)
        free = tuple(part for part in parameters.free if part != name)
        held = replace(
            problem,
            parameters=replace(parameters, free=free, fixed={**parameters.fixed, name: fixed}),
        )
        again = context.search(held)
        settled = again.refit(
            {part: value for part, value in solution.values.items() if part != name}
        )
        most = (1.0 + FLAT) * solution.cost
        if settled.cost <= (
            min(most, (1.0 + ALIKE) * search.lowest(nested)[0]) if nested else most
        ):
            problem, search, solution, parameters = held, again, settled, held.parameters
    return problem, search, solution


LEAST_LEVEL = 0.01  # of the effort: a smaller Coulomb force does not show the magnitude of friction
TURNS_LEAST = 3.0  # fewest turns over the range in the search for a pitch
STEPS_A_TURN = 8.0  # of the scan, over one more turn in the whole range
SCAN_MOST = 20_000
REFINED = 40
MOST_ORDER, MOST = 200, 24  # largest order that is tried, most harmonics
PASSING = 0.5  # of the amplitude of a wave, after the filters
SAMPLED = 0.5  # of a wave from sample to sample: faster waves are aliased
# Quantile of waves at half orders, and factor by which a harmonic exceeds it.
CHANCE, ABOVE = (0.9, 3.0)


def context_of(dataset: Dataset, prior: PriorKnowledge, *, settings: Settings = DEFAULT) -> Context:
    """Return the shared data of all fits to a log; reject an effort of zero."""
    effort = float(np.sqrt(np.mean(dataset.effort**2)))
    if effort == 0.0:
        raise InputError(
            "is zero throughout",
            path="log.effort",
            mend="Check the column of the effort in the axis file",
        )
    problem = sliding_problem(dataset, prior)
    values = problem.parameters.complete(linear(problem).values)
    coulomb, viscous = values.pop("F_C"), values.pop("F_v")
    if coulomb <= LEAST_LEVEL * effort:
        # Pre-sliding over a large part of the stroke looks viscous: use the level of total friction.
        friction = viscous * dataset.velocity + coulomb * np.sign(dataset.velocity)
        coulomb = max(float(np.sqrt(np.mean(friction**2))), coulomb)
    scales = scales_of(dataset, max(coulomb, LEAST_LEVEL * effort))
    return Context(dataset, prior, Sliding(values, coulomb, viscous), scales, settings)


def with_pitch(context: Context, component: FrictionModel) -> Context:
    """Return the context with the pitch of the screw, found in the residual of sliding, if a model needs it."""
    if PITCH not in component.variables.values() or context.prior.pitch is not None:
        return context
    sliding = context.sliding
    pitch = _pitch_in(
        sliding_problem(context.dataset, context.prior),
        {**sliding.values, "F_C": sliding.coulomb, "F_v": sliding.viscous},
    )
    return replace(context, prior=replace(context.prior, pitch=pitch))


def sliding_problem(dataset: Dataset, prior: PriorKnowledge) -> InverseDynamics:
    """Return the problem of Coulomb and viscous friction, the first fit to a log."""
    return InverseDynamics(dataset, parameters_of(find("coulomb_viscous"), prior, dataset))


def _pitch_in(problem: InverseDynamics, values: Mapping[str, float]) -> float:
    """Return the period over the position of the residual of a simple model [m or rad]."""
    # Find the wave that explains most of the residual on an even grid of turns over the range, then refine it.
    dataset = problem.dataset
    x, residual, side = (
        dataset.position,
        dataset.effort - problem.predicted(values),
        np.sign(dataset.velocity)[:, None],
    )
    stroke = float(np.ptp(x))
    # The wave passes the filter at half of the speeds.
    most = stroke * dataset.cutoff / float(np.median(np.abs(dataset.velocity)))
    if most <= TURNS_LEAST:
        raise InputError(
            "covers too few turns to find the pitch of the screw",
            path="log.position",
            value=f"a range of {with_unit(stroke, unit_of('length', dataset.kind))}",
            mend="Give the lead in [transmission] of the axis file",
        )
    turns = np.linspace(
        TURNS_LEAST, most, int(min(STEPS_A_TURN * (most - TURNS_LEAST) + 2, SCAN_MOST))
    )
    step = turns[1] - turns[0]

    def explained(count: float) -> float:
        phase = 2.0 * np.pi * (count / stroke) * x
        waves = np.stack([np.cos(phase), np.sin(phase), np.ones_like(x)], axis=1)
        # A force over the position, and a level that reverses with the motion.
        waves = np.hstack([waves, side * waves])
        return _energy(waves, residual)

    best = max(turns.tolist(), key=explained)
    return stroke / max(np.linspace(best - step, best + step, REFINED).tolist(), key=explained)


def with_harmonics(prior: PriorKnowledge, axis: Axis | None, dataset: Dataset) -> PriorKnowledge:
    """Return the prior knowledge with the harmonics that an axis file leaves to the log."""
    for place, cogging in enumerate(axis.cogging if axis is not None else ()):
        if cogging.harmonics is None:
            problem = sliding_problem(dataset, prior)
            plant, gravity, columns, degree, orders = (
                prior.plant,
                False,
                (),
                0,
                dict[str, list[int]](),
            )
            if isinstance(plant, TermedPlant):
                gravity, columns, degree = plant.gravity, plant.columns, plant.degree
                orders = {
                    turner: [n for counted, n in plant.orders if counted == turner]
                    for turner in TURNS
                }
                plant = plant.inner
            orders[cogging.turner] = list(
                harmonics_in(problem, cogging, f"cogging[{place}].harmonics")
            )
            plant = with_terms(
                plant, gravity=gravity, cogging=orders, columns=columns, spring=DEGREES.get(degree)
            )
            prior = replace(
                prior, plant=plant, values={**prior.values, TURNS[cogging.turner]: cogging.turn}
            )
    return prior


def with_harmonics_of(plant: Plant, axis: Axis) -> Axis:
    """Return an axis with the harmonics of a plant."""
    orders = plant.orders if isinstance(plant, TermedPlant) else ()
    pairs = zip(
        axis.cogging,
        [tuple(n for turner, n in orders if turner == cogging.turner) for cogging in axis.cogging],
        strict=True,
    )
    return replace(
        axis, cogging=tuple(replace(cogging, harmonics=numbers) for cogging, numbers in pairs)
    )


def harmonics_in(problem: InverseDynamics, cogging: Cogging, path: str) -> list[int]:
    """Return the orders per turn of the harmonics in the residual of a simple `problem`."""
    dataset = problem.dataset
    turns = float(np.ptp(dataset.position)) / cogging.turn
    if turns < 1.5:  # fewest turns in the log
        raise InputError(
            f"need 1.5 turns of the {cogging.turner}, but the log has {turns:.2g} turns",
            path=path,
            value="identify",
            mend="Write the harmonics, such as [6, 12], or record more turns",
        )
    x = dataset.position
    place = 2.0 * (x - x.mean())[:, None] / float(np.ptp(x))
    powers = np.hstack([place, place**2])
    columns = np.column_stack(
        [problem.columns, np.hstack([powers, np.sign(dataset.velocity)[:, None] * powers])]
    )
    size = np.linalg.norm(columns, axis=0)
    basis = np.linalg.qr(columns[:, size > 0.0] / size[size > 0.0])[0]
    residual = apart_from(basis, dataset.effort)
    # At least three periods over the range of the log.
    first, orders = (max(int(np.ceil(3.0 / turns)), 1), list[int]())
    tried = np.arange(2 * first, 2 * MOST_ORDER + 1) / 2.0
    waves = {order: _waves(dataset, cogging.turn, order) for order in tried.tolist()}
    waves = {
        order: apart_from(basis, pair)
        for order, pair in waves.items()
        if np.mean(pair**2) > 0.5 * PASSING**2
    }
    least = 0.004 * float(residual @ residual)  # of the first residual: the smallest harmonic
    while len(orders) < MOST:
        energies = {order: _energy(pair, residual, rcond=1e-9) for order, pair in waves.items()}
        of_turns = {int(order): energy for order, energy in energies.items() if order.is_integer()}
        chance = float(
            np.quantile(
                [energy for order, energy in energies.items() if not order.is_integer()] or [0],
                CHANCE,
            )
        )
        best = max(of_turns, key=lambda order: of_turns[order], default=0)
        if not best or of_turns[best] < max(ABOVE * chance, least):
            break
        orders.append(best)
        pair = np.linalg.qr(waves.pop(float(best)))[0]
        residual = apart_from(pair, residual)
        waves = {order: apart_from(pair, columns) for order, columns in waves.items()}
    if not orders:
        raise InputError(
            f"cannot be identified, because no part of the effort in this log repeats with the {cogging.turner}",
            path=path,
            value="identify",
            mend="Remove [[cogging]] from the axis file, or write known orders, such as harmonics = [6]",
        )
    return sorted(orders)


def _energy(waves: np.ndarray, residual: np.ndarray, rcond: float | None = None) -> float:
    """Return the sum of squares of a residual that waves explain."""
    right = waves.T @ residual
    return float(right @ unbounded(waves.T @ waves, right, rcond=rcond))


def _waves(dataset: Dataset, turn: float, order: float) -> np.ndarray:
    """Return cosine and sine over the turn in each row, after the filters, shape (row, 2)."""
    turns = [segment.position * (order / turn) for segment in dataset.segments]
    sampled = [np.abs(np.gradient(phase)) < SAMPLED for phase in turns]
    waves = [
        dataset.rows_of(
            [
                dataset.filtered(np.where(slow, bend(2.0 * np.pi * phase), 0.0))
                for phase, slow in zip(turns, sampled, strict=True)
            ]
        )
        for bend in (np.cos, np.sin)
    ]
    return np.stack(waves, axis=1)
