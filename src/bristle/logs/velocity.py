"""Whether a recorded velocity is the one that the recorded position has, and whether the axis may move so fast."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.logs.log_data import LogData

__all__ = ["doubts_about_velocity"]

STRIDE = 20  # samples over which the position is differentiated, against quantisation
LIKENESS = 0.8  # correlation below which a velocity is that of another motion
SCALE = 0.05  # relative deviation from the unit that is none
BEYOND = 0.02  # of the limit: what noise may add to a velocity


def doubts_about_velocity(log: LogData, axis: Axis) -> Iterator[str]:
    """Yield in words where the recorded velocity contradicts the position, and where the axis exceeds its limit.

    Parameters
    ----------
    log : Log
        Its position, differentiated, is what a recorded velocity is compared with.
    axis : Axis
        Its largest velocity, where known.
    """
    moved, recorded = _velocities(log)
    if not moved.size or not np.any(moved):
        return
    unit = unit_of("length/time", log.kind)
    if log.velocity is not None:
        yield from _contradictions(log.velocity.column, moved, recorded)
    fastest = float(np.max(np.abs(moved)))
    if axis.velocity_limit is not None and fastest > (1.0 + BEYOND) * axis.velocity_limit:
        yield (
            f"the axis moves at up to {with_unit(fastest, unit)}, faster than its limit of "
            f"{with_unit(axis.velocity_limit, unit)} in the axis file: is the unit of the position right?"
        )


def _contradictions(column: str, moved: np.ndarray, recorded: np.ndarray) -> Iterator[str]:
    size = float(np.linalg.norm(moved) * np.linalg.norm(recorded))
    likeness = float(moved @ recorded) / size if size > 0.0 else 0.0
    scale = float(moved @ recorded) / float(moved @ moved)
    if abs(likeness) < LIKENESS:
        yield f"column {column} is not the velocity of the position (correlation {likeness:.2g}): is it another signal?"
    elif likeness < 0.0:
        yield f"the velocity in column {column} has the sign opposite to the motion: one of both signs is wrong"
    if abs(likeness) >= LIKENESS and abs(abs(scale) - 1.0) > SCALE:
        yield (
            f"the velocity in column {column} is {abs(scale):.3g} times that of the position: the unit of one of both "
            "is wrong"
        )


def _velocities(log: LogData) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean velocity over each stride, by the position and as recorded [m/s or rad/s]."""
    moved, recorded = [np.empty(0)], [np.empty(0)]
    for segment in log.segments:
        x = log.position.values[segment]
        count = (x.size - 1) // STRIDE
        if count < 1:
            continue
        moved.append(np.diff(x[: count * STRIDE + 1 : STRIDE]) / (STRIDE * log.sample_time))
        if log.velocity is not None:
            v = log.velocity.values[segment][: count * STRIDE + 1]
            recorded.append((0.5 * (v[:-1] + v[1:])).reshape(count, STRIDE).mean(axis=1))
    return np.concatenate(moved), np.concatenate(recorded)
