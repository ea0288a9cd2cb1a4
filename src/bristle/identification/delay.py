r"""By how much the effort of a log lags its position: found where simple friction explains the effort best.

The effort, filtered, is moved against the motion by fractions of a sample, and each time

.. math:: u(t + \tau) = M \ddot q + c \dot q + k q + F_{v\pm} \dot q + F_{C\pm} \operatorname{sgn} \dot q

is solved. An effort that a controller holds leads by half a sample; a drive that filters its current lags. Friction
before sliding turns after the motion and would be taken for a delay: slow rows do not count, and where that is not
enough the search is refused.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.identification.dataset import Dataset

__all__ = ["delay_in", "shifted"]

FARTHEST = 5.0  # samples, to either side
SCAN = 21  # delays that are tried first
EDGE = 0.02  # samples
SLOW = 0.02  # of the largest speed: what is slower may not have broken away, and friction then turns after the motion
LEVELS = np.geomspace(0.02, 0.3, 4)  # of the largest speed: where friction may bend


def delay_in(dataset: Dataset) -> tuple[float, float]:
    """Return by how much the effort lags the position [s], and the standard error of that.

    Parameters
    ----------
    dataset : Dataset
        The rows of a log, not yet shifted.

    Raises
    ------
    InputError
        If the best delay is none of a drive.
    """
    from scipy.optimize import minimize_scalar

    speeds = np.abs(dataset.velocity)
    fast = speeds >= SLOW * np.max(speeds)
    basis = np.linalg.qr(_columns(dataset)[fast])[0]
    dt = dataset.sample_time

    def left(samples: float) -> float:
        effort = shifted(dataset, float(samples) * dt).effort[fast]
        return float(np.sum((effort - basis @ (basis.T @ effort)) ** 2))

    tried = np.linspace(-FARTHEST, FARTHEST, SCAN)
    best = float(tried[int(np.argmin([left(shift) for shift in tried.tolist()]))])
    step = 2.0 * FARTHEST / (SCAN - 1)
    ends = max(best - step, -FARTHEST), min(best + step, FARTHEST)
    least_at: Any = minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 1e-3})
    least_shift = float(least_at.x)
    if abs(least_shift) > FARTHEST - EDGE:
        raise InputError(
            f"cannot be found in this log: it would exceed {FARTHEST:.0f} samples, as where friction before sliding "
            "turns after the motion", path="timing.delay", value="identify",
            mend="Write the delay into the axis file, or record slides to and fro at several speeds as well",
        )  # fmt: skip
    least, bend = left(least_shift), 0.1
    curvature = (left(least_shift + bend) - 2.0 * least + left(least_shift - bend)) / bend**2
    variance = 2.0 * least / max(basis.shape[0] - basis.shape[1] - 1, 1) / max(curvature, np.finfo(float).tiny)
    return least_shift * dt, variance**0.5 * dt


def shifted(dataset: Dataset, delay: float) -> Dataset:
    """Return the rows of a log whose effort lags by `delay` [s], moved back in time by as much."""
    from scipy.interpolate import CubicSpline

    moved = []
    for segment in dataset.segments:
        at = np.clip(segment.time + delay, segment.time[0], segment.time[-1])
        moved.append(replace(segment, effort=np.asarray(CubicSpline(segment.time, segment.effort)(at))))
    return replace(dataset, segments=tuple(moved), delay=delay)


def _columns(dataset: Dataset) -> np.ndarray:
    """Return what a simple friction model is linear in, filtered as the effort is, shape (row, column)."""

    def rows(signals: list[np.ndarray]) -> np.ndarray:
        return dataset.rows_of([dataset.filtered(signal) for signal in signals])

    velocities = [segment.velocity for segment in dataset.segments]
    top = max(float(np.max(np.abs(v))) for v in velocities)
    sides = [np.where(np.signbit(v), -1.0, 1.0) for v in velocities]
    columns = [dataset.acceleration, dataset.position - float(np.mean(dataset.position))]
    for side in (1.0, -1.0):
        on = [(signs == side).astype(float) for signs in sides]
        columns.append(rows([v * mask for v, mask in zip(velocities, on, strict=True)]))
        columns.append(rows([signs * mask for signs, mask in zip(sides, on, strict=True)]))
        for speed in (top * LEVELS).tolist():
            # Friction that bends with speed would else be taken for a delay.
            columns.append(rows([mask * np.exp(-np.abs(v) / speed) for v, mask in zip(velocities, on, strict=True)]))
    # A log in one direction has nothing on the other side.
    return np.stack([column for column in columns if np.any(column)], axis=1)
