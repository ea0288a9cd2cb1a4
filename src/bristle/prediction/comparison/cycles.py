"""The two sides of a comparison: stretches of their logs on one grid of time, cut into cycles numbered by motion.

A motion is cut where it turns forward. Two cycles have the same motion if they have the same duration and pass the same
positions. If a motion hardly turns, pieces of equal length replace cycles, identified by their time in the log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bristle.core import Axis, InputError
from bristle.identification.preprocessing import CUTOFF_SHARE, treat
from bristle.logs.log import Log
from bristle.logs.turns import graininess, turning_points

SAME_PERIOD = 1e-3  # smaller relative differences of sample times are ignored
PHASES = 33  # at which the positions of two cycles are compared
PIECES = 20  # of the shorter of two motions that never turn
FEWEST = 8  # samples of a cycle
# For references, and for positions, which the loop makes:
# Of the range of a cycle, and of its duration: smaller differences are ignored.
ALIKE = (0.02, 0.06)
TREMBLE = (1e-3, 1e-2)  # of the range of the motion: smaller turns are ignored

LogAndAxis = tuple[Log, Axis | None]


@dataclass(frozen=True, eq=False)
class Recording:
    """A stretch of a log without a gap; arrays of shape (sample,), in SI units of the axis."""

    sample_time: float
    motion: np.ndarray
    error: np.ndarray | None
    effort: np.ndarray | None
    sliding: np.ndarray | None
    turns: np.ndarray
    log: int = 0  # place of its log, in the order of time


@dataclass(frozen=True)
class Cycle:
    """A stretch of a recording that is a whole motion."""

    recording: Recording
    samples: slice
    kind: int = -1

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.samples.stop - self.samples.start

    def part(self, signal: str) -> np.ndarray:
        """Return a signal of the recording over the cycle."""
        return getattr(self.recording, signal)[self.samples]


@dataclass(frozen=True)
class Side:
    """The cycles of one side, and the reason if its friction is unknown."""

    cycles: Sequence[Cycle]
    reason: InputError | None = None

    @property
    def kinds(self) -> list[int]:
        """The motion of each cycle."""
        return [cycle.kind for cycle in self.cycles]

    @property
    def logs(self) -> np.ndarray:
        """The log of each cycle, by its place in the order of time."""
        return np.array([cycle.recording.log for cycle in self.cycles], dtype=int)


def sides_of(
    before: Sequence[LogAndAxis], after: Sequence[LogAndAxis], *, follows: bool, tells_effort: bool
) -> tuple[Side, Side, bool]:
    """Return both sides, and whether their cycles are complete."""
    # The peak of a log with more samples would be larger.
    sample_time = max(log.sample_time for log, _ in (*before, *after))
    recordings: tuple[list[Recording], list[Recording]] = ([], [])
    reasons: list[InputError | None] = [None, None]
    places = iter(
        np.argsort(
            np.argsort([log.time.values[0] for log, _ in (*before, *after)], kind="stable")
        ).tolist()
    )
    for number, logs_given in enumerate((before, after)):
        for log, axis in logs_given:
            parts, reason = _recordings_of(
                log, axis, sample_time, follows=follows, tells_effort=tells_effort
            )
            place = next(places)
            recordings[number].extend(replace(part, log=place) for part in parts)
            reasons[number] = reasons[number] or reason
    parts = [part for side in recordings for part in side]
    grains = {id(part): graininess(part.motion, None) for part in parts}
    tremble = TREMBLE[not follows] * max(
        (float(np.ptp(part.motion)) for part in parts), default=0.0
    )
    turned = [
        [
            replace(
                part,
                turns=np.array(
                    turning_points(part.motion, max(grains[id(part)], tremble)), dtype=int
                ),
            )
            for part in side
        ]
        for side in recordings
    ]
    cycles = [_complete(side) for side in turned]
    complete = min(len(side) for side in cycles) >= 2
    if not complete:
        longest = [max(part.stop - part.start for part in map(_moving, side)) for side in turned]
        cycles = [_pieces(side, max(min(longest) // PIECES, FEWEST)) for side in turned]
    low, high = _numbered(cycles, max(grains.values()), ALIKE[not follows], complete=complete)
    return Side(low, reasons[0]), Side(high, reasons[1]), complete


def _recordings_of(
    log: Log, axis: Axis | None, sample_time: float, *, follows: bool, tells_effort: bool
) -> tuple[list[Recording], InputError | None]:
    """Return the stretches of a log with a sample about every `sample_time` [s], and the reason if its friction is unknown."""
    motion = log.position
    error = None
    effort = None
    sliding = None
    reason = None
    if follows:
        assert log.reference is not None
        motion = log.reference
        error = motion.values - log.position.values
    if tells_effort:
        sliding, reason = _sliding(log, axis, sample_time)
        if log.effort is not None:
            effort = log.effort.values
    collected = []
    for part in log.segments:
        picked = np.arange(part.start, part.stop)
        if sample_time > log.sample_time * (1.0 + SAME_PERIOD):
            times = np.arange(0.0, (picked.size - 1) * log.sample_time / sample_time + 1e-9)
            picked = part.start + np.round(times * sample_time / log.sample_time).astype(int)
        signals = (
            None if signal is None else signal[..., picked] for signal in (error, effort, sliding)
        )
        collected.append(
            Recording(sample_time, motion.values[picked], *signals, np.empty(0, dtype=int))  # type: ignore[arg-type]
        )
    return collected, reason


def _sliding(
    log: Log, axis: Axis | None, sample_time: float
) -> tuple[np.ndarray | None, InputError | None]:
    """Return velocity, acceleration and effort, treated as in identification; both logs with the same filter."""
    cutoff = CUTOFF_SHARE / sample_time
    if axis is not None and axis.cutoff is not None:
        cutoff = axis.cutoff
    try:
        dataset = treat(log, axis, cutoff)
    except InputError as error:  # too short for the filter, or without motion
        return None, error
    collected = np.full((3, len(log)), np.nan)
    for segment in dataset.segments:
        first = int(np.searchsorted(log.time.values, segment.time[0])) + dataset.dropped
        inner = slice(dataset.dropped, segment.time.size - dataset.dropped)
        signals = np.stack(
            [segment.velocity[inner], segment.acceleration[inner], segment.effort[inner]]
        )
        collected[:, first : first + signals.shape[1]] = signals
    return collected, None


def _complete(recordings: Sequence[Recording]) -> list[Cycle]:
    collected = []
    for recording in recordings:
        motion = recording.motion
        moving = _moving(recording)
        near = TREMBLE[1] * float(np.ptp(motion))
        low = float(np.min(motion)) + near
        high = float(np.max(motion)) - near
        # A motion may begin and end at a turn, at its extreme position. Such a turn is forward if the next turn is
        # further up; the last turn is forward if the previous turn is.
        ends = [
            place
            for place in (moving.start, moving.stop - 1)
            if moving.stop and not low < motion[place] < high
        ]
        places = np.unique([*recording.turns, *ends]).astype(int)
        heights = recording.motion[places]
        forward = places[np.append(heights[1:] > heights[:-1], heights[-2:-1] > heights[-1:])]
        collected += [
            Cycle(recording, slice(int(a), int(b))) for a, b in pairwise(forward) if b - a >= FEWEST
        ]
    return collected


def _moving(recording: Recording) -> slice:
    """Return the samples from the first to the last motion."""
    moved = np.flatnonzero(np.diff(recording.motion))
    if moved.size:
        return slice(int(moved[0]), int(moved[-1]) + 2)
    return slice(0, 0)


def _pieces(recordings: Sequence[Recording], length: int) -> list[Cycle]:
    parts = ((recording, _moving(recording)) for recording in recordings)
    return [
        Cycle(recording, slice(first, first + length))
        for recording, part in parts
        for first in range(part.start, part.stop - length + 1, length)
    ]


def _numbered(
    sides: Sequence[Sequence[Cycle]], grain: float, share: float, *, complete: bool
) -> list[list[Cycle]]:
    """Return the cycles of two sides with the number of their motion, counted through both."""
    shapes: list[np.ndarray] = []
    counts: list[int] = []
    numbered: list[list[Cycle]] = []
    for cycles in sides:
        numbered.append([])
        for cycle in cycles:
            recording = cycle.recording
            origin = 0.0
            if not complete:
                origin = float(recording.motion[_moving(recording).start])
            motion = recording.motion[cycle.samples] - origin
            shape = np.interp(
                np.linspace(0.0, motion.size - 1.0, PHASES), np.arange(motion.size), motion
            )
            least = share * float(np.ptp(shape)) + float(np.max(np.abs(np.diff(motion)))) + grain
            kind = _first_alike(shape, cycle.count, shapes, counts, least, share)
            if kind == len(shapes):
                shapes.append(shape)
                counts.append(cycle.count)
            numbered[-1].append(replace(cycle, kind=kind))
    return numbered


def _first_alike(
    shape: np.ndarray,
    count: int,
    shapes: Sequence[np.ndarray],
    counts: Sequence[int],
    least: float,
    share: float,
) -> int:
    """Return the number of the first equal motion, or the next number if there is no equal motion."""
    if not shapes:
        return 0
    away = np.max(np.abs(np.asarray(shapes) - shape), axis=1)
    lasting = np.abs(np.asarray(counts) - count) <= share * count + 2.0
    fits = np.flatnonzero((away <= least) & lasting)
    if fits.size:
        return int(fits[0])
    return len(shapes)
