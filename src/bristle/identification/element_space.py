"""The coordinates in which elements that slip are fitted again: one stiffness for each of them, and all else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.identification.fixed_shape import ARRAYS, TOTAL

__all__ = ["DIFFERENCE", "ElementSpace"]

CURVE = 12  # displacements at which the virgin curve has intervals
DIFFERENCE = "difference"  # half of it, between the levels forward and backward


@dataclass(frozen=True)
class ElementSpace:
    """One stiffness for each element, then the other free parameters, then the factors of the slots.

    Parameters
    ----------
    thresholds : ndarray, shape (element,)
        Deflections at which elements slip [m or rad].
    others, factors : tuple of str
        Parameters that count once, and factors of the slots.
    levels : mapping of str to float
        The parameters that tell the level of the elements, and the sign of the difference in each.
    free : tuple of str
        All free parameters, as they are reported.
    positive : frozenset of str
        Those of the others that are not negative.
    """

    thresholds: np.ndarray
    others: tuple[str, ...]
    factors: tuple[str, ...]
    levels: Mapping[str, float]
    free: tuple[str, ...]
    positive: frozenset[str]

    @property
    def logarithmic(self) -> frozenset[str]:
        """None of them."""
        return frozenset()

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates."""
        return self._names

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return (*(f"k_{number}" for number in range(self.thresholds.size)), *self.others, *self.factors)

    @property
    def reported(self) -> tuple[str, ...]:
        """The level, the stiffness, then all else."""
        return self._reported

    @cached_property
    def _reported(self) -> tuple[str, ...]:
        return (*self.levels, TOTAL, *self._rest)

    @cached_property
    def _rest(self) -> tuple[str, ...]:
        return tuple(name for name in self.free if name not in (*self.levels, TOTAL))

    @property
    def low(self) -> np.ndarray:
        """Lower bounds: no stiffness, inertia or damping is negative."""
        return self._low

    @cached_property
    def _low(self) -> np.ndarray:
        others = [0.0 if name in self.positive else -np.inf for name in self.others]
        return np.array([*np.zeros(self.thresholds.size), *others, *([-np.inf] * len(self.factors))])

    @property
    def high(self) -> np.ndarray:
        """Upper bounds: none."""
        return self._high

    @cached_property
    def _high(self) -> np.ndarray:
        return np.full(len(self.names), np.inf)

    @property
    def linear(self) -> bool:
        """Whether no factor multiplies the elements."""
        return not self.factors

    @property
    def curve(self) -> tuple[float, ...]:
        """Displacements [m or rad] at which the virgin curve is reported."""
        return self._curve

    @cached_property
    def _curve(self) -> tuple[float, ...]:
        return tuple(np.geomspace(self.thresholds[0], self.thresholds[-1], CURVE).tolist())

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
        return np.vstack([first, np.eye(len(names))[[names.index(name) for name in self._rest]]])

    def numbers(self, theta: np.ndarray) -> np.ndarray:
        """Return what is reported [SI], and the virgin curve."""
        reach = np.minimum.outer(np.array(self.curve), self.thresholds)
        return np.concatenate([self.derivative(theta) @ theta, reach @ theta[: self.thresholds.size]])
