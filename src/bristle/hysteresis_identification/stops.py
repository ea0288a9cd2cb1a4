r"""Prandtl and Ishlinskii from data: stops with thresholds laid out beforehand, weights by non-negative least squares.

.. math:: f = f_0 + k u + \sum_i w_i\,\mathcal S_{r_i}[u], \qquad w_i \ge 0, \quad k \ge 0

Where the output lags behind the input, as the travel of a piezo actuator behind its voltage, plays are fitted too,
:math:`\mathcal P_r[u] = u - \mathcal S_r[u]`, and what errs less is taken.

The problem is convex and has one solution. What it says is the virgin curve
:math:`f_v(x) = k x + \sum_i w_i \min(x, r_i)`: neighbouring weights trade places under noise, the curve does not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.hysteresis import prandtl_ishlinskii
from bristle.hysteresis_identification.trace import Rows, Trace, outputs_of, stacked, trace_of
from bristle.hysteresis_identification.weights import NormalEquations
from bristle.logs.curves import Curves

__all__ = ["StopsFit", "fit_stops", "thresholds_over"]

COUNT = 30
DECADES = 2.0  # from the smallest threshold to the largest
LAGGING = ("piezo",)  # kinds whose output may lag behind the input: plays are tried beside stops
NEGLIGIBLE = 1e-5  # of the largest force of a stop: a weight that rounding left


class StopsFit(NamedTuple):
    """A Prandtl-Ishlinskii operator from data, and the constant output beside it."""

    operator: Model
    offset: float
    rms: float


def thresholds_over(largest: float, count: int = COUNT, smallest: float | None = None) -> np.ndarray:
    """Return thresholds spaced evenly in their logarithm, shape (count,) [m or rad].

    Raises
    ------
    InputError
        If there is no range, or the count is below 2.
    """
    if count != int(count) or count < 2:
        raise InputError("must be a whole number", path="count", value=count, allowed=">= 2")
    low = largest * 10.0**-DECADES if smallest is None else smallest
    if not 0.0 < low < largest < np.inf:
        raise InputError(
            "there is no range for the thresholds",
            path="thresholds",
            value=f"{low} to {largest}",
            mend="The input must move, and by more than its smallest step",
        )
    return np.geomspace(low, largest, int(count))


def fit_stops(recorded: Curves, *, count: int = COUNT, thresholds: np.ndarray | None = None, rows: Rows = None) -> StopsFit:
    """Fit stops and a spring to recorded hysteresis.

    Parameters
    ----------
    recorded : Curves
        Input and output.
    count : int
        Number of stops; 20 to 40 suit. Those that get no weight are left out of the operator.
    thresholds : ndarray, optional
        Thresholds [m or rad] to use instead of `count` evenly in the logarithm, up to the largest that can slip: half
        the range of the input, or all that a virgin start went through.
    rows : sequence of ndarray, optional
        Which samples of each curve are fitted; all of them where not given.
    """
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    reach = max(_reach(trace) for trace in traces)
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

    columns = stacked(traces, features, rows)
    target = outputs_of(recorded, rows)
    solution = NormalEquations.of(columns, target).solve()
    weights, spring = solution.weights[:-1], float(solution.weights[-1])
    used = weights * r > NEGLIGIBLE * float(np.max(weights * r))
    used[-1] |= not used.any()
    if plays:  # a play is the input less the stop of its threshold
        spring, weights = spring + float(np.sum(weights[used])), -weights
    operator = prandtl_ishlinskii(kind=recorded.kind, thresholds=r[used], weights=weights[used], spring=spring)
    return StopsFit(operator, solution.offset, solution.rms)


def _reach(trace: Trace) -> float:
    """Return the largest threshold that slips along a path: half the way from a turning point, or from the origin."""
    return 0.5 * float(np.max(trace.alpha - trace.beta))
