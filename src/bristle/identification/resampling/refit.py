r"""Fitting the same model again to a log that is nearly the same, many times over.

Near the solution the residual of a fit is linear in its coordinates, with the Jacobian that the fit ended with. Its
factors are computed once; each further fit takes steps

.. math:: \varphi \leftarrow \varphi + \arg\min_{\delta} \left\| J \delta - r(\varphi) \right\|^2

within the bounds, with the residual `r` of the model itself, until a step is small against the standard errors, or
against the longest one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import bounded, non_negative
from bristle.identification.inverse_dynamics import InverseDynamics, Residual
from bristle.identification.parameters import Scales, ParameterSet, transforms_of
from bristle.identification.solution import Solution

__all__ = ["Refit", "Space", "coordinates_around", "space_of"]

STEPS = 6
SMALL = 0.03  # of a standard error
SHORT = 0.02  # of the longest step
SINGULAR = 1e-7  # of the largest singular value


@dataclass(frozen=True)
class Space:
    """The free parameters as the fit sought them.

    Parameters
    ----------
    names : tuple of str
        The coordinates.
    phi : ndarray, shape (coordinate,)
        Those of the solution.
    low, high : ndarray, shape (coordinate,)
        Bounds of the coordinates.
    jacobian : ndarray, shape (row, coordinate)
        Derivative of the predicted effort with respect to the coordinates.
    values : callable
        Returns what the model takes at some coordinates [SI].
    told : tuple of str
        The parameters that a person is told.
    derivative : ndarray, shape (told, coordinate)
        Their derivative with respect to the coordinates.
    at_edge : frozenset of str
        Those of them that lie on an edge of their range.
    logarithmic : frozenset of str
        Those of them that are sought in their logarithm.
    linear : bool
        Whether the effort is linear in the coordinates.
    curve : tuple of float
        Displacements [m or rad] at which the virgin curve is told, too.
    tell : callable or None
        Returns the parameters that a person is told, and the curve, at some coordinates; `values` where None.
    finished : callable
        Returns what the finished model takes, from `values`: elements of a fixed shape are lists there.
    """

    names: tuple[str, ...]
    theta: np.ndarray
    low: np.ndarray
    high: np.ndarray
    jacobian: np.ndarray
    values: Callable[[np.ndarray], dict[str, Any]]
    told: tuple[str, ...]
    derivative: np.ndarray
    at_edge: frozenset[str] = frozenset()
    logarithmic: frozenset[str] = frozenset()
    linear: bool = False
    curve: tuple[float, ...] = ()
    tell: Callable[[np.ndarray], np.ndarray] | None = None
    finished: Callable[[Mapping[str, Any]], Mapping[str, Any]] = dict

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return the parameters that a person is told [SI], and the curve after them, shape (told and curve,)."""
        if self.tell is not None:
            return self.tell(theta)
        found = self.values(theta)
        return np.array([found[name] for name in self.told])


def space_of(problem: InverseDynamics, solution: Solution, scales: Scales) -> Space:
    """Return the coordinates around a solution, linear model or not."""
    component, names = problem.parameters.component, tuple(solution.values)
    at_edge = frozenset(solution.at_edge)
    if component.linear and not component.relations:
        variables = problem.parameters.variables
        low, high = (np.array([getattr(variables[name], side) for name in names]) for side in ("min", "max"))
        theta = np.array(list(solution.values.values()))
        return Space(
            names, theta, low, high, solution.jacobian, lambda at: dict(zip(names, at.tolist(), strict=True)), names,
            solution.derivative, at_edge, linear=True,
        )  # fmt: skip
    return coordinates_around(problem.parameters, solution, scales)


