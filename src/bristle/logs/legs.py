"""A recorded motion taken apart: rests, and the legs between rests and turning points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.core.normal import DEVIATION_OVER_MEDIAN
from bristle.logs.turns import runs, turning_points

CHUNKS = 20  # of a leg, in which its speed is looked at
CRUISING = 0.08  # relative deviation of the speed that counts as constant; a sine keeps to it for a third
SETTLING = 0.03  # of the leg beside it: a leg that is none
FAST = 0.8  # quantile of the speeds of a leg that a cruise has


@dataclass(frozen=True)
class Leg:
    """A stretch in one direction, from a rest or a turning point to the next."""

    first: int
    last: int
    distance: float
    duration: float
    cruise: slice
    cruise_share: float
    speed: float
    from_rest: bool


def graininess(position: np.ndarray, resolution: float | None) -> float:
    """Return the smallest motion that a recorded position shows [m or rad]."""
    if resolution is None:
        steps = np.abs(np.diff(position))
        resolution = float(np.min(steps[steps > 0.0], initial=np.inf))
        resolution = resolution if np.isfinite(resolution) else 0.0
    bends = np.abs(np.diff(position, 2))
    noise = DEVIATION_OVER_MEDIAN * float(np.median(bends)) / np.sqrt(6.0) if bends.size else 0.0
    return max(2.5 * resolution, 4.0 * noise)  # of the encoder, of its noise: no motion is smaller


def rests_of(position: np.ndarray, grain: float, sample_time: float) -> list[slice]:
    """Return the samples of each rest: where the position stays within a grain to either side."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    window = max(round(0.12 / sample_time), 3)  # [s] without a motion that the encoder sees
    if position.size < window:
        return []
    half = window // 2
    span = maximum_filter1d(position, 2 * half + 1) - minimum_filter1d(position, 2 * half + 1)
    # A rest reaches as far as its windows do.
    counted = np.concatenate([[0], np.cumsum(np.pad((span <= 2.0 * grain)[half:-half], 2 * half))])
    return runs(counted[2 * half + 1 :] > counted[: -2 * half - 1])


def legs_of(position: np.ndarray, rests: list[slice], grain: float, sample_time: float) -> Iterator[Leg]:
    """Yield the legs between rests and turning points, those that hardly move left out."""
    edges = [0, *(edge for rest in rests for edge in (rest.start, rest.stop - 1)), position.size - 1]
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin < 2:
            continue
        marks = [begin, *(begin + k for k in turning_points(position[begin : end + 1], grain)), end]
        marks = _without_jitter(position, marks)
        # Without those right beside a rest that are nothing against the leg next to them.
        lengths = [abs(position[b] - position[a]) for a, b in pairwise(marks)]
        first = len(lengths) > 1 and lengths[0] < SETTLING * lengths[1]
        last = len(lengths) > 1 and lengths[-1] < SETTLING * lengths[-2]
        marks = marks[int(first) : len(marks) - int(last)]
        for number, (first, last) in enumerate(pairwise(marks)):
            if abs(position[last] - position[first]) > grain:
                yield _leg(position, first, last, grain, sample_time, from_rest=number == 0 and begin > 0)


def _without_jitter(position: np.ndarray, marks: list[int]) -> list[int]:
    """Return ends of legs without those of legs that are nothing, in length and in time, beside the one next to them.

    Around a turning point, where the motion is slow, noise turns it more than once.
    """
    remaining = np.array(marks)
    while remaining.size > 3:
        lengths, times = np.abs(np.diff(position[remaining])), np.diff(remaining)
        beside = np.where(lengths[:-2] > lengths[2:], np.arange(lengths.size - 2), np.arange(2, lengths.size))
        inner = slice(1, -1)
        negligible = (lengths[inner] < SETTLING * lengths[beside]) & (times[inner] < SETTLING * times[beside])
        if not negligible.any():
            break
        shortest = 1 + int(np.argmin(np.where(negligible, lengths[inner], np.inf)))
        # Without the two ends of the leg, those before and after it are one.
        remaining = np.delete(remaining, (shortest, shortest + 1))
    return [int(k) for k in remaining]


def _leg(position: np.ndarray, first: int, last: int, grain: float, dt: float, *, from_rest: bool) -> Leg:
    marks = np.unique(np.linspace(first, last, CHUNKS + 1).astype(int))
    times = dt * np.diff(marks)
    distance = float(position[last] - position[first])
    speeds = np.diff(position[marks]) / times * np.sign(distance)
    top = float(np.quantile(speeds, FAST))
    steady = np.abs(speeds - top) <= CRUISING * top + 2.0 * grain / times
    longest = max(runs(steady), key=lambda run: run.stop - run.start, default=slice(0, 0))
    cruise = slice(int(marks[longest.start]), int(marks[longest.stop]))
    duration = dt * (cruise.stop - cruise.start)
    speed = abs(float(position[cruise.stop] - position[cruise.start])) / duration if duration > 0.0 else top
    return Leg(first, last, distance, dt * (last - first), cruise, duration / (dt * (last - first)), speed, from_rest)
