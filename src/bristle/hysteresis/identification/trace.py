r"""The memory of a path, before any measure is known: what every Preisach operator would look up along it.

The output of a Preisach operator is :math:`f = f_n \pm 2E(\max(u, u_n), \min(u, u_n))`, or the virgin curve
:math:`\pm E(|u|, -|u|)`. Which turning point :math:`n` a sample hangs on follows from the input alone. An
operator that is linear in its weights, :math:`E = \sum_k w_k e_k(\alpha, \beta)`, is therefore linear along the whole
path, and its regressor needs the functions :math:`e_k` once for each sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import non_negative
from bristle.logs.curves import Curves
from bristle.logs.turns import reversals

Features = Callable[[np.ndarray, np.ndarray], np.ndarray]
Rows = Sequence[np.ndarray] | None
RIDGE = 1e-13  # of the mean square of a column: keeps columns that are alike apart in rounding
UNSEEN = 1e-12  # of the largest column: what is smaller is rounding


class Trace(NamedTuple):
    """What a sample hangs on, shape (sample,) each.

    ``base`` is the number of the sample where the branch began, -1 on the virgin curve; the Everett function is asked
    at (`alpha`, `beta`), and counts with the sign `side`. Samples before `first` are the history.
    """

    base: np.ndarray
    side: np.ndarray
    alpha: np.ndarray
    beta: np.ndarray
    first: int


def trace_of(u: np.ndarray, history: np.ndarray | Sequence[float] = ()) -> Trace:
    """Return the memory along an input."""
    path = np.concatenate([np.asarray(history, dtype=float), np.asarray(u, dtype=float)])
    base = np.full(path.size, -1)
    turned: list[int] = []
    # Monotone runs; the path begins at 0.
    steps = np.diff(path, prepend=0.0)
    starts = [*np.flatnonzero(steps)[:1].tolist(), *reversals(steps).tolist()]
    for number, (first, last) in enumerate(pairwise([*starts, path.size])):
        if number:
            turned.append(first - 1)
        _follow(path, first, last, float(np.sign(steps[first])), turned, base)
    from_turn = base >= 0
    turn = np.where(from_turn, path[base], -path)
    alpha, beta = np.maximum(path, turn), np.minimum(path, turn)
    return Trace(base, np.where(path >= turn, 1.0, -1.0), alpha, beta, path.size - np.size(u))


def _follow(path: np.ndarray, first: int, last: int, side: float, turned: list[int], base: np.ndarray) -> None:
    """Say of the samples of one run what they hang on, and forget the turning points that they pass."""
    ahead = side * path[first:last]
    begin = first
    while turned:
        depth = len(turned)
        # With one point left the branch merges with the virgin curve at its mirror image.
        limit = side * path[turned[-2]] if depth >= 2 else -side * path[turned[-1]]
        end = first + int(np.searchsorted(ahead, limit, side="left"))
        base[begin:end] = turned[-1]
        if end == last:
            return
        begin = end
        del turned[-2:]
    base[begin:last] = -1


def design(trace: Trace, features: Features, rows: np.ndarray | None = None) -> np.ndarray:
    """Return the regressor of the Everett functions of each weight at `rows` after the history, shape (row, weight)."""
    samples = np.arange(trace.base.size - trace.first) if rows is None else rows
    needed = np.zeros(trace.base.size, dtype=bool)
    needed[samples + trace.first] = True
    for turn in np.unique(trace.base)[::-1]:
        if turn >= 0 and needed[trace.base == turn].any():
            needed[turn] = True
    index = np.flatnonzero(needed)
    place = np.full(trace.base.size, -1)
    place[index] = np.arange(index.size)
    values = trace.side[index, None] * features(trace.alpha[index], trace.beta[index])
    bases = trace.base[index]
    order = np.argsort(bases, kind="stable")
    edges = np.flatnonzero(np.diff(bases[order])) + 1
    for group in np.split(order, edges) if order.size else ():
        base = bases[group[0]]
        if base >= 0:
            values[group] = values[place[base]] + 2.0 * values[group]
    return values[place[samples + trace.first]]


def stacked(traces: Sequence[Trace], features: Features, rows: Rows = None) -> np.ndarray:
    """Return the regressors of several paths, one below the other."""
    rows_of_traces = [None] * len(traces) if rows is None else rows
    return np.concatenate([design(trace, features, part) for trace, part in zip(traces, rows_of_traces, strict=True)])


def outputs_of(recorded: Curves, rows: Rows = None) -> np.ndarray:
    """Return the recorded outputs of the same rows, shape (row,)."""
    if rows is None:
        return np.concatenate([curve.f for curve in recorded.curves])
    return np.concatenate([curve.f[part] for curve, part in zip(recorded.curves, rows, strict=True)])


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
