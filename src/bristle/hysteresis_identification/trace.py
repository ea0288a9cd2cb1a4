r"""The memory of a path, before any measure is known: what every Preisach operator would look up along it.

The output of a Preisach operator is :math:`f = f_n \pm 2E(\max(u, u_n), \min(u, u_n))`, or the virgin curve
:math:`\pm E(|u|, -|u|)`. Which turning point :math:`n` a sample hangs on follows from the input alone. An
operator that is linear in its weights, :math:`E = \sum_k w_k e_k(\alpha, \beta)`, is therefore linear along the whole
path, and its regressor needs the functions :math:`e_k` once for each sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bristle.logs.curves import Curves

__all__ = ["Rows", "Trace", "design", "outputs_of", "stacked", "trace_of"]

Features = Callable[[np.ndarray, np.ndarray], np.ndarray]
Rows = Sequence[np.ndarray] | None
VIRGIN = -1


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
    base = np.full(path.size, VIRGIN)
    turned: list[int] = []
    last_side = 0.0
    for first, last, side in _runs(path):
        if last_side * side < 0.0:
            turned.append(first - 1)
        last_side = side
        _follow(path, first, last, side, turned, base)
    from_turn = base >= 0
    turn = np.where(from_turn, path[base], -path)
    alpha, beta = np.maximum(path, turn), np.minimum(path, turn)
    return Trace(base, np.where(path >= turn, 1.0, -1.0), alpha, beta, path.size - np.size(u))


def _runs(path: np.ndarray) -> list[tuple[int, int, float]]:
    """Return the monotone runs: first sample, last sample, direction; the path begins at 0."""
    steps = np.sign(np.diff(path, prepend=0.0))
    moving = np.flatnonzero(steps)
    if moving.size == 0:
        return []
    signs = steps[moving]
    turns = np.flatnonzero(signs[1:] != signs[:-1]) + 1
    starts = moving[np.concatenate([[0], turns])]
    ends = np.concatenate([starts[1:], [path.size]])
    return [(int(a), int(b), float(steps[a])) for a, b in zip(starts, ends, strict=True)]


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
    base[begin:last] = VIRGIN


def design(trace: Trace, features: Features, rows: np.ndarray | None = None) -> np.ndarray:
    """Return the regressor of an operator that is linear in its weights, shape (row, weight).

    Parameters
    ----------
    trace : Trace
        The memory along the path.
    features : callable
        Returns the Everett function of each weight at (alpha, beta), shape (sample, weight).
    rows : ndarray of int, optional
        Which samples after the history are wanted; all of them where not given.
    """
    samples = np.arange(trace.base.size - trace.first) if rows is None else rows
    needed = np.zeros(trace.base.size, dtype=bool)
    needed[samples + trace.first] = True
    for turn in np.unique(trace.base)[::-1]:
        if turn != VIRGIN and needed[trace.base == turn].any():
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
        if base != VIRGIN:
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
