"""Least squares for the parameters of one problem: linear, or by bounded descents from several starts.

Descents are those of scipy (trust region reflective). The Jacobian comes with the residual, else from differences: on
all cores, never beyond an upper bound, with steps that events of a simulation do not disturb.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from bristle.core.cores import abreast
from bristle.core.diagnostic import BestSoFar
from bristle.core.edge import between
from bristle.core.lazy import cached_property
from bristle.core.least_squares import bounded, unbounded
from bristle.core.variable import OF_SLOTS, Variable
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import (
    ParameterSpace,
    Solution,
    Transform,
    TransformedSpace,
)
from bristle.identification.parameters import Scales
from bristle.identification.problem import Sought

CANDIDATES = 24
STARTS = 3
EVALUATIONS = 60
SEED = 20_240_229
FAR = 1e6  # times a typical residual: limit for a model that diverges
STEP = (
    1e-5  # of a coordinate, or of 1: far above the shift of an event by one step of the integration
)
DIFFERENCE = float(np.sqrt(np.finfo(float).eps))  # of a coordinate, for a derivative
SIMULATED = 1e-7  # relative change of the cost that ends a search whose differences are coarse
HELD_OUT = (
    1e-6  # the same for a search on some rows: held-out errors are then accurate to a thousandth
)
EDGE = 1e-3  # in coordinates: of a typical magnitude, or of a factor e


class _KnownError(Exception):
    """A descent has reached a known minimum."""


Report = Callable[..., None]  # Function that receives the share of the work done, and a remark


def silent(share: float, remark: str = "") -> None:
    """Ignore progress."""


class Sliding(NamedTuple):
    """Coulomb and viscous friction of a log from a linear fit, with plant and offset by name [SI]."""

    values: Mapping[str, float]
    coulomb: float
    viscous: float


def linear(problem: InverseDynamics, rows: np.ndarray | slice = slice(None)) -> Solution:
    """Return the least-squares parameters of a linear model from some rows."""
    space = ParameterSpace.of(problem.parameters)
    columns = problem.columns[rows]
    target = (problem.dataset.effort - problem.fixed_effort)[rows]
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    theta, at_edge = unbounded(columns / scale, target) / scale, {}
    if np.any(theta < space.low) or np.any(theta > space.high):
        scaled, active = bounded(columns / scale, target, space.low * scale, space.high * scale)
        theta = np.clip(scaled / scale, space.low, space.high)
        sides = zip(space.names, active, strict=True)
        at_edge = {name: "smallest" if side < 0 else "largest" for name, side in sides if side}
    return Solution(space, theta, columns, at_edge)


@dataclass
class Linearised:
    """The scaled residual of a search on some rows, with its Jacobian."""

    search: Search
    rows: np.ndarray | slice
    _last: tuple[np.ndarray, np.ndarray, np.ndarray | None] | None = None

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return the coordinates, the residual there, and its derivative by the free parameters, or None."""
        if self._last is None or not np.array_equal(x, self._last[0]):
            with np.errstate(over="ignore", invalid="ignore"):
                residual, derivatives = self.search.problem.linearised(self.search.space.values(x))
            self._last = x.copy(), self.search.finite(residual)[self.rows], derivatives
        return self._last

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the derivative of the residual, shape (row, coordinate)."""
        _, start, derivatives = self.at(x)
        search = self.search
        if derivatives is not None:
            order = [search.problem.parameters.free.index(name) for name in search.space.names]
            with np.errstate(over="ignore", invalid="ignore"):
                slopes = (
                    derivatives[self.rows][:, order] @ search.space.derivative(x) / -search.unit
                )
            # The derivative of a motion that diverges shows no direction.
            diverges = ~(np.maximum(np.max(np.abs(slopes), axis=1), np.abs(start)) < FAR)
            return np.where(diverges[:, None], 0.0, slopes)
        steps = search.step * np.maximum(1.0, np.abs(x))
        beside = x + np.diag(np.where(x + steps > search.space.high, -steps, steps))
        columns = zip(search.residuals(list(beside), self.rows), beside.diagonal() - x, strict=True)
        return np.stack([(residual - start) / step for residual, step in columns], axis=1)


@dataclass(frozen=True)
class Search:
    """The search for the parameters of a problem, from starts around its `sliding` friction; `unit` scales the residual."""

    problem: Sought
    scales: Scales
    sliding: Sliding
    unit: float
    simulates: bool = False

    @property
    def step(self) -> float:
        """Relative step of a coordinate for a difference."""
        return STEP if self.simulates else DIFFERENCE

    @cached_property
    def space(self) -> TransformedSpace:
        """The coordinates in which the parameters are sought."""
        return TransformedSpace.within(self.problem.parameters, self.scales)

    def solve(
        self, report: Report = silent, nested: Sequence[Mapping[str, float]] = ()
    ) -> Solution:
        """Return the best of several starts, `nested` optima first; a long log compares starts on an excerpt."""
        excerpt = self.problem.excerpt()
        if excerpt is None:
            return self.as_far_as_it_came(partial(self._from_several, nested, report))
        search = replace(self, problem=excerpt)
        begun = search.as_far_as_it_came(
            partial(search._from_several, nested, between(report, 0.0, 0.5))
        )
        if begun.unfinished:
            return replace(self.refit(begun.values, limit=1), unfinished=True)
        report(0.5)

        def go_on(best: BestSoFar) -> None:
            _, start = self.lowest([begun.values, *nested])
            best.at = self.space.theta(start)
            best.take(self.refit(start, limit=EVALUATIONS, best=best))

        return self.as_far_as_it_came(go_on)

    def as_far_as_it_came(self, work: Callable[[BestSoFar], None]) -> Solution:
        """Return the best result of `work`; after an interruption, the best result so far."""
        best = BestSoFar()
        try:
            work(best)
        except KeyboardInterrupt:
            if best.at is None:
                raise
            if best.result is None or best.cost < best.result.cost:
                best.result = self.descend(np.asarray(best.at), limit=1)
            return replace(best.result, unfinished=True)
        return best.result

    def _from_several(
        self, nested: Sequence[Mapping[str, float]], report: Report, best: BestSoFar
    ) -> None:
        rng = np.random.default_rng(SEED)
        candidates = [self._start(rng) for _ in range(CANDIDATES)]
        drawn = [candidates[index] for index in np.argsort(self._costs(candidates))]
        starts = [*map(self.space.theta, nested), *drawn][: max(STARTS, len(nested) + 1)]
        for number, start in enumerate(starts):
            report(
                (number + 0.3) / (len(starts) + 0.3),
                f"best so far {self.percent(best.cost):.3g} %" if number else "",
            )
            # A start that meets the end of another start would end there too.
            with suppress(_KnownError):
                best.take(self.descend(start, best=best, again=False))

    def lowest(self, starts: Sequence[Mapping[str, float]]) -> tuple[float, Mapping[str, float]]:
        """Return the smallest cost of several starts, and its first start."""
        costs = self._costs([*map(self.space.theta, starts)])
        return min(costs), starts[int(np.argmin(costs))]

    def _costs(self, thetas: Sequence[np.ndarray]) -> list[float]:
        return [0.5 * float(residual @ residual) for residual in self.residuals(thetas)]

    def percent(self, cost: float) -> float:
        """Return the root of a cost relative to the measured signal [%]."""
        return (
            100.0
            * math.sqrt(2.0 * cost)
            * self.unit
            / max(float(np.linalg.norm(self.problem.measured)), np.finfo(float).tiny)
        )

    def refit(
        self,
        start: Mapping[str, float],
        rows: np.ndarray | None = None,
        limit: int = EVALUATIONS // 3,
        best: BestSoFar | None = None,
    ) -> Solution:
        """Return the solution from a nearby start; with some `rows`, to the accuracy of held-out errors."""
        chosen, tolerance = (slice(None), 0.0) if rows is None else (rows, HELD_OUT)
        return self.descend(self.space.theta(start), chosen, limit, best, tolerance)

    def finite(self, residual: np.ndarray) -> np.ndarray:
        """Return a residual over its unit, clipped to finite values."""
        return np.clip(
            np.nan_to_num(residual / self.unit, nan=FAR, posinf=FAR, neginf=-FAR), -FAR, FAR
        )

    def residuals(
        self, thetas: Sequence[np.ndarray], rows: np.ndarray | slice = slice(None)
    ) -> list[np.ndarray]:
        """Return the residual over its unit at each of several coordinates."""
        with np.errstate(over="ignore", invalid="ignore"):
            residuals = abreast(self.problem.residual)(
                [self.space.values(theta) for theta in thetas]
            )
            return [self.finite(residual)[rows] for residual in residuals]

    def descend(
        self,
        theta: np.ndarray,
        rows: np.ndarray | slice = slice(None),
        limit: int = EVALUATIONS,
        best: BestSoFar | None = None,
        tolerance: float = 0.0,
        *,
        again: bool = True,
    ) -> Solution:
        """Return a nearby minimum; unless `again`, a known minimum raises _KnownError."""
        from scipy.optimize import least_squares

        low, high = self.space.low, self.space.high
        linearised = Linearised(self, rows)

        def residual(x: np.ndarray) -> np.ndarray:
            rest = linearised.at(x)[1]
            if best is not None:
                best.see(x, 0.5 * float(rest @ rest))
                if not again and best.is_known(x):
                    raise _KnownError
            return rest

        # The method needs a start strictly inside the bounds.
        width = np.minimum(high - low, 1.0)
        theta = np.clip(theta, low + 1e-4 * width, high - 1e-4 * width)
        ended: Any = least_squares(
            residual,
            theta,
            jac=cast(Any, linearised.jacobian),
            bounds=(low, high),
            max_nfev=limit,
            ftol=max(SIMULATED if self.simulates else 1e-9, tolerance),
            xtol=1e-7,
            gtol=1e-10,
        )
        theta, at_edge = ended.x.copy(), {}
        for index, transform in enumerate(self.space.transforms):
            if theta[index] - transform.low < EDGE:
                theta[index], at_edge[transform.name] = transform.low, "smallest"
            elif transform.high - theta[index] < EDGE:
                theta[index], at_edge[transform.name] = transform.high, "largest"
        return Solution(self.space, theta, -ended.jac * self.unit, at_edge, float(ended.cost))

    def _start(self, rng: np.random.Generator) -> np.ndarray:
        """Return a start: sliding friction from the linear fit, other parameters drawn from their ranges."""
        variables = self.problem.parameters.variables
        values = self.problem.parameters.complete({})
        for transform in self.space.transforms:
            if transform.form == "below":
                inside = rng.uniform(transform.low, transform.high)
            else:
                drawn = self._draw(transform, variables[transform.name], rng)
                inside = transform.theta(drawn + transform.base(values), values)
            values[transform.name] = transform.value(inside, values)
        return self.space.theta(values)

    def _draw(self, transform: Transform, variable: Variable, rng: np.random.Generator) -> float:
        if transform.name in self.sliding.values:
            value = self.sliding.values[transform.name]
            # Friction before its first slip is stiff too: both share the visible stiffness.
            return value * rng.uniform(0.2, 1.0) if variable.quantity == "force/length" else value
        if variable.excitation in OF_SLOTS:
            return self.problem.parameters.component.defaults.get(transform.name, 0.0)
        if transform.form == "excess":
            return self.sliding.coulomb * rng.exponential(0.3)
        if variable.quantity == "force":
            return self.sliding.coulomb
        if (variable.quantity, variable.excitation) == ("force*time/length", "speed"):
            return self.sliding.viscous
        if transform.form == "log":
            return math.exp(rng.uniform(transform.low, transform.high))
        return self.scales.magnitude(variable) * 10.0 ** rng.uniform(-2.0, 1.0)
