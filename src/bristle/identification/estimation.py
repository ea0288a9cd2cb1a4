"""What one model was fitted with, and how the same is done again on other rows or other data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.diagnostic import Diagnostic
from bristle.identification.dataset import Dataset
from bristle.identification.excitation import Excitation
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report, Search, Sliding, linear
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed, ParameterSet, PriorKnowledge, Role, Scales, names_of, parameters_of
from bristle.identification.problem import Problem
from bristle.identification.settings import DEFAULT, Settings


@dataclass(frozen=True)
class Context:
    """What the fits of all models to one log share.

    `sliding` and `scales` are its friction, as a linear fit finds it, and its typical magnitudes. The whole range of
    each parameter is looked at where `everywhere`; an `estimator` takes the place of `along_the_motion`.
    """

    dataset: Dataset
    prior: PriorKnowledge
    sliding: Sliding
    scales: Scales
    everywhere: bool = False
    settings: Settings = DEFAULT
    estimator: Estimator | None = None

    def parameters(self, component: FrictionModel) -> ParameterSet:
        """Return which parameters of a model are free and which are fixed."""
        return parameters_of(component, self.prior, self.dataset)

    def problem(self, component: FrictionModel) -> InverseDynamics:
        """Return inverse dynamics of a model."""
        return InverseDynamics(self.dataset, self.parameters(component))

    def search(self, problem: Problem, unit: float = 0.0, *, simulates: bool = False) -> Search:
        """Return the search for the parameters of a problem."""
        return Search(problem, self.scales, self.sliding, unit, simulates)


@dataclass(frozen=True)
class Estimation:
    """What one model was fitted with: `inverse`, the model along the measured motion, and the `problem` made small."""

    inverse: InverseDynamics
    solution: Solution
    problem: Problem
    resampled: tuple[Problem, Solution]
    residual_without: Callable[[np.ndarray], np.ndarray]
    finished: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict
    written: Callable[[Model], Model] = lambda friction: friction
    further: int = 0
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def simulates(self) -> bool:
        """Whether a simulated signal was made small."""
        return self.problem is not self.inverse


FLAT = 1e-4
"""Share by which a sum of squares may rise with a parameter held that the log does not show."""

Estimator = Callable[[Context, FrictionModel, Report], Estimation]


def along_the_motion(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of least squares along the measured motion."""
    problem = context.problem(component)
    if problem.parameters.is_linear:
        solution, on_rows = linear(problem), partial(linear, problem)
    else:
        search = context.search(problem)
        solution = search.solve(report, everywhere=context.everywhere)
        problem, search, solution = _without_flat(context, problem, search, solution)
        on_rows = partial(search.refit, solution.values)
    return Estimation(problem, solution, problem, (problem, solution), lambda rows: problem.residual(on_rows(rows).values))


def _without_flat(
    context: Context, problem: InverseDynamics, search: Search, solution: Solution
) -> tuple[InverseDynamics, Search, Solution]:
    """Return the same fit with a velocity of the Stribeck fall held where the log does not show it.

    Where friction does not fall, the sum of squares is the same for every such velocity: rounding decides where in that
    flat valley a search ends, and with it the status and all standard errors. So the velocity is held at the smallest
    that the log could show wherever the fit is as good there.
    """
    parameters = problem.parameters
    for name in names_of(Role.FALL, parameters.component.variables):
        if solution.unfinished or name not in solution.space.logarithmic:
            continue
        edge = math.exp(search.space.low[search.space.names.index(name)])
        cause = Excitation(
            context.dataset, context.scales, parameters.complete(solution.values) | {name: edge}, parameters.variables, context.settings
        ).cause(name)
        fixed = Fixed(edge, cause.code, redundant=True, numbers=cause.numbers)
        free = tuple(part for part in parameters.free if part != name)
        held = replace(problem, parameters=replace(parameters, free=free, fixed={**parameters.fixed, name: fixed}))
        again = context.search(held)
        settled = again.refit({part: value for part, value in solution.values.items() if part != name})
        if settled.cost <= (1.0 + FLAT) * solution.cost:
            problem, search, solution, parameters = held, again, settled, held.parameters
    return problem, search, solution
