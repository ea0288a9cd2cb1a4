"""Samples that no motion explains: a reading that leaves for a few samples and comes back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["LARGEST", "SMALLEST", "Spike", "far_outside", "spikes"]

LONGEST = 5  # samples
AROUND = 10  # samples on each side that tell what the motion allows
STEP_FACTOR = 3.0  # over the largest step nearby
BEND_FACTOR = 10.0  # over the largest change of step nearby
USUAL_BEND_FACTOR = 20.0  # over the change of step that one sample in twenty exceeds
QUANTA = 10.0  # resolution steps
# No axis is larger or finer in any unit, and what is in between can be multiplied a few times over: native solvers
# of least squares write beyond their memory, or never return, on what overflows in them.
LARGEST, SMALLEST = 1e30, 1e-30
FAR = 1e6  # over the range that holds 98 % of the samples


class Spike(NamedTuple):
    """A run of samples that leaves and returns: its first sample, its length, and by how much it is off."""

    start: int
    length: int
    size: float


def spikes(values: np.ndarray, resolution: float) -> list[Spike]:
    """Return the places where a position leaves for a few samples and comes back, in order.

    Both steps, there and back, must be far larger than the steps and the changes of step around them: stick-slip, a
    hard stop, noise and flickering counts have neighbours of their own kind, a lost reading has not.
    """
    steps = np.diff(values)
    bends = np.abs(np.diff(steps))
    if bends.size < 2 * AROUND:
        return []
    least = max(USUAL_BEND_FACTOR * float(np.quantile(bends, 0.95)), QUANTA * resolution)
    chosen: list[Spike] = []
    covered = np.zeros(values.size, dtype=bool)
    for length in range(1, LONGEST + 1):
        ahead, back = steps[:-length], steps[length:]
        suspect = (ahead * back < 0.0) & (np.minimum(np.abs(ahead), np.abs(back)) > least)
        for start in (np.flatnonzero(suspect) + 1).tolist():
            if not covered[start - 1 : start + length + 1].any() and _stands_out(values, start, length):
                covered[start : start + length] = True
                chosen.append(Spike(start, length, float(_deviation(values, start, length)[0])))
    return sorted(chosen)


def _deviation(values: np.ndarray, start: int, length: int) -> np.ndarray:
    """Return by how much the samples of a run are off the straight line between their neighbours."""
    line = np.linspace(values[start - 1], values[start + length], length + 2)
    return values[start : start + length] - line[1:-1]


def _stands_out(values: np.ndarray, start: int, length: int) -> bool:
    before = np.diff(values[max(start - AROUND, 0) : start])
    after = np.diff(values[start + length : start + length + AROUND])
    step = max(np.abs(before).max(initial=0.0), np.abs(after).max(initial=0.0))
    bend = max(np.abs(np.diff(before)).max(initial=0.0), np.abs(np.diff(after)).max(initial=0.0))
    off = _deviation(values, start, length)
    edges = np.abs([values[start] - values[start - 1], values[start + length] - values[start + length - 1]])
    return bool(
        before.size + after.size >= AROUND
        and (np.all(off > 0.0) or np.all(off < 0.0))
        and np.abs(off).min() > BEND_FACTOR * bend
        and edges.min() > STEP_FACTOR * step
    )


def far_outside(values: np.ndarray) -> np.ndarray:
    """Return the samples that are no measurement: larger than `LARGEST`, or far off for a few samples."""
    huge = np.flatnonzero(np.abs(values) > LARGEST)
    if huge.size:
        return huge
    low, middle, high = np.quantile(values, (0.01, 0.5, 0.99))
    if high == low:
        return huge
    far = np.flatnonzero(np.abs(values - middle) > FAR * (high - low))
    # A channel that rests for most of the log and then moves is legitimate; it moves for more than a few samples.
    runs = np.split(far, np.flatnonzero(np.diff(far) > 1) + 1)
    return far if all(run.size <= LONGEST for run in runs) else huge
