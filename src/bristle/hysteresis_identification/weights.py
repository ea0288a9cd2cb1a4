"""Least squares with a sign for each weight, and a constant that is free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import non_negative

__all__ = ["NormalEquations", "Weighted"]

RIDGE = 1e-13  # of the mean square of a column: keeps columns that are alike apart in rounding
UNSEEN = 1e-12  # of the largest column: what is smaller is rounding


class Weighted(NamedTuple):
    """Weights, constant, and the root mean square of what is left over."""

    weights: np.ndarray
    offset: float
    rms: float


@dataclass(frozen=True)
class NormalEquations:
    """What least squares needs to know of ``target = columns @ weights + offset``, for any choice of signs."""

    gram: np.ndarray
    right: np.ndarray
    scale: np.ndarray
    middle: np.ndarray
    level: float
    square: float
    rows: int

    @classmethod
    def of(cls, columns: np.ndarray, target: np.ndarray, *, constant: bool = True) -> NormalEquations:
        """Return the equations of a regressor, shape (row, weight), and a target, shape (row,).

        Without a `constant`, the means stay in both and the offset is zero.
        """
        middle, level = columns.mean(axis=0), float(target.mean())
        if not constant:
            middle, level = np.zeros_like(middle), 0.0
        centred = columns - middle
        scale = np.sqrt(np.einsum("ij,ij->j", centred, centred))
        scale[scale <= UNSEEN * max(float(scale.max(initial=0.0)), np.finfo(float).tiny)] = 0.0
        centred /= np.where(scale > 0.0, scale, 1.0)
        rest = target - level
        return cls(centred.T @ centred, centred.T @ rest, scale, middle, level, float(rest @ rest), target.size)

    def solve(self, signs: np.ndarray | None = None) -> Weighted:
        """Return the best weights of which each has its sign or is zero; those of sign 0 are free."""
        signs = np.ones(self.scale.size) if signs is None else signs
        active = np.flatnonzero(self.scale)
        # A weight of any sign is the difference of two.
        free = active[signs[active] == 0.0]
        side = np.concatenate([np.where(signs[active] == 0.0, 1.0, signs[active]), -np.ones(free.size)])
        active = np.concatenate([active, free])
        gram = self.gram[np.ix_(active, active)] * np.outer(side, side)
        root = np.linalg.cholesky(gram + RIDGE * max(active.size, 1) * np.eye(active.size))
        target = np.linalg.solve(root, side * self.right[active])
        unit = non_negative(root.T, target, rounds=30 * max(active.size, 1))
        weights = np.bincount(active, side * unit / self.scale[active], minlength=self.scale.size)
        left = self.square - 2.0 * float(unit @ (side * self.right[active])) + float(unit @ gram @ unit)
        rms = float(np.sqrt(max(left, 0.0) / self.rows))
        return Weighted(weights, self.level - float(self.middle @ weights), rms)
