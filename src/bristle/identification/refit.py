"""Refit near a first fit: Gauss-Newton with the Jacobian of its solution."""

from dataclasses import dataclass, field

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import bounded, non_negative
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import SINGULAR, Residual

STEPS = 6
SHORT = 0.02  # of the longest step


@dataclass(frozen=True)
class Refit:
    """Refits from the `solution` of a first fit, on some rows; one step for a `linear` signal."""

    solution: Solution
    rows: np.ndarray | slice = field(default_factory=lambda: slice(None))
    linear: bool = False

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The orthogonal factor, the triangle, its inverse, and the lengths of the columns."""
        columns = self.solution.jacobian[self.rows]
        scale = np.linalg.norm(columns, axis=0)
        scale[scale == 0.0] = 1.0
        q, r = np.linalg.qr(columns / scale)
        return q, r, np.linalg.pinv(r, rcond=SINGULAR), scale

    def step(self, theta: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Return the step of the coordinates that best removes a residual, shape (row,)."""
        q, r, inverse, scale = self._factors
        target = q.T @ residual[self.rows]
        space = self.solution.space
        low, high = ((bound - theta) * scale for bound in (space.low, space.high))
        scaled = inverse @ target
        if np.any(scaled < low) or np.any(scaled > high):
            floored = np.isfinite(low)
            if np.any(np.isfinite(high)):
                scaled = np.clip(
                    bounded(r, target, np.minimum(low, -1e-300), np.maximum(high, 1e-300))[0],
                    low,
                    high,
                )
            else:
                # Lower bounds only: non-negative least squares, with unbounded coordinates as differences.
                base = np.where(floored, low, 0.0)
                parts = non_negative(np.hstack([r, -r[:, ~floored]]), target - r @ base)
                scaled = base + parts[: low.size]
                scaled[~floored] -= parts[low.size :]
        return np.asarray(scaled / scale)

    def solve(self, problem: Residual, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates that fit a problem on the same rows best, and the residual of all its rows there."""
        space, jacobian = self.solution.space, self.solution.jacobian
        theta, residual, longest = start, problem.residual(space.values(start)), 0.0
        for _ in range(STEPS):
            step = self.step(theta, residual)
            change = jacobian @ step
            if self.linear or space.linear:
                return theta + step, residual - change
            variance, length = (
                float(np.mean(residual[self.rows] ** 2)),
                float(np.sum(change[self.rows] ** 2)),
            )
            longest = max(longest, length)
            if length <= max(0.03**2 * variance, SHORT**2 * longest):  # of a standard error
                break
            for share in (1.0, 0.3, 0.1, 0.03, 0.01):  # shorter step if it overshoots
                trial = np.clip(theta + share * step, space.low, space.high)
                after = problem.residual(space.values(trial))
                before, beside = residual[self.rows], after[self.rows]
                if float(beside @ beside) < float(before @ before):
                    break
            else:
                break
            theta, residual = trial, after
        return theta, residual
