r"""Elements that slip by a Stribeck curve, the generalised Maxwell-slip model, from a log.

For a given curve the forces of elements that break away at deflections laid out beforehand are linear in their
stiffness, and non-negative least squares finds them (`bristle.identification.element_models`). For given elements the
curve, the attraction to it and all else are a few numbers, which a bounded search finds. Both are done in turn,
beginning with elements that know no curve, as long as the error falls. Loops before sliding tell the elements, slides
the curve, and what happens between both the attraction :math:`C`.

The intervals are those of the numbers, for elements of this shape.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.diagnostic import Diagnostic
from bristle.friction import find, gms, maxwell_slip
from bristle.friction.slots import by_direction
from bristle.identification.element_models import Elements, elements_of
from bristle.identification.estimation import Context, Estimation
from bristle.identification.fixed_shape import ShapedModel, in_lists, shaped
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import EVALUATIONS, Report
from bristle.identification.parameter_space import Solution

__all__ = ["StribeckElements", "estimate_stribeck_elements"]

OF_THIS_SHAPE = Diagnostic("element_shape", severity="note")

ROUNDS = 4
FALLS = 0.98  # of the sum of squares before: by less it does not fall
STARTS = 3  # Stribeck velocities
COULOMB = 0.8  # of the level of elements without a curve, where the search begins
ATTRACTION = 30.0  # samples in which the force comes to the curve, where the search begins


class Curve(NamedTuple):
    """Coulomb over static friction, Stribeck velocity [m/s or rad/s], attraction over static friction [1/s]."""

    ratio: float
    v_S: float
    rate: float

    def element(self, r: float) -> Model:
        """Return an element of stiffness 1 that breaks away at a deflection `r` [m or rad]."""
        return gms(F_C=self.ratio * r, F_S=r, v_S=self.v_S, C=self.rate * r, k_i=[1.0], nu_i=[1.0], validate=False)


def estimate_stribeck_elements(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Fit elements that slip by a curve: shape and curve in turn."""
    model = StribeckElements(context, component)
    problem, solution, elements = model.solve(report)
    view = problem.parameters.component
    assert isinstance(view, ShapedModel)

    def residual_without(rows: np.ndarray) -> np.ndarray:
        refitted, best = model.on_rows(elements, solution, rows)
        return refitted.residual(best.values)

    return Estimation(
        problem,
        solution,
        problem,
        (problem, solution),
        residual_without,
        finished=view.finished,
        written=in_lists,
        further=view.further,
        diagnostics=(OF_THIS_SHAPE,),
    )


@dataclass(frozen=True)
class StribeckElements:
    """The problem of one log: ``gms`` with its slots."""

    context: Context
    component: FrictionModel

    def solve(self, report: Report) -> tuple[InverseDynamics, Solution, Elements]:
        """Return the problem with the elements of the best shape, its solution, and where they came from."""
        elements = self._elements()
        first, plain = elements.solution()
        problem = self._problem(first.parameters.component)
        ends = []
        for number, start in enumerate(self._starts(problem, first, plain)):
            report((number + 0.3) / (STARTS + ROUNDS))
            ends.append(self.context.search(problem).refit(start, limit=EVALUATIONS))
        best = min(ends, key=lambda end: end.cost)
        for number in range(ROUNDS):
            report((STARTS + number) / (STARTS + ROUNDS))
            again = self._elements(self._curve(best))
            trial = self._problem(again.solution()[0].parameters.component)
            solution = self.context.search(trial).refit(best.values, limit=EVALUATIONS)
            fell = solution.cost < FALLS * best.cost
            if solution.cost < best.cost:
                problem, best, elements = trial, solution, again
            if not fell:
                break
        return problem, best, elements

    def on_rows(self, elements: Elements, start: Solution, rows: np.ndarray) -> tuple[InverseDynamics, Solution]:
        """Return problem and solution from some rows: the elements of the best shape there, then all else."""
        problem = self._problem(elements.solution(rows)[0].parameters.component)
        return problem, self.context.search(problem).refit(start.values, rows)

    def _elements(self, curve: Curve | None = None) -> Elements:
        """Return the problem of the elements alone, which slip by a curve or, at first, at one force."""
        plain = find(self.component.name.replace(gms.name, maxwell_slip.name, 1))
        elements = elements_of(self.context, plain)
        return elements if curve is None else replace(elements, element=curve.element)

    def _problem(self, view: Any) -> InverseDynamics:
        return self.context.problem(shaped(self.component, *(np.array(part) for part in view.shape)))

    def _starts(self, problem: InverseDynamics, first: InverseDynamics, plain: Solution) -> list[dict[str, float]]:
        values = first.parameters.complete(plain.values)
        for static, level in self._levels:
            values |= {static: values[level], level: COULOMB * values[level]}
        values["C"] = self.context.scales.force / (ATTRACTION * self.context.scales.sample_time)
        low, high = self.context.scales.range(problem.parameters.variables["v_S"])
        return [
            {name: (values | {"v_S": v_S})[name] for name in problem.parameters.free}
            for v_S in np.geomspace(low, high, STARTS + 2)[1:-1].tolist()
        ]

    @property
    def _levels(self) -> list[tuple[str, str]]:
        """The names of static and Coulomb friction, for each direction where they may differ."""
        return list(zip(by_direction(self.component, "F_S"), by_direction(self.component, "F_C"), strict=True))

    def _curve(self, solution: Solution) -> Curve:
        F_S, F_C = (float(np.mean([solution.values[name] for name in names])) for names in zip(*self._levels, strict=True))
        return Curve(F_C / F_S, solution.values["v_S"], solution.values["C"] / F_S)
