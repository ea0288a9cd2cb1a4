r"""Elements that slip by a Stribeck curve (generalised Maxwell-slip model), identified from a log.

For a given curve, the forces of elements with break-away deflections on a fixed grid are linear in their stiffness.
Non-negative least squares finds them (`bristle.identification.element_models`). For given elements, a bounded search
finds the curve, the attraction to it and the other parameters. Both steps alternate as long as the error falls,
starting from elements without a curve. Pre-sliding loops determine the elements, sliding the curve, and the
transition the attraction :math:`C`.

The intervals are those of the parameters, for elements of this shape.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.diagnostic import Diagnostic
from bristle.identification.element_models import Elements, elements_of
from bristle.identification.estimation import Context, Estimation
from bristle.identification.fixed_shape import ShapedModel, in_lists, shaped
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import EVALUATIONS, Report
from bristle.identification.parameter_space import Solution
from bristle.models.friction import find, gms, maxwell_slip
from bristle.models.friction.slots import by_direction

OF_THIS_SHAPE = Diagnostic("element_shape", severity="note")

ROUNDS = 4
STARTS = 3  # Stribeck velocities
COULOMB = 0.8  # of the level of elements without a curve, at the start of the search


class Curve(NamedTuple):
    """Coulomb over static friction, Stribeck velocity [m/s or rad/s], attraction over static friction [1/s]."""

    ratio: float
    v_S: float
    rate: float

    def element(self, r: float) -> Model:
        """Return an element of stiffness 1 that breaks away at a deflection `r` [m or rad]."""
        return gms(
            F_C=self.ratio * r,
            F_S=r,
            v_S=self.v_S,
            C=self.rate * r,
            k_i=[1.0],
            nu_i=[1.0],
            validate=False,
        )


def estimate_stribeck_elements(
    context: Context, component: FrictionModel, report: Report
) -> Estimation:
    """Fit elements that slip by a curve, alternating between shape and curve."""
    model = StribeckElements(context, component)
    problem, solution, elements = model.solve(report)
    view = problem.parameters.component
    assert isinstance(view, ShapedModel)

    def residual_without(rows: np.ndarray) -> np.ndarray:
        # The elements of the best shape there, then the other parameters.
        refitted = model.problem(elements.solution(rows)[0].parameters.component)
        return refitted.residual(context.search(refitted).refit(solution.values, rows).values)

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
        """Return the problem with the elements of the best shape, its solution, and the problem of the elements."""
        elements = self._elements()
        first, plain = elements.solution()
        problem = self.problem(first.parameters.component)
        # Static and Coulomb friction, for each direction where they may differ.
        statics, levels = (by_direction(self.component, name) for name in ("F_S", "F_C"))
        values, scales = first.parameters.complete(plain.values), self.context.scales
        for static, level in zip(statics, levels, strict=True):
            values |= {static: values[level], level: COULOMB * values[level]}
        # Samples in which the force reaches the curve, at the start of the search.
        values["C"] = scales.force / (30.0 * scales.sample_time)
        low, high = scales.range(problem.parameters.variables["v_S"])
        ends = []
        for number, v_S in enumerate(np.geomspace(low, high, STARTS + 2)[1:-1].tolist()):
            report((number + 0.3) / (STARTS + ROUNDS))
            start = {name: (values | {"v_S": v_S})[name] for name in problem.parameters.free}
            ends.append(self.context.search(problem).refit(start, limit=EVALUATIONS))
        best = min(ends, key=lambda end: end.cost)
        for number in range(ROUNDS):
            report((STARTS + number) / (STARTS + ROUNDS))
            F_S, F_C = (
                float(np.mean([best.values[name] for name in names])) for names in (statics, levels)
            )
            again = self._elements(Curve(F_C / F_S, best.values["v_S"], best.values["C"] / F_S))
            trial = self.problem(again.solution()[0].parameters.component)
            solution = self.context.search(trial).refit(best.values, limit=EVALUATIONS)
            # Of the previous sum of squares: a smaller decrease ends the search.
            fell = solution.cost < 0.98 * best.cost
            if solution.cost < best.cost:
                problem, best, elements = trial, solution, again
            if not fell:
                break
        return problem, best, elements

    def _elements(self, curve: Curve | None = None) -> Elements:
        """Return the problem of the elements alone, with slip by a curve or, at first, at a constant force."""
        elements = elements_of(
            self.context, find(self.component.name.replace(gms.name, maxwell_slip.name, 1))
        )
        return elements if curve is None else replace(elements, element=curve.element)

    def problem(self, view: Any) -> InverseDynamics:
        """Return the problem of elements of the shape of a view."""
        return self.context.problem(
            shaped(self.component, *(np.array(part) for part in view.shape))
        )
