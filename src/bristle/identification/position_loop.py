r"""The stiffness `K` of the position loop of an axis, from its control law or from a log.

.. math:: u = c + K e + d\,v + d_r\,v_r + k \int e\,\mathrm{d}t

The integral of a controller takes time: at first a force `F` displaces an axis by :math:`F/K`. With a control law, `K` is the
slope of its effort over the position error, with the integral frozen. Without one, `K` is the coefficient of the error in a
least-squares fit of the effort of a log to the terms above. Its interval comes from fits that leave out one part of the log.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core import least_squares
from bristle.core.contracts import Model, Reference
from bristle.logs.log import Log

SMALL = 1e-9  # position error of a step [m or rad]
# Samples after which filters have settled, in all, and their time [s]
SETTLED, STEPS, STEP = (500, 1000, 1e-3)
PARTS = 10  # of a log, for the interval
ROUGHEST = 0.5  # largest half-width of the interval over the stiffness
T_95 = 2.26  # quantile of the t distribution for the parts


class Stiffness(NamedTuple):
    """The stiffness of a position loop [N/m or N*m/rad] and the half-width of its 95 % interval."""

    value: float
    half_width: float = 0.0


def stiffness_of(controller: Model) -> Stiffness | None:
    """Return the slope of the effort of a control law over the position error; None for a law without such a slope.

    The effort after a step of the error becomes a straight line in time, which begins at the effort without the integral.
    """
    follows = (
        controller.with_values(k_ff=0.0) if "k_ff" in controller.component.variables else controller
    )
    efforts = _efforts_at(follows, SMALL) - _efforts_at(follows, 0.0)
    _, at_once = np.polyfit(np.arange(SETTLED + 1, STEPS + 1), efforts[SETTLED:], 1)
    slope = float(at_once) / SMALL
    return Stiffness(slope) if np.isfinite(slope) and slope > 0.0 else None


def _efforts_at(controller: Model, error: float) -> np.ndarray:
    """Return the effort of a control law at each sample with a constant position error [N or N*m]."""
    component, p = controller.component, controller.parameters
    state, efforts = component.start(-error, 0.0, 0.0, STEP, p), np.empty(STEPS)
    for k in range(STEPS):
        efforts[k], state = component.step(state, Reference(0.0, 0.0, 0.0, 0.0), -error, STEP, p)
    return efforts


def stiffness_in(log: Log) -> Stiffness | None:
    """Return the stiffness of the loop that made a log; None without a reference, or where the log does not determine it."""
    if log.reference is None or log.effort is None:
        return None
    rows, effort = _rows_of(log, log.reference.values, log.effort.values)
    if effort.size < 50 * PARTS:
        return None
    parts = np.arange(effort.size) * PARTS // effort.size
    # The triangular factor of a part stands for its rows in every fit.
    factors = [
        np.asarray(np.linalg.qr(np.column_stack([rows, effort])[parts == part], mode="r"))
        for part in range(PARTS)
    ]
    slope = _coefficient(factors)
    left_out = [_coefficient(factors[:part] + factors[part + 1 :]) for part in range(PARTS)]
    half_width = float(T_95 * (np.std(left_out) * np.sqrt(PARTS - 1.0)))
    if not (slope > 0.0 and half_width <= ROUGHEST * slope):
        return None
    return Stiffness(slope, half_width)


def _rows_of(log: Log, reference: np.ndarray, effort: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the terms and the effort of each sample but the first of a segment."""
    position, dt = log.position.values, log.sample_time
    rows, efforts = [], []
    for segment in log.segments or (slice(0, len(log)),):
        error = reference[segment] - position[segment]
        velocity = np.diff(position[segment], prepend=position[segment][:1]) / dt
        desired = np.diff(reference[segment], prepend=reference[segment][:1]) / dt
        terms = (np.ones(error.size), error, velocity, desired, dt * np.cumsum(error))
        rows.append(np.column_stack(terms)[1:])
        efforts.append(effort[segment][1:])
    return np.concatenate(rows), np.concatenate(efforts)


def _coefficient(factors: Sequence[np.ndarray]) -> float:
    """Return the coefficient of the position error in a least-squares fit to rows with these triangular factors."""
    rows, effort = np.split(np.concatenate(factors), [-1], axis=1)
    scale = np.maximum(np.max(np.abs(rows), axis=0), np.finfo(float).tiny)
    return float(least_squares.unbounded(rows / scale, effort[:, 0])[1] / scale[1])
