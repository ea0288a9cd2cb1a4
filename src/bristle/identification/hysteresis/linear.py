r"""The Preisach measure on a grid of cells, from data, by least squares with a sign for each cell.

On the diagonal the measure is a spring and positive. Off the diagonal a magnet has a positive measure and friction a
negative one: relays that all add up the same way cannot give a force that opposes every reversal. With the textbook
condition :math:`\mu \ge 0` everywhere, the fit to friction is no better than a spring. bristle fits both signs, and the
data choose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.least_squares import non_negative
from bristle.logs.curves import Curves
from bristle.logs.turns import reversals
from bristle.models.hysteresis import prandtl_ishlinskii, preisach_grid

Features = Callable[[np.ndarray, np.ndarray], np.ndarray]
Rows = Sequence[np.ndarray] | None
UNSEEN = 1e-12  # of the largest column: smaller values are rounding


class Trace(NamedTuple):
    """Branch and Everett function of each sample, shape (sample,) each.

    ``base`` is the number of the sample where the branch began, -1 on the virgin curve. The Everett function is
    evaluated at (`alpha`, `beta`), with the sign `side`. Samples before `first` are the history.
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


def _follow(
    path: np.ndarray, first: int, last: int, side: float, turned: list[int], base: np.ndarray
) -> None:
    """Set the branch of each sample of a monotone run, and forget the turning points that it passes."""
    ahead = side * path[first:last]
    begin = first
    while turned:
        depth = len(turned)
        # With a single point left the branch merges with the virgin curve at its mirror image.
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
    return np.concatenate(
        [design(trace, features, part) for trace, part in zip(traces, rows_of_traces, strict=True)]
    )


def outputs_of(recorded: Curves, rows: Rows = None) -> np.ndarray:
    """Return the recorded outputs of the same rows, shape (row,)."""
    if rows is None:
        return np.concatenate([curve.f for curve in recorded.curves])
    return np.concatenate(
        [curve.f[part] for curve, part in zip(recorded.curves, rows, strict=True)]
    )


class Weighted(NamedTuple):
    """Weights, constant, and the root mean square residual."""

    weights: np.ndarray
    offset: float
    rms: float


@dataclass(frozen=True)
class NormalEquations:
    """Sums of least squares for ``target = columns @ weights + offset``, for any choice of signs."""

    gram: np.ndarray
    right: np.ndarray
    scale: np.ndarray
    middle: np.ndarray
    level: float
    square: float
    rows: int

    @classmethod
    def of(
        cls, columns: np.ndarray, target: np.ndarray, *, constant: bool = True
    ) -> NormalEquations:
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
        return cls(
            centred.T @ centred,
            centred.T @ rest,
            scale,
            middle,
            level,
            float(rest @ rest),
            target.size,
        )

    def solve(self, signs: np.ndarray | None = None) -> Weighted:
        """Return the best weights with the given signs, or zero; those of sign 0 are free."""
        signs = np.ones(self.scale.size) if signs is None else signs
        active = np.flatnonzero(self.scale)
        # A weight of any sign is the difference of two non-negative weights.
        free = active[signs[active] == 0.0]
        side = np.concatenate(
            [np.where(signs[active] == 0.0, 1.0, signs[active]), -np.ones(free.size)]
        )
        active = np.concatenate([active, free])
        gram = self.gram[np.ix_(active, active)] * np.outer(side, side)
        # A share of the mean square of a column separates equal columns, despite rounding.
        root = np.linalg.cholesky(gram + 1e-13 * max(active.size, 1) * np.eye(active.size))
        target = np.linalg.solve(root, side * self.right[active])
        unit = non_negative(root.T, target, rounds=30 * max(active.size, 1))
        weights = np.bincount(active, side * unit / self.scale[active], minlength=self.scale.size)
        left = (
            self.square
            - 2.0 * float(unit @ (side * self.right[active]))
            + float(unit @ gram @ unit)
        )
        return Weighted(
            weights,
            self.level - float(self.middle @ weights),
            float(np.sqrt(max(left, 0.0) / self.rows)),
        )


RESOLUTION = 30  # stops, or cells along a side of a grid


class Fitted(NamedTuple):
    """An operator from data, the constant added to it, the root mean square residual, and notes."""

    operator: Model
    offset: float = 0.0
    rms: float = 0.0
    notes: tuple[str, ...] = ()


