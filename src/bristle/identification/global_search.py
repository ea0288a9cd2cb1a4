"""Global search: differential evolution over the whole range of every parameter, where descents end in the wrong place.

What is positive is sought in its logarithm, one decade to either side of what is typical of the log at least. The best
member is then polished by a descent.

References
----------
.. [1] R. Storn, K. Price, "Differential evolution: a simple and efficient heuristic for global optimization over
   continuous spaces", Journal of Global Optimization 11(4), 1997. doi:10.1023/A:1008202821328
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bristle.core.diagnostic import BestSoFar
from bristle.core.lazy import cached_property
from bristle.core.least_squares import bounded, non_negative
from bristle.identification.parameter_space import Solution, Transform
from bristle.identification.problem import SINGULAR, Residual

MEMBERS, FEWEST_MEMBERS = 6, 24  # for each coordinate, in all
GENERATIONS = 60
FAR = 10.0  # times a typical value: the range of what has no bounds
EVOLUTION_SEED = 19_970_403


class Side(NamedTuple):
    """One side of the box: from `low` to `high`, in the logarithm of the coordinate where it is `logarithmic`."""

    low: float
    high: float
    logarithmic: bool

    def coordinate(self, at: float) -> float:
        """Return the coordinate of a point of the box."""
        return math.exp(at) if self.logarithmic else at

    def at(self, coordinate: float) -> float:
        """Return the point of the box for a coordinate, put inside."""
        position = math.log(max(coordinate, 1e-300)) if self.logarithmic else coordinate
        return min(max(position, self.low), self.high)


def box_of(coordinates: Sequence[Transform], theta: np.ndarray) -> tuple[Side, ...]:
    """Return a finite box that holds `theta`: the bounds of each coordinate, or ten times what is typical."""
    sides = []
    for limits, at in zip(coordinates, theta.tolist(), strict=True):
        most = min(limits.high, FAR * max(1.0, abs(at)))
        if limits.form == "log":
            sides.append(Side(limits.low, limits.high, False))
        elif limits.low >= 0.0:
            least = max(limits.low, min(1.0, at if at > 0.0 else 1.0) / FAR)
            sides.append(Side(math.log(least), math.log(max(most, 2.0 * least)), True))
        else:
            sides.append(Side(max(limits.low, -FAR * max(1.0, abs(at))), most, False))
    return tuple(sides)


def evolved(
    costs: Callable[[Sequence[np.ndarray]], Sequence[float]],
    box: Sequence[Side],
    start: np.ndarray,
    best: BestSoFar,
    report: Callable[[float], None],
) -> np.ndarray:
    """Return the coordinates of the best member that differential evolution came to; `start` is one of the first.

    `best` takes note of all that is tried, `report` is told the share of the work done.
    """
    from scipy.optimize import differential_evolution

    def coordinates(at: np.ndarray) -> np.ndarray:
        return np.array([side.coordinate(side_position) for side, side_position in zip(box, at.tolist(), strict=True)])

    generation = 0

    def after(_: np.ndarray, convergence: float) -> None:
        nonlocal generation
        generation += 1
        report(generation / GENERATIONS)

    def everywhere(_: object, members: Iterable[np.ndarray]) -> list[float]:
        points = [coordinates(member) for member in members]
        generation_costs = list(costs(points))
        for point, cost_of_point in zip(points, generation_costs, strict=True):
            best.see(point, cost_of_point)
        return generation_costs

    # Newer versions of scipy call the seed by another name, too.
    options: dict[str, Any] = {"seed": EVOLUTION_SEED, "workers": everywhere}
    solution = differential_evolution(
        lambda at: costs([coordinates(at)])[0],
        [(side.low, side.high) for side in box],
        maxiter=GENERATIONS,
        tol=0.02,  # spread of the costs over their mean at which the members are one
        polish=False,
        popsize=max(MEMBERS, math.ceil(FEWEST_MEMBERS / len(box))),
        init="latinhypercube",
        updating="deferred",
        callback=after,
        x0=np.array([side.at(side_value) for side, side_value in zip(box, start.tolist(), strict=True)]),
        **options,
    )
    return coordinates(solution.x)


STEPS = 6
SHORT = 0.02  # of the longest step


@dataclass(frozen=True)
class Refit:
    """Fits like the first one, of which `solution` is the end, on some rows.

    Coordinates that are not `free` stay where a fit begins. Of a `linear` signal the first step is all.
    """

    solution: Solution
    free: np.ndarray
    rows: np.ndarray | slice = field(default_factory=lambda: slice(None))
    linear: bool = False

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The orthogonal factor, the triangle, its inverse, and the lengths that columns were divided by."""
        columns = self.solution.jacobian[self.rows][:, self.free]
        scale = np.linalg.norm(columns, axis=0)
        scale[scale == 0.0] = 1.0
        q, r = np.linalg.qr(columns / scale)
        return q, r, np.linalg.pinv(r, rcond=SINGULAR), scale

    def step(self, theta: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Return the step of the free coordinates that best takes away a residual, shape (row,)."""
        q, r, inverse, scale = self._factors
        target = q.T @ residual[self.rows]
        space = self.solution.space
        low, high = ((bound - theta)[self.free] * scale for bound in (space.low, space.high))
        scaled = inverse @ target
        if np.any(scaled < low) or np.any(scaled > high):
            floored = np.isfinite(low)
            if np.any(np.isfinite(high)):
                scaled = np.clip(bounded(r, target, np.minimum(low, -1e-300), np.maximum(high, 1e-300))[0], low, high)
            else:
                # Above a floor only: non-negative least squares, in which what has no floor is a difference.
                base = np.where(floored, low, 0.0)
                parts = non_negative(np.hstack([r, -r[:, ~floored]]), target - r @ base)
                scaled = base + parts[: low.size]
                scaled[~floored] -= parts[low.size :]
        step = np.zeros_like(theta)
        step[self.free] = scaled / scale
        return step

    def solve(self, problem: Residual, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates that fit a problem on the same rows best, and the residual of all its rows there."""
        space, jacobian = self.solution.space, self.solution.jacobian[:, self.free]
        theta, residual, longest = start, problem.residual(space.values(start)), 0.0
        for _ in range(STEPS):
            step = self.step(theta, residual)
            change = jacobian @ step[self.free]
            if self.linear or space.linear:
                return theta + step, residual - change
            variance, length = float(np.mean(residual[self.rows] ** 2)), float(np.sum(change[self.rows] ** 2))
            longest = max(longest, length)
            if length <= max(0.03**2 * variance, SHORT**2 * longest):  # of a standard error
                break
            for share in (1.0, 0.3):  # of a step that led too far
                trial = np.clip(theta + share * step, space.low, space.high)
                after = problem.residual(space.values(trial))
                before, beside = residual[self.rows], after[self.rows]
                if float(beside @ beside) < float(before @ before):
                    break
            else:
                break
            theta, residual = trial, after
        return theta, residual
