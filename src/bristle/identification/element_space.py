"""The coordinates in which elements that slip are fitted again: one stiffness for each of them, and all else."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.identification.fixed_shape import ARRAYS, TOTAL
from bristle.identification.parameter_space import ParameterSpace

__all__ = ["DIFFERENCE", "ElementSpace"]

CURVE = 12  # displacements at which the virgin curve has intervals
DIFFERENCE = "difference"  # half of it, between the levels forward and backward


@dataclass(frozen=True, kw_only=True)
class ElementSpace(ParameterSpace):
    """One stiffness for each element, then the other free parameters, then the factors of the slots.

    Parameters
    ----------
    thresholds : ndarray, shape (element,)
        Deflections at which elements slip [m or rad].
    levels : mapping of str to float
        The parameters that tell the level of the elements, and the sign of the difference in each.
    rest : tuple of str
        All other free parameters, as they are reported.
    """

    thresholds: np.ndarray
    levels: Mapping[str, float]
    rest: tuple[str, ...]

    @classmethod
    def around(
        cls, thresholds: np.ndarray, others: Sequence[str], factors: Sequence[str], levels: Mapping[str, float],
        free: Sequence[str], positive: Collection[str],
    ) -> ElementSpace:  # fmt: skip
        """Return the space of elements; of the `others` those that are `positive` are not negative, as no stiffness."""
        names = (*(f"k_{number}" for number in range(thresholds.size)), *others, *factors)
        low = [0.0 if name in positive else -np.inf for name in (*others, *factors)]
        return cls(
            names, np.array([*np.zeros(thresholds.size), *low]), np.full(len(names), np.inf), linear=not factors,
            curve=tuple(np.geomspace(thresholds[0], thresholds[-1], CURVE).tolist()), thresholds=thresholds,
            levels=levels, rest=tuple(name for name in free if name not in (*levels, TOTAL)),
        )  # fmt: skip

    @property
    def reported(self) -> tuple[str, ...]:
        """The level, the stiffness, then all else."""
        return (*self.levels, TOTAL, *self.rest)

    def values(self, theta: np.ndarray) -> dict[str, Any]:
        """Return what the model takes [SI]; an element without force still has its threshold."""
        r = self.thresholds
        stiffness = np.maximum(theta[: r.size], 1e-12 * np.sum(theta[: r.size]))
        level = float(stiffness @ r)
        rest = dict(zip(self.names[r.size :], theta[r.size :].tolist(), strict=True))
        difference = rest.pop(DIFFERENCE, 0.0)
        levels = {name: level + sign * difference for name, sign in self.levels.items()}
        return dict(zip(ARRAYS, (stiffness, stiffness * r / level), strict=True)) | levels | rest

    def derivative(self, theta: np.ndarray) -> np.ndarray:
        """Return the derivative of what is reported, shape (reported, coordinate)."""
        r, names = self.thresholds, self.names
        first = np.zeros((len(self.levels) + 1, len(names)))
        first[:-1, : r.size], first[-1, : r.size] = r, 1.0
        if DIFFERENCE in names:
            first[:-1, names.index(DIFFERENCE)] = list(self.levels.values())
        return np.vstack([first, np.eye(len(names))[[names.index(name) for name in self.rest]]])

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return what is reported [SI], and the virgin curve."""
        reach = np.minimum.outer(np.array(self.curve), self.thresholds)
        return np.concatenate([self.derivative(theta) @ theta, reach @ theta[: self.thresholds.size]])
