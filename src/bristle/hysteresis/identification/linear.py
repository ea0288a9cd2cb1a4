r"""The Preisach measure on a grid of cells, from data, by least squares with a sign for each cell.

On the diagonal the measure is a spring and positive. Off it, a magnet has a positive measure and friction a negative
one: relays that all add up the same way cannot give a force that opposes every reversal. The textbook condition
:math:`\mu \ge 0` everywhere fits a friction no better than a spring would. Neither sign is assumed here: both are
fitted, and the data choose.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.hysteresis import prandtl_ishlinskii, preisach_grid
from bristle.hysteresis.identification.trace import NormalEquations, Rows, Trace, outputs_of, stacked, trace_of
from bristle.logs.curves import Curves

SIGNS = ("magnet", "friction", "textbook")
RESOLUTION = 30  # stops, or cells along a side of a grid
LAGGING = ("piezo",)  # kinds whose output may lag behind the input: plays are tried beside stops
NEGLIGIBLE = 1e-5  # of the largest force of a stop: a weight that rounding left
ROWS_MOST = 10_000  # of a regressor: beyond, samples are left out evenly


class GridFit(NamedTuple):
    """A Preisach operator from data: the sign off the diagonal, and the share of cells that no curve crosses."""

    operator: Model
    sign: str
    rms: float
    unseen: float


def fit_grid(recorded: Curves, *, cells: int = RESOLUTION, sign: str | None = None, rows: Rows = None) -> GridFit:
    """Fit the measure of each cell of a grid to recorded hysteresis, with the sign off the diagonal that fits better.

    Raises
    ------
    InputError
        If the input does not move, or there is no such sign.
    """
    if cells != int(cells) or not 2 <= cells <= 100:
        raise InputError("must be a whole number", path="cells", value=cells, allowed="2 to 100")
    if sign is not None and sign not in SIGNS:
        raise InputError("no such sign", path="sign", value=sign, allowed=", ".join(SIGNS))
    low, high = _range_of(recorded)
    features = _Cells(low, high, int(cells), relays=sign == "textbook")
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    samples = [np.arange(curve.u.size) for curve in recorded.curves] if rows is None else rows
    thinned = [part[:: max(sum(part.size for part in samples) // ROWS_MOST, 1)] for part in samples]
    equations = NormalEquations.of(stacked(traces, features, thinned), outputs_of(recorded, thinned))
    tried = {name: equations.solve(features.signs(name)) for name in ((sign,) if sign else ("magnet", "friction"))}
    chosen = min(tried, key=lambda name: tried[name].rms)
    best = tried[chosen]
    operator = preisach_grid(kind=recorded.kind, low=low, high=high, E=features.everett(best.weights), offset=best.offset)
    return GridFit(operator, chosen, best.rms, float(np.mean(equations.scale == 0.0)))


def _range_of(recorded: Curves) -> tuple[float, float]:
    low, high = recorded.low, recorded.high
    if recorded.start == "virgin":
        low, high = min(low, -high), max(high, -low)
    if not high > low:
        raise InputError("does not move", path="input", value=high)
    return low, high


class _Cells:
    """The cells of a grid, as functions of (alpha, beta)."""

    def __init__(self, low: float, high: float, count: int, *, relays: bool) -> None:
        self.low, self.high, self.count, self.relays = low, high, count, relays
        self.i, self.j = np.tril_indices(count)
        self.diagonal = np.flatnonzero(self.i == self.j)

    def __call__(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return the share of each cell that lies in the triangle of (alpha, beta), shape (sample, cell)."""
        cell = np.arange(self.count)
        size = (self.high - self.low) / self.count
        a = np.clip((alpha[:, None] - self.low) / size - cell, 0.0, 1.0)
        b = np.clip(cell + 1.0 - (beta[:, None] - self.low) / size, 0.0, 1.0)
        shares = a[:, self.i] * b[:, self.j]
        inside = np.maximum(a + b - 1.0, 0.0)
        shares[:, self.diagonal] = inside**2 if self.relays else inside
        return shares

    def signs(self, name: str) -> np.ndarray:
        """Return the sign of each cell: positive on the diagonal, negative off it for friction."""
        signs = np.ones(self.i.size)
        if name == "friction":
            signs[self.i != self.j] = -1.0
        return signs

    def everett(self, weights: np.ndarray) -> np.ndarray:
        """Return the Everett function at the levels, in the order of `preisach_grid`."""
        mass = np.zeros((self.count, self.count))
        mass[self.i, self.j] = weights
        # The triangle of (i + 1, j) holds the cells of rows up to i and columns from j on.
        summed = np.cumsum(np.cumsum(mass, axis=0)[:, ::-1], axis=1)[:, ::-1]
        return summed[self.i, self.j]