def coordinates_around(parameters: ParameterSet, solution: Solution, scales: Scales) -> Space:
    """Return the coordinates of a bounded search around its solution."""
    coordinates = transforms_of(parameters, scales)

    def values(theta: np.ndarray) -> dict[str, float]:
        found = parameters.complete({})
        for one, at in zip(coordinates, theta.tolist(), strict=True):
            found[one.name] = one.value(at, found)
        return {one.name: found[one.name] for one in coordinates}

    low, high = np.array([one.low for one in coordinates]), np.array([one.high for one in coordinates])
    theta = np.array([one.theta(solution.values[one.name], solution.values) for one in coordinates])
    logarithmic = frozenset(one.name for one in coordinates if one.form == "log")
    names = tuple(solution.values)
    return Space(
        names, theta, low, high, solution.jacobian, values, names, solution.derivative, frozenset(solution.at_edge),
        logarithmic,
    )  # fmt: skip


@dataclass(frozen=True)
class Refit:
    """Fits like the first one, with some coordinates free and, where wanted, on some rows only.

    Parameters
    ----------
    space : Space
        The coordinates.
    free : ndarray, shape (free,) of bool
        Those that are fitted again; the others stay where a fit begins.
    rows : ndarray or slice
        Rows that are fitted.
    """

    space: Space
    free: np.ndarray
    rows: np.ndarray | slice

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The orthogonal factor, the triangle, its inverse, and the lengths that columns were divided by."""
        columns = self.space.jacobian[self.rows][:, self.free]
        scale = np.linalg.norm(columns, axis=0)
        scale[scale == 0.0] = 1.0
        q, r = np.linalg.qr(columns / scale)
        return q, r, np.linalg.pinv(r, rcond=SINGULAR), scale

    def step(self, theta: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Return the step of the free coordinates that best takes away a residual [N or N*m], shape (row,)."""
        q, r, inverse, scale = self._factors
        target = q.T @ residual[self.rows]
        low, high = ((bound - theta)[self.free] * scale for bound in (self.space.low, self.space.high))
        found = inverse @ target
        if np.any(found < low) or np.any(found > high):
            found = _bounded(r, target, low, high)
        step = np.zeros_like(theta)
        step[self.free] = found / scale
        return step

    def solve(self, problem: Residual, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates that fit a problem best, and the residual of all its rows there.

        Parameters
        ----------
        problem : Residual
            The same model on a log of the same rows.
        start : ndarray, shape (free,)
            Where to begin.
        """
        theta, residual, longest = start, problem.residual(self.space.values(start)), 0.0
        for _ in range(STEPS):
            step = self.step(theta, residual)
            change = self.space.jacobian[:, self.free] @ step[self.free]
            if self.space.linear:
                return theta + step, residual - change
            variance, length = float(np.mean(residual[self.rows] ** 2)), float(np.sum(change[self.rows] ** 2))
            longest = max(longest, length)
            if length <= max(SMALL**2 * variance, SHORT**2 * longest):
                break
            tried = np.clip(theta + step, self.space.low, self.space.high)
            after = problem.residual(self.space.values(tried))
            if not _less(after[self.rows], residual[self.rows]):
                tried = np.clip(theta + 0.3 * step, self.space.low, self.space.high)
                after = problem.residual(self.space.values(tried))
                if not _less(after[self.rows], residual[self.rows]):
                    break
            theta, residual = tried, after
        return theta, residual


def _bounded(r: np.ndarray, target: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the least-squares solution within bounds, of which each is finite on one side at most or on both."""
    floored = np.isfinite(low)
    if np.any(np.isfinite(high)):
        found, _ = bounded(r, target, np.minimum(low, -1e-300), np.maximum(high, 1e-300))
        return np.clip(found, low, high)
    # Above a floor only: non-negative least squares, in which what has no floor is a difference.
    base = np.where(floored, low, 0.0)
    found = non_negative(np.hstack([r, -r[:, ~floored]]), target - r @ base)
    whole = base + found[: low.size]
    whole[~floored] -= found[low.size :]
    return whole


def _less(one: np.ndarray, other: np.ndarray) -> bool:
    return float(one @ one) < float(other @ other)
