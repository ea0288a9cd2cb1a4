"""How a model is estimated: by least squares along the measured motion, or by a simulation that goes on from there.

What an estimator returns is an `Estimation`; it is chosen by what the model and the request say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.interruption import BestSoFar
from bristle.friction import base_of
from bristle.identification.element_models import estimate_elements
from bristle.identification.estimation import Context, Estimation, Estimator
from bristle.identification.fixed_shape import ELEMENT_MODELS
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report, Search, between, linear
from bristle.identification.output_error import OutputError
from bristle.identification.outputs import LAG, Output
from bristle.identification.parameter_space import Solution
from bristle.identification.refit import Refit
from bristle.identification.stribeck_element_models import estimate_stribeck_elements
from bristle.logs.log import Log

__all__ = ["Simulation", "along_the_motion", "estimate"]

AWAY = 0.3  # standard deviation of the logarithm by which further starts are away from the first
FURTHER_STARTS = 2
FIRST_EVALUATIONS, LAST_EVALUATIONS = 40, 12
LAG_AT_FIRST = 0.2  # samples
EVERYWHERE = 0.7  # of the work, where the whole range is looked at
SEED = 7_110_601
START = 0.25  # of the work, which finds where a simulation begins

ELEMENTS: dict[FrictionModel, Estimator] = dict(
    zip(ELEMENT_MODELS, (estimate_elements, estimate_stribeck_elements), strict=True)
)
"""Models whose lists are found by variable projection, and how."""


def estimate(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of one model; `report` is told the share of the work done."""
    elements = ELEMENTS.get(base_of(component))
    if elements is None:
        return (context.estimator or along_the_motion)(context, component, report)
    if context.estimator is not None:
        raise InputError("is identified by inverse dynamics only", path="model", value=component.name,
                         mend="Write --method inverse_dynamics, or ask for dahl or lugre")  # fmt: skip
    return elements(context, component, report)


def along_the_motion(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Return the estimation of least squares along the measured motion."""
    problem = context.problem(component)
    if problem.parameters.is_linear:
        solution, on_rows = linear(problem), partial(linear, problem)
    else:
        search = context.search(problem)
        solution = search.solve(report, everywhere=context.everywhere)
        on_rows = partial(search.refit, solution.values)
    return Estimation(
        problem, solution, problem, (problem, solution), lambda rows: problem.residual(on_rows(rows).values)
    )


@dataclass(frozen=True)
class Simulation:
    """The estimator of least output error, which goes on from where inverse dynamics ends.

    Parameters
    ----------
    logs, axes : sequence of Log, of Axis
        The logs.
    loop : type of Output
        What is simulated.
    """

    logs: Sequence[Log]
    axes: Sequence[Axis]
    loop: type[Output]

    @property
    def excerpts(self) -> list[Log]:
        """What of the logs inverse dynamics is to look at for a start."""
        return [self.loop.excerpt(log, axis) for log, axis in zip(self.logs, self.axes, strict=True)]

    def error(self, inverse: InverseDynamics, *, fine: bool = False) -> OutputError:
        """Return the problem, as a search on the way or at its end asks for it."""
        return OutputError.of(self.loop, inverse, self.logs, self.axes, fine=fine)

    def __call__(self, context: Context, component: FrictionModel, report: Report) -> Estimation:
        """Return the estimation of one model; where its start is interrupted, that of the start."""
        problem = context.problem(component)
        start = self._start(context, problem, between(report, 0.0, START))
        if start.unfinished:
            return Estimation(problem, start, problem, (problem, start), lambda rows: problem.residual(start.values))
        return self.estimate(context, problem, start, between(report, START, 1.0))

    @staticmethod
    def _start(context: Context, problem: InverseDynamics, report: Report) -> Solution:
        if problem.parameters.is_linear:
            return linear(problem)
        return context.search(problem, simulates=True).solve(report)

    def estimate(self, context: Context, inverse: InverseDynamics, start: Solution, report: Report) -> Estimation:
        """Return the estimation of a model of which inverse dynamics has the solution `start`."""
        error = self.error(inverse)
        search = context.search(error, error.magnitude, simulates=True)
        first = {LAG: LAG_AT_FIRST * self.logs[0].sample_time} | start.values

        def work(best: BestSoFar) -> None:
            self._from_several(search, first, best, report, everywhere=context.everywhere)

        solution = search.as_far_as_it_came(work)
        if self.loop.is_refined:
            error = self.error(inverse, fine=True)
            fine = context.search(error, error.magnitude, simulates=True)
            ended = fine.refit(solution.values, limit=1 if solution.unfinished else LAST_EVALUATIONS)
            solution = replace(ended, unfinished=solution.unfinished)
        free = np.ones(len(solution.space.names), dtype=bool)
        return Estimation(
            error.inverse, solution, error, (error, solution),
            lambda rows: Refit(solution, free, rows).solve(error, solution.theta)[1],
            diagnostics=(Diagnostic(self.loop.code, severity="note"),),
        )  # fmt: skip

    def _from_several(
        self, search: Search, first: dict[str, float], best: BestSoFar, report: Report, *, everywhere: bool
    ) -> None:
        before = EVERYWHERE if everywhere else 0.0

        def report_start(number: float) -> None:
            share = before + (1.0 - before) * number / (FURTHER_STARTS + 2.0)
            report(share, f"best so far {search.percent(best.cost):.3g} %")

        rng = np.random.default_rng(SEED)
        best.take(search.refit(first, limit=FIRST_EVALUATIONS, best=best))
        if everywhere:
            theta = self._explored(search, best, between(report, 0.0, before))
            best.take(search.descend(theta, limit=FIRST_EVALUATIONS, best=best))
        for number in range(FURTHER_STARTS):
            report_start(number + 1.0)
            away = {name: value * float(np.exp(rng.normal(0.0, AWAY))) for name, value in best.result.values.items()}
            best.take(search.refit(away, limit=self.loop.away_evaluations, best=best))
        report_start(FURTHER_STARTS + 1.0)

    @staticmethod
    def _explored(search: Search, best: BestSoFar, report: Report) -> np.ndarray:
        """Return the best place in the whole range of each parameter, as a rough simulation finds it."""
        assert isinstance(search.problem, OutputError)
        rough, roughly = replace(search, problem=search.problem.rough), BestSoFar()
        try:
            return rough.explored(best.result.theta, roughly, report)
        except KeyboardInterrupt:
            if roughly.at is not None:
                best.see(roughly.at, search.cost_at(roughly.at))
            raise
