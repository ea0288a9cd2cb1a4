"""The best parameters of one problem, and the linear case, which needs no search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle.core.least_squares import bounded, unbounded
from bristle.identification.inverse_dynamics import InverseDynamics

__all__ = ["Solution", "solve_linear"]


@dataclass(frozen=True)
class Solution:
    """Where least squares ended.

    Parameters
    ----------
    values : dict
        The free parameters [SI].
    at_edge : dict
        Of those on an edge of their range, which one: ``"smallest"`` or ``"largest"``.
    jacobian : ndarray, shape (row, free)
        Derivative of the predicted effort with respect to the coordinates of the search.
    derivative : ndarray, shape (free, free)
        Derivative of the parameters with respect to those coordinates.
    cost : float
        Half the sum of squares that is left over, in units of the search.
    unfinished : bool
        Whether a person interrupted the search.
    """

    values: Mapping[str, float]
    at_edge: Mapping[str, str]
    jacobian: np.ndarray
    derivative: np.ndarray
    cost: float = 0.0
    unfinished: bool = False


def solve_linear(problem: InverseDynamics, rows: np.ndarray | slice = slice(None)) -> Solution:
    """Return the least-squares parameters of a model that is linear in them.

    Parameters
    ----------
    problem : InverseDynamics
        A problem whose friction model is linear.
    rows : ndarray or slice
        The rows to use.
    """
    names = problem.parameters.free
    columns = problem.columns[rows]
    target = (problem.dataset.effort - problem.fixed_effort)[rows]
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    variables = problem.parameters.variables
    low = np.array([variables[name].min for name in names])
    high = np.array([variables[name].max for name in names])
    values = unbounded(columns / scale, target) / scale
    at_edge = {}
    if np.any(values < low) or np.any(values > high):
        found, active = bounded(columns / scale, target, low * scale, high * scale)
        values = np.clip(found / scale, low, high)
        at_edge = {
            name: "smallest" if mask < 0 else "largest" for name, mask in zip(names, active, strict=True) if mask
        }
    found_values = dict(zip(names, values.tolist(), strict=True))
    return Solution(found_values, at_edge, columns, np.eye(len(names)))
