r"""By how much the effort of a log lags its position: found where simple friction explains the effort best.

The effort, filtered, is moved against the motion by fractions of a sample, and each time

.. math:: u(t + \tau) = M \ddot q + c \dot q + k q + F_{v\pm} \dot q + F_{C\pm} \operatorname{sgn} \dot q

is solved. An effort that a controller holds leads by half a sample; a drive that filters its current lags. Friction
before sliding turns after the motion and would be taken for a delay: slow rows do not count, and where that is not
enough the search is refused.
"""

from __future__ import annotations

from dataclasses import replace

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
    """Return by how much the effort lags the position [s], and the standard error of that."""
    from scipy.optimize import minimize_scalar

    speeds = np.abs(dataset.velocity)
    fast = speeds >= SLOW * np.max(speeds)
    basis = np.linalg.qr(_columns(dataset)[fast])[0]
    dt = dataset.sample_time

    def left(samples: float) -> float:
        effort = shifted(dataset, float(samples) * dt).effort[fast]
        return float(np.sum((effort - basis @ (basis.T @ effort)) ** 2))

    trials = np.linspace(-FARTHEST, FARTHEST, SCAN)
    best, step = float(min(trials, key=left)), 2.0 * FARTHEST / (SCAN - 1)
    ends = max(best - step, -FARTHEST), min(best + step, FARTHEST)
    lag = float(minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 1e-3}).x)  # pyright: ignore
    if abs(lag) > FARTHEST - EDGE:
        raise InputError(
            f"cannot be found in this log: it would exceed {FARTHEST:.0f} samples, as where friction before sliding "
            "turns after the motion", path="timing.delay", value="identify",
            mend="Write the delay into the axis file, or record slides to and fro at several speeds as well",
        )  # fmt: skip
    least, bend = left(lag), 0.1
    curvature = (left(lag + bend) - 2.0 * least + left(lag - bend)) / bend**2
    variance = 2.0 * least / max(basis.shape[0] - basis.shape[1] - 1, 1) / max(curvature, np.finfo(float).tiny)
    return lag * dt, variance**0.5 * dt


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
    velocities = [segment.velocity for segment in dataset.segments]
    speeds = (LEVELS * max(float(np.max(np.abs(v))) for v in velocities)).tolist()

    def along(side: float, v: np.ndarray) -> list[np.ndarray]:
        """Return the columns of one direction along a segment; friction that bends would else count as a delay."""
        sliding = np.where(np.signbit(v), -1.0, 1.0) == side
        return [np.where(sliding, shape, 0.0) for shape in (v, side, *(np.exp(-np.abs(v) / speed) for speed in speeds))]

    columns = [dataset.acceleration, dataset.position - float(np.mean(dataset.position))]
    for side in (1.0, -1.0):
        shapes = zip(*(along(side, v) for v in velocities), strict=True)
        columns += [dataset.rows_of([dataset.filtered(part) for part in parts]) for parts in shapes]
    # A log in one direction has nothing on the other side.
    return np.stack([column for column in columns if np.any(column)], axis=1)
