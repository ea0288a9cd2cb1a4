r"""Fitting the same model again to a log that is nearly the same, many times over.

Near the solution the residual of a fit is linear in its coordinates, with the Jacobian that the fit ended with. Its
factors are computed once; each further fit takes steps

.. math:: \theta \leftarrow \theta + \arg\min_{\delta} \left\| J \delta - r(\theta) \right\|^2

within the bounds, with the residual `r` of the model itself, until a step is small against the standard errors, or
against the longest one. scipy's ``least_squares`` would compute the Jacobian anew for each of hundreds of fits.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import bounded, non_negative
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import Residual

__all__ = ["Refit"]

STEPS = 6
SMALL = 0.03  # of a standard error
SHORT = 0.02  # of the longest step
SHORTER = 0.3  # of a step that led too far
SINGULAR = 1e-7  # of the largest singular value


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
            scaled = _bounded(r, target, low, high)
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
            if length <= max(SMALL**2 * variance, SHORT**2 * longest):
                break
            for share in (1.0, SHORTER):
                trial = np.clip(theta + share * step, space.low, space.high)
                after = problem.residual(space.values(trial))
                if _square(after[self.rows]) < _square(residual[self.rows]):
                    break
            else:
                break
            theta, residual = trial, after
        return theta, residual


def _bounded(r: np.ndarray, target: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the least-squares solution within bounds, of which each is finite on one side at most or on both."""
    floored = np.isfinite(low)
    if np.any(np.isfinite(high)):
        solution, _ = bounded(r, target, np.minimum(low, -1e-300), np.maximum(high, 1e-300))
        return np.clip(solution, low, high)
    # Above a floor only: non-negative least squares, in which what has no floor is a difference.
    base = np.where(floored, low, 0.0)
    parts = non_negative(np.hstack([r, -r[:, ~floored]]), target - r @ base)
    solution = base + parts[: low.size]
    solution[~floored] -= parts[low.size :]
    return solution


def _square(rows: np.ndarray) -> float:
    return float(rows @ rows)