def fit_grid(
    recorded: Curves,
    *,
    cells: int = RESOLUTION,
    signs: Sequence[str] = ("magnet", "friction"),
    rows: Rows = None,
) -> Fitted:
    """Fit the measure of each cell of a grid to recorded hysteresis, with the sign off the diagonal that fits best."""
    low, high = recorded.low, recorded.high
    if recorded.start == "virgin":
        low, high = min(low, -high), max(high, -low)
    if not high > low:
        raise InputError("is constant", path="input", value=high)
    features = _Cells(low, high, cells)
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    samples = [np.arange(curve.u.size) for curve in recorded.curves] if rows is None else rows
    # Beyond 10 000 rows samples are left out evenly.
    thinned = [part[:: max(sum(part.size for part in samples) // 10_000, 1)] for part in samples]
    equations = NormalEquations.of(
        stacked(traces, features, thinned), outputs_of(recorded, thinned)
    )
    tried = {name: equations.solve(features.signs(name)) for name in signs}
    chosen = min(tried, key=lambda name: tried[name].rms)
    best, unseen = tried[chosen], float(np.mean(equations.scale == 0.0))
    operator = preisach_grid(
        kind=recorded.kind, low=low, high=high, E=features.everett(best.weights), offset=best.offset
    )
    notes = [
        f"off the diagonal of the plane, a measure with the sign of a {chosen} has the smaller error"
    ]
    notes += (
        [f"no curve crosses {100.0 * unseen:.3g} % of the cells, which stay empty"]
        if unseen > 0.0
        else []
    )
    return Fitted(operator, rms=best.rms, notes=tuple(notes))


class _Cells:
    """The cells of a grid, as functions of (alpha, beta)."""

    def __init__(self, low: float, high: float, count: int) -> None:
        self.low, self.high, self.count = low, high, count
        self.i, self.j = np.tril_indices(count)
        self.diagonal = np.flatnonzero(self.i == self.j)

    def __call__(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return the share of each cell in the triangle of (alpha, beta), shape (sample, cell)."""
        cell = np.arange(self.count)
        size = (self.high - self.low) / self.count
        a = np.clip((alpha[:, None] - self.low) / size - cell, 0.0, 1.0)
        b = np.clip(cell + 1.0 - (beta[:, None] - self.low) / size, 0.0, 1.0)
        shares = a[:, self.i] * b[:, self.j]
        shares[:, self.diagonal] = np.maximum(a + b - 1.0, 0.0)
        return shares

    def signs(self, name: str) -> np.ndarray:
        """Return the sign of each cell: positive on the diagonal, negative off it for friction."""
        return np.where((self.i != self.j) & (name == "friction"), -1.0, 1.0)

    def everett(self, weights: np.ndarray) -> np.ndarray:
        """Return the Everett function at the levels, in the order of `preisach_grid`."""
        mass = np.zeros((self.count, self.count))
        mass[self.i, self.j] = weights
        # The triangle of (i + 1, j) contains the cells of rows up to i and columns from j on.
        return np.cumsum(np.cumsum(mass, axis=0)[:, ::-1], axis=1)[:, ::-1][self.i, self.j]


def thresholds_over(
    largest: float, count: int = RESOLUTION, smallest: float | None = None
) -> np.ndarray:
    """Return thresholds spaced evenly in their logarithm, shape (count,) [m or rad]."""
    low = 0.01 * largest if smallest is None else smallest
    if not 0.0 < low < largest < np.inf:
        interval, mend = f"{low} to {largest}", "The input must move by more than its smallest step"
        raise InputError("must have a range", path="thresholds", value=interval, mend=mend)
    return np.geomspace(low, largest, int(count))


def fit_stops(
    recorded: Curves,
    *,
    count: int = RESOLUTION,
    thresholds: np.ndarray | None = None,
    rows: Rows = None,
) -> Fitted:
    r"""Fit stops and a spring to recorded hysteresis; the operator omits stops with zero weight.

    .. math:: f = f_0 + k u + \sum_i w_i\,\mathcal S_{r_i}[u], \qquad w_i \ge 0, \quad k \ge 0

    If the output lags behind the input, as the travel of a piezo actuator lags behind its voltage, plays are fitted
    too, :math:`\mathcal P_r[u] = u - \mathcal S_r[u]`, and the fit with the smaller error is returned. Noise exchanges
    neighbouring weights, but does not change the virgin curve :math:`f_v(x) = k x + \sum_i w_i \min(x, r_i)`.
    """
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    # The largest threshold that slips: half the way from a turning point, or from the origin.
    reach = max(0.5 * float(np.max(trace.alpha - trace.beta)) for trace in traces)
    r = thresholds_over(reach, count) if thresholds is None else np.asarray(thresholds, dtype=float)
    tried = (False, True) if recorded.kind == "piezo" else (False,)
    return min(
        (_with_stops(recorded, traces, r, rows, plays=plays) for plays in tried),
        key=lambda fit: fit.rms,
    )


def _with_stops(
    recorded: Curves, traces: list[Trace], r: np.ndarray, rows: Rows, *, plays: bool
) -> Fitted:
    """Fit stops, or plays, whose output lags behind the input."""

    def features(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        half = 0.5 * (alpha - beta)[:, None]
        stops = np.minimum(half, r)
        return np.hstack([half - stops if plays else stops, half])

    solution = NormalEquations.of(
        stacked(traces, features, rows), outputs_of(recorded, rows)
    ).solve()
    weights, spring = solution.weights[:-1], float(solution.weights[-1])
    # Of the largest force of a stop: a smaller weight is rounding.
    used = weights * r > 1e-5 * float(np.max(weights * r))
    used[-1] |= not used.any()
    if plays:  # a play is the input less the stop of its threshold
        spring, weights = spring + float(np.sum(weights[used])), -weights
    operator = prandtl_ishlinskii(
        kind=recorded.kind, thresholds=r[used], weights=weights[used], spring=spring
    )
    return Fitted(
        operator, solution.offset, solution.rms, (f"{np.count_nonzero(used)} stops have a weight",)
    )
