"""Whether the effort of a log has the right sign: over a closed motion it puts energy in, and friction takes it."""

from __future__ import annotations

import numpy as np

from bristle.logs.channel import LogData

__all__ = ["work_share"]

POINTS = 200  # of a segment, of which pairs are compared
CLOSED = 0.02  # of range and largest kinetic energy: what two ends of a closed motion may differ by
SHORTEST = 0.25  # of a segment: a closed motion that says something of it
STRIDE = 10  # samples over which the velocity at an end is taken


def work_share(log: LogData) -> float:
    """Return the work that the effort does over closed motion, over what it would be if all of it were friction.

    The integral of effort over way from one sample to a later one at the same place and speed: inertia, gravity and
    springs give back what they took, whatever they are. No model is fitted, and where friction has not saturated the
    loop of effort over position has an area too.
    """
    if log.effort is None:
        return 0.0
    work, total = 0.0, 0.0
    for segment in log.segments:
        ends = _closed(log.position.values[segment])
        if ends is None:
            continue
        x = log.position.values[segment][ends[0] : ends[1] + 1]
        u = log.effort.values[segment][ends[0] : ends[1] + 1]
        steps, middle = np.diff(x), 0.5 * (u[:-1] + u[1:])
        # What is left of the way is not for a constant force to answer.
        middle = middle - np.mean(u)
        work += float(middle @ steps)
        total += float(np.abs(middle) @ np.abs(steps))
    return work / total if total > 0.0 else 0.0


def _closed(position: np.ndarray) -> tuple[int, int] | None:
    """Return the first and the last sample of the longest closed motion of a segment; None where there is none."""
    if position.size < 4 * STRIDE:
        return None
    at = np.unique(np.linspace(STRIDE, position.size - 1 - STRIDE, POINTS).astype(int))
    x = position[at]
    speed = position[at + STRIDE] - position[at - STRIDE]
    fastest = float(np.max(np.abs(position[2 * STRIDE :] - position[: -2 * STRIDE])))
    reach = float(np.ptp(position))
    if reach == 0.0 or fastest == 0.0:
        return None
    energy = (speed / fastest) ** 2
    apart = np.abs(x[:, None] - x[None, :]) / reach + np.abs(energy[:, None] - energy[None, :])
    way = at[None, :] - at[:, None]
    length = np.where(apart < CLOSED, way, 0)
    first, last = np.unravel_index(int(np.argmax(length)), length.shape)
    if length[first, last] < SHORTEST * position.size:
        return None
    # The motion turned in between, or it would not be back.
    return int(at[first]), int(at[last])
