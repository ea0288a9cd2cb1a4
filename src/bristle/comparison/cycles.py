"""Cycles of a motion, to and fro, and which of two logs move alike.

A motion is cut where it turns forward. Two cycles are of one motion if they last as long and pass the same positions;
where a motion hardly turns, pieces of equal length stand for cycles, told by where they lie from where the log begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bristle.comparison.recording import Recording
from bristle.logs.legs import graininess
from bristle.logs.turns import turning_points

__all__ = ["Cycle", "alike", "cut", "with_turns"]

PHASES = 33  # at which the positions of two cycles are compared
ALIKE = 0.02  # of the range of a cycle, and of its duration: a difference of references that is none
ALIKE_MEASURED = 0.06  # the same of positions, which the loop makes
TREMBLE, TREMBLE_MEASURED = 1e-3, 1e-2  # of the range of the motion: a turn by less is none
PIECES = 20  # of the shorter of two motions that never turn
AT_TURN = 0.01  # of the range of a motion: one that begins or ends so close to its end does so at a turn
FEWEST = 8  # samples of a cycle


@dataclass(frozen=True)
class Cycle:
    """A stretch of a recording that is a whole motion."""

    recording: int
    samples: slice
    kind: int = -1

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.samples.stop - self.samples.start


def with_turns(recordings: Sequence[Recording], *, measured: bool) -> list[Recording]:
    """Return recordings that know where their motion turns."""
    widest = max((float(np.ptp(part.motion)) for part in recordings), default=0.0)
    least = (TREMBLE_MEASURED if measured else TREMBLE) * widest
    collected = (turning_points(part.motion, max(graininess(part.motion, None), least)) for part in recordings)
    return [replace(part, turns=np.array(turns, dtype=int)) for part, turns in zip(recordings, collected, strict=True)]


def cut(before: Sequence[Recording], after: Sequence[Recording]) -> tuple[list[Cycle], list[Cycle], bool]:
    """Return the cycles of two sides, and whether they are whole ones, which begin where the motion turns forward."""
    sides = [_complete(recordings) for recordings in (before, after)]
    if min(len(cycles) for cycles in sides) >= 2:
        return sides[0], sides[1], True
    longest = [max((_moving(part.motion) for part in recordings), key=_count) for recordings in (before, after)]
    length = max(min(map(_count, longest)) // PIECES, FEWEST)
    first, second = (_pieces(recordings, length) for recordings in (before, after))
    return first, second, False


def _complete(recordings: Sequence[Recording]) -> list[Cycle]:
    collected = []
    for number, recording in enumerate(recordings):
        # A motion may begin and end at a turn. One is forward where the next one is farther up, the
        # last one where the one before it is.
        places = np.unique([*recording.turns, *_ends_at_turns(recording.motion)]).astype(int)
        heights = recording.motion[places]
        forward = places[np.append(heights[1:] > heights[:-1], heights[-2:-1] > heights[-1:])]
        collected += [Cycle(number, slice(int(a), int(b))) for a, b in pairwise(forward) if b - a >= FEWEST]
    return collected


def _ends_at_turns(motion: np.ndarray) -> list[int]:
    """Return the first and the last sample that move, where they lie as far out as the motion goes."""
    moving, near = _moving(motion), AT_TURN * float(np.ptp(motion))
    low, high = float(np.min(motion)) + near, float(np.max(motion)) - near
    return [place for place in (moving.start, moving.stop - 1) if moving.stop and not low < motion[place] < high]


def _moving(motion: np.ndarray) -> slice:
    """Return the samples from the first to the last that move."""
    moved = np.abs(np.diff(motion)) > 0.0
    if not moved.any():
        return slice(0, 0)
    return slice(int(np.argmax(moved)), int(moved.size - np.argmax(moved[::-1])) + 1)


def _count(part: slice) -> int:
    return part.stop - part.start


def _pieces(recordings: Sequence[Recording], length: int) -> list[Cycle]:
    return [
        Cycle(number, slice(first, first + length))
        for number, part in enumerate(_moving(part.motion) for part in recordings)
        for first in range(part.start, part.stop - length + 1, length)
    ]


def alike(
    before: tuple[Sequence[Recording], Sequence[Cycle]],
    after: tuple[Sequence[Recording], Sequence[Cycle]],
    *,
    complete: bool,
    measured: bool,
) -> tuple[list[Cycle], list[Cycle]]:
    """Return the cycles of two sides with the number of their motion, counted through both."""
    share = ALIKE_MEASURED if measured else ALIKE
    grain = max(graininess(part.motion, None) for part in (*before[0], *after[0]))
    shapes: list[np.ndarray] = []
    counts: list[int] = []
    sides: tuple[list[Cycle], list[Cycle]] = ([], [])
    for (recordings, cycles), numbered in zip((before, after), sides, strict=True):
        for cycle in cycles:
            motion = recordings[cycle.recording].motion
            origin = 0.0 if complete else float(motion[_moving(motion).start])
            shape, step = _shape(motion[cycle.samples] - origin)
            least = share * float(np.ptp(shape)) + step + grain
            kind = _first_alike(shape, cycle.count, shapes, counts, least, share)
            if kind == len(shapes):
                shapes.append(shape)
                counts.append(cycle.count)
            numbered.append(replace(cycle, kind=kind))
    return sides


def _shape(motion: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the positions at even phases of a cycle, and the largest step between samples."""
    phases = np.linspace(0.0, motion.size - 1.0, PHASES)
    return np.interp(phases, np.arange(motion.size), motion), float(np.max(np.abs(np.diff(motion))))


def _first_alike(shape: np.ndarray, count: int, shapes: Sequence[np.ndarray], counts: Sequence[int], least: float, share: float) -> int:
    """Return the number of the first motion that is like this one; the next number where none is."""
    if not shapes:
        return 0
    away = np.max(np.abs(np.asarray(shapes) - shape), axis=1)
    lasting = np.abs(np.asarray(counts) - count) <= share * count + 2.0
    fits = np.flatnonzero((away <= least) & lasting)
    return int(fits[0]) if fits.size else len(shapes)
