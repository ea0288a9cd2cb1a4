r"""Elements that slip, identified from a log: thresholds on a fixed grid, forces from least squares.

.. math:: u = M \ddot q + \Bigl(1 + \sum_j c_j\,g_j\Bigr)\Bigl(\sum_i k_i\,e_i + \sigma_2 \dot q\Bigr) + \dots, \qquad
    k_i \ge 0

with :math:`e_i` the deflection of an element that slips at :math:`r_i`, :math:`|e_i| \le r_i`. For given factors
:math:`c_j` of the slots the problem is convex and has one solution, which non-negative least squares finds; around it
the factors are searched for. Elements without force are omitted. The last threshold is half the range of the log: such an
element no longer slips once the motion has covered its range, and represents all elements that never slip. With
``+position`` or a spring, the force along the axis represents them, and the grid ends earlier.

With ``+asymmetry`` elements slip at :math:`r_i \pm d_i`. After both directions, this is equivalent to a symmetric element
and a constant. A log therefore determines only one difference of the levels, :math:`F_{C\pm} = F_C \pm d`.

The forces of single elements are confounded under noise. The useful numbers are their level :math:`F_C`, their stiffness
:math:`s = \sum k_i`, and the virgin curve. Their standard errors include the uncertainty of the shape.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.engine.motion import along
from bristle.identification.dataset import Dataset
from bristle.identification.estimation import Context, Estimation
from bristle.identification.fixed_shape import (
    DIFFERENCE,
    TOTAL,
    ElementSpace,
    ShapedModel,
    in_lists,
    shaped,
)
from bristle.identification.hysteresis.linear import NormalEquations, thresholds_over
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.parameters import Fixed, ParameterSet, Role, names_of, stroke_of
from bristle.models.friction import coulomb, maxwell_slip
from bristle.models.friction.slots import variations_of
from bristle.models.friction.variation import HALF_RANGE, is_factor, varied

COUNT_LEAST, PER_DECADE = 20, 12  # of the thresholds
STEPS_LEAST = 2.0  # smallest threshold [steps of the encoder]
NOISE_LEAST = 5.0  # smallest threshold [standard deviations of the noise of the position]
DECADES_MOST = 5.0
SLIPPING = 0.7  # of half the range: an element that slips over a large part of each stroke
NO_FRICTION = 1e-9  # of the effort: force of an element on an axis without friction
SMALL = 2.0**-12  # factor of a slot, far above the lower limit of friction with a slot
FACTOR_MOST, EDGE = 20.0, 0.99
EVALUATIONS = 40


def estimate_elements(context: Context, component: FrictionModel, report: Report) -> Estimation:
    """Fit elements that slip, with their shape."""
    elements = elements_of(context, component)
    problem, solution = elements.solution()
    report(1.0)

    def residual_without(rows: np.ndarray) -> np.ndarray:
        refitted, best = elements.solution(rows)
        return refitted.residual(best.values)

    view = problem.parameters.component
    assert isinstance(view, ShapedModel)
    return Estimation(
        problem,
        solution,
        problem,
        elements.all_elements(),
        residual_without,
        written=in_lists,
        further=view.further,
    )


def elements_of(context: Context, component: FrictionModel) -> Elements:
    """Return the problem of the elements of a log; at only one speed, viscous friction is fixed at 0, because it is confounded."""
    parameters, speeds = (
        context.parameters(shaped(component, np.ones(1), np.ones(1))),
        np.abs(context.dataset.velocity),
    )
    # Square of the mean speed over the mean square: 1 at one speed, 0.81 of a sine.
    if np.mean(speeds) ** 2 >= 0.9 * np.mean(speeds**2):
        damping = names_of(Role.VISCOUS, parameters.component.variables)
        viscous = {
            name: Fixed(0.0, "held_one_speed") for name in parameters.free if name in damping
        }
        free = tuple(name for name in parameters.free if name not in viscous)
        parameters = replace(parameters, free=free, fixed={**parameters.fixed, **viscous})
    return Elements(context.dataset, component, parameters)


class Weights(NamedTuple):
    """Stiffness of each element, factors of the slots, single parameters, and the regressor."""

    stiffness: np.ndarray
    factors: np.ndarray
    single: dict[str, float]
    columns: np.ndarray

    @property
    def linear(self) -> np.ndarray:
        """The unknowns of non-negative least squares, shape (column,)."""
        return np.concatenate([self.stiffness, list(self.single.values())])


@dataclass(frozen=True)
class Elements:
    """The problem of one log: ``maxwell_slip`` with its slots; `element` has the stiffness 1 and slips at a deflection [m or rad]."""

    dataset: Dataset
    component: FrictionModel
    parameters: ParameterSet
    element: Callable[[float], Model] = lambda r: maxwell_slip(
        F_C=r, k_i=[1.0], nu_i=[1.0], validate=False
    )

    @cached_property
    def thresholds(self) -> np.ndarray:
        """Deflections at which elements slip, shape (element,) [m or rad]."""
        dataset, reach = self.dataset, 0.5 * stroke_of(self.dataset)
        # An element that never slips is confounded with a force that rises along the axis.
        if HALF_RANGE in self.component.variables.values() or names_of(
            Role.SPRING, self.parameters.plant.variables
        ):
            reach *= SLIPPING
        least = max(
            STEPS_LEAST * dataset.resolution,
            NOISE_LEAST * dataset.noise,
            reach * 10.0**-DECADES_MOST,
        )
        return thresholds_over(
            reach, max(COUNT_LEAST, round(PER_DECADE * np.log10(max(reach / least, 1.0)))), least
        )

    def solution(self, rows: np.ndarray | slice = slice(None)) -> tuple[InverseDynamics, Solution]:
        """Return the problem with the elements of the best shape, and its solution, from some of the rows."""
        best = self._best(rows)
        pressed = np.flatnonzero(best.stiffness > 0.0)
        if pressed.size == 0:  # no friction: one element with almost no force
            pressed = np.array([self.thresholds.size // 2])
            best.stiffness[pressed] = (
                NO_FRICTION * float(np.std(self.dataset.effort)) / self.thresholds[pressed]
            )
        stiffness, r = best.stiffness[pressed], self.thresholds[pressed]
        level, difference = float(stiffness @ r), best.single.get(DIFFERENCE, 0.0)
        values = best.single | {
            name: level + sign * difference for name, sign in self._levels.items()
        }
        values |= {TOTAL: float(np.sum(stiffness))} | dict(
            zip(self._factors, best.factors.tolist(), strict=True)
        )
        values = {name: values[name] for name in self.parameters.free}
        at_edge = self._at_zero(best)
        if level < 2.0 * NO_FRICTION * float(np.std(self.dataset.effort)):
            at_edge |= dict.fromkeys(self._levels, "smallest")
        for name in self._factors:
            if abs(values[name]) > EDGE * FACTOR_MOST:
                at_edge[name] = "largest" if values[name] > 0.0 else "smallest"
        space, theta = ParameterSpace.of(self.parameters), np.array(list(values.values()))
        problem = InverseDynamics(
            self.dataset,
            replace(self.parameters, component=shaped(self.component, stiffness, stiffness * r)),
        )
        return problem, Solution(space, theta, self._jacobian(best, pressed, r), at_edge)

    def all_elements(self) -> tuple[InverseDynamics, Solution]:
        """Return the problem with all elements, and its solution: one stiffness for each element."""
        best = self._best(slice(None))
        single = {
            name: 0.0 if name in self._positive else -np.inf
            for name in (*self._single, *self._factors)
        }
        space = ElementSpace.around(self.thresholds, single, self._levels, self.parameters.free)
        jacobian = np.column_stack([best.columns, *self._by_factor(best).values()])
        problem = InverseDynamics(self.dataset, replace(self.parameters, component=self.component))
        theta = np.concatenate([best.linear, best.factors])
        return problem, Solution(
            replace(space, linear=not self._factors), theta, jacobian, self._at_zero(best)
        )

    @property
    def _factors(self) -> tuple[str, ...]:
        return tuple(
            name for name in self.parameters.free if is_factor(self.parameters.variables[name])
        )

    @property
    def _single(self) -> tuple[str, ...]:
        """The free parameters that do not belong to the elements."""
        named = tuple(
            name
            for name in self.parameters.free
            if name not in (*self._levels, TOTAL, *self._factors)
        )
        return (*named, DIFFERENCE) if len(self._levels) > 1 else named

    @property
    def _levels(self) -> dict[str, float]:
        """The level parameters of the elements, and the sign of the difference in each."""
        names = names_of(Role.LEVEL, self.component.variables)
        return dict(zip(names, (1.0, -1.0) if len(names) > 1 else (0.0,), strict=True))

    @property
    def _slotted(self) -> tuple[str, ...]:
        """The single parameters that slots multiply."""
        damping = names_of(Role.VISCOUS, self.component.variables)
        return tuple(name for name in self._single if name == DIFFERENCE or name in damping)

    @property
    def _positive(self) -> frozenset[str]:
        """The single parameters that are not negative: inertia, stiffness of the plant, damping."""
        variables = self.parameters.variables
        return frozenset(
            name for name in self._single if name in variables and variables[name].min >= 0.0
        )

    def _at_zero(self, weights: Weights) -> dict[str, str]:
        return {
            name: "smallest"
            for name in self._single
            if weights.single[name] == 0.0 and name in self._positive
        }

    def _by_factor(self, weights: Weights) -> dict[str, np.ndarray]:
        """Return the derivative of the effort of each row by each factor of the slots."""
        multiplied = np.concatenate(
            [weights.stiffness, [weights.single[name] for name in self._slotted]]
        )
        return {
            name: self._varying[place + 1] @ multiplied for place, name in enumerate(self._factors)
        }

    def _best(self, rows: np.ndarray | slice) -> Weights:
        # The requested rows, without the start of each segment.
        requested = np.zeros(self._target.size, dtype=bool)
        requested[rows] = True
        settled = requested & self._run_in
        # Of the rows: with fewer left, all are fitted.
        fitted = settled if np.sum(settled) > 0.5 * np.sum(requested) else requested
        if not self._factors:
            return self._for_factors(np.zeros(0), fitted)
        from scipy.optimize import least_squares

        target = self._target[fitted]

        def residual(factors: np.ndarray) -> np.ndarray:
            weights = self._for_factors(factors, fitted)
            return (weights.columns[fitted] @ weights.linear - target) / float(np.std(target))

        best = least_squares(
            residual,
            np.zeros(len(self._factors)),
            bounds=(-FACTOR_MOST, FACTOR_MOST),
            x_scale=0.1,
            max_nfev=EVALUATIONS,
        )
        return self._for_factors(best.x, fitted)

    def _for_factors(self, factors: np.ndarray, fitted: np.ndarray) -> Weights:
        """Return the best weights for these factors of the slots; the regressor has elements, then single parameters."""
        varying, count = (
            self._varying[0] + np.tensordot(factors, self._varying[1:], axes=1),
            self.thresholds.size,
        )
        single = self._constant | {
            name: varying[:, count + place] for place, name in enumerate(self._slotted)
        }
        columns = np.column_stack([varying[:, :count], *(single[name] for name in self._single)])
        signs = np.concatenate(
            [np.ones(count), [float(name in self._positive) for name in self._single]]
        )
        weights = (
            NormalEquations.of(columns[fitted], self._target[fitted], constant=False)
            .solve(signs)
            .weights
        )
        return Weights(
            weights[:count],
            factors,
            dict(zip(self._single, weights[count:].tolist(), strict=True)),
            columns,
        )

    @cached_property
    def _varying(self) -> np.ndarray:
        """The terms that slots multiply: plain, then times each cause; shape (cause, row, column)."""
        segments, filtered = self.dataset.segments, self.dataset.filtered
        causes, dt = [[np.ones(1)] * len(segments)], self.dataset.sample_time
        for name in self._factors:
            # Get each factor from the kernels of the slots: a contact at rest with a force of 1 shows it everywhere.
            steady = varied(coulomb, variations_of(self.component))
            fixed = {
                key: fixed.value
                for key, fixed in self.parameters.fixed.items()
                if key in steady.variables
            }
            values: dict[str, Any] = {"F_C": 1.0, **fixed, name: SMALL}
            contact, at_rest = (
                steady(validate=False, **values),
                [np.zeros(segment.position.size) for segment in segments],
            )
            pushed = [
                along(contact, v, dt, part.position, **part.surroundings)
                for v, part in zip(at_rest, segments, strict=True)
            ]
            causes.append([(push - 1.0) / SMALL for push in pushed])
        columns = []
        for multiplied in (*self.thresholds.tolist(), *self._slotted):
            # The deflection of an element [m or rad], or another multiplied term, by name.
            model = (
                self.element(multiplied)
                if isinstance(multiplied, float)
                else self._empty.model(self._empty.unit(TOTAL, multiplied))
            )
            forces = [
                np.ones_like(part.velocity)
                if multiplied == DIFFERENCE
                else part.friction(model, dt)
                for part in segments
            ]
            columns.append(
                [
                    self.dataset.rows_of(
                        [
                            filtered(force * share)
                            for force, share in zip(forces, cause, strict=True)
                        ]
                    )
                    for cause in causes
                ]
            )
        return np.moveaxis(np.array(columns), 0, -1)

    @cached_property
    def _empty(self) -> InverseDynamics:
        """The problem of one element without force, which is linear in each other parameter."""
        return InverseDynamics(
            self.dataset,
            replace(self.parameters, component=shaped(self.component, np.ones(1), np.ones(1))),
        )

    @cached_property
    def _constant(self) -> dict[str, np.ndarray]:
        """The columns that do not depend on the factors, shape (row,) each: the response to 1."""
        plant, columns = self.parameters.plant.variables, {}
        for name in self._single:
            if name not in self._slotted:
                values = self._empty.unit(TOTAL, name)
                columns[name] = (
                    self._empty.mechanical(values)
                    if name in plant
                    else self._empty.friction(values)
                )
        return columns

    @cached_property
    def _target(self) -> np.ndarray:
        """Effort of each row [N or N*m], minus that of the parameters held constant."""
        values = self.parameters.complete(dict.fromkeys(self.parameters.free, 0.0) | {TOTAL: 1.0})
        return self.dataset.effort - self._empty.mechanical(values) - self._empty.friction(values)

    @cached_property
    def _run_in(self) -> np.ndarray:
        """Mask of the rows after the motion has covered its range, shape (row,) of bool."""
        marks = []
        for segment in self.dataset.segments:
            covered = np.maximum.accumulate(segment.position) - np.minimum.accumulate(
                segment.position
            )
            # Of the range of a segment: after that, no element depends on the start of the log.
            marks.append(covered > 0.9 * covered[-1])
        return self.dataset.sampled(marks)

    def _jacobian(self, weights: Weights, pressed: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Return the derivative of the effort by the free parameters, projected off the shape of the elements."""
        # Level and stiffness are two linear functions of the forces of all elements; the rest is the shape.
        elements = weights.columns[:, pressed]
        named = np.vstack([r, np.ones_like(r)])
        if pressed.size < named.shape[0]:
            named = named[:1]
        by_level = elements @ np.linalg.pinv(named)
        if by_level.shape[1] < 2:
            # With one element, level and stiffness are proportional.
            by_level = np.hstack([by_level, np.zeros_like(by_level)])
        *_, directions = np.linalg.svd(named)
        shape = elements @ directions[named.shape[0] :].T
        count, columns = self.thresholds.size, {TOTAL: by_level[:, 1]}
        columns |= {
            name: weights.columns[:, count + place] for place, name in enumerate(self._single)
        }
        for name, sign in self._levels.items():
            # Level and difference are half the sum and half the difference of both.
            columns[name] = (by_level[:, 0] + sign * columns.get(DIFFERENCE, 0.0)) / len(
                self._levels
            )
        columns |= self._by_factor(weights)
        jacobian = np.stack([columns[name] for name in self.parameters.free], axis=1)
        return jacobian - shape @ unbounded(shape, jacobian) if shape.size else jacobian