class StopsFit(NamedTuple):
    r"""A Prandtl-Ishlinskii operator from data, and the constant output beside it.

    .. math:: f = f_0 + k u + \sum_i w_i\,\mathcal S_{r_i}[u], \qquad w_i \ge 0, \quad k \ge 0

    Where the output lags behind the input, as the travel of a piezo actuator behind its voltage, plays are fitted too,
    :math:`\mathcal P_r[u] = u - \mathcal S_r[u]`, and what errs less is taken. Neighbouring weights trade places under
    noise, the virgin curve :math:`f_v(x) = k x + \sum_i w_i \min(x, r_i)` does not.
    """

    operator: Model
    offset: float
    rms: float


def thresholds_over(largest: float, count: int = RESOLUTION, smallest: float | None = None) -> np.ndarray:
    """Return thresholds spaced evenly in their logarithm, shape (count,) [m or rad]."""
    if count != int(count) or count < 2:
        raise InputError("must be a whole number", path="count", value=count, allowed=">= 2")
    low = 0.01 * largest if smallest is None else smallest
    if not 0.0 < low < largest < np.inf:
        raise InputError(
            "there is no range for the thresholds",
            path="thresholds",
            value=f"{low} to {largest}",
            mend="The input must move, and by more than its smallest step",
        )
    return np.geomspace(low, largest, int(count))


def fit_stops(recorded: Curves, *, count: int = RESOLUTION, thresholds: np.ndarray | None = None, rows: Rows = None) -> StopsFit:
    """Fit stops and a spring to recorded hysteresis; stops that get no weight are left out of the operator."""
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    # The largest threshold that slips: half the way from a turning point, or from the origin.
    reach = max(0.5 * float(np.max(trace.alpha - trace.beta)) for trace in traces)
    r = thresholds_over(reach, count) if thresholds is None else np.asarray(thresholds, dtype=float)

    fit = _fit(recorded, traces, r, rows, plays=False)
    if recorded.kind not in LAGGING:
        return fit
    lagging = _fit(recorded, traces, r, rows, plays=True)
    return lagging if lagging.rms < fit.rms else fit


def _fit(recorded: Curves, traces: list[Trace], r: np.ndarray, rows: Rows, *, plays: bool) -> StopsFit:
    """Fit stops, or what is left of the input beside each of them: plays, whose output lags behind the input."""

    def features(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        half = 0.5 * (alpha - beta)[:, None]
        stops = np.minimum(half, r)
        return np.hstack([half - stops if plays else stops, half])

    solution = NormalEquations.of(stacked(traces, features, rows), outputs_of(recorded, rows)).solve()
    weights, spring = solution.weights[:-1], float(solution.weights[-1])
    used = weights * r > NEGLIGIBLE * float(np.max(weights * r))
    used[-1] |= not used.any()
    if plays:  # a play is the input less the stop of its threshold
        spring, weights = spring + float(np.sum(weights[used])), -weights
    operator = prandtl_ishlinskii(kind=recorded.kind, thresholds=r[used], weights=weights[used], spring=spring)
    return StopsFit(operator, solution.offset, solution.rms)
