"""Where least squares ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.identification.parameter_space import ParameterSpace

__all__ = ["Solution"]


@dataclass(frozen=True)
class Solution:
    """The best parameters of one problem.

    Parameters
    ----------
    space : ParameterSpace
        The coordinates in which they were sought.
    theta : ndarray, shape (coordinate,)
        Where the search ended.
    jacobian : ndarray, shape (row, coordinate)
        Derivative of the predicted signal with respect to the coordinates.
    at_edge : mapping of str to str
        Of the reported parameters on an edge of their range, which one: ``"smallest"`` or ``"largest"``.
    cost : float
        Half the sum of squares that is left over, in units of the search.
    unfinished : bool
        Whether a person interrupted the search.
    """

    space: ParameterSpace
    theta: np.ndarray
    jacobian: np.ndarray
    at_edge: Mapping[str, str] = field(default_factory=dict)
    cost: float = 0.0
    unfinished: bool = False

    @cached_property
    def values(self) -> dict[str, Any]:
        """The free parameters as the model takes them [SI]."""
        return self.space.values(self.theta)

    @cached_property
    def derivative(self) -> np.ndarray:
        """Derivative of the reported parameters with respect to the coordinates, shape (reported, coordinate)."""
        return self.space.derivative(self.theta)
