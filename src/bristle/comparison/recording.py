"""A log made ready to be held against another one: on a grid of time that both share, with what friction is told by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.identification.preprocessing import CUTOFF_SHARE, treat
from bristle.logs.log import Log

__all__ = ["Recording", "common_sample_time", "recordings_of"]

ALIKE = 1e-3  # relative difference of sample times that is none


@dataclass(frozen=True)
class Recording:
    """A stretch of a log without a gap; arrays of shape (sample,), in SI of the axis."""

    sample_time: float
    motion: np.ndarray
    error: np.ndarray | None
    effort: np.ndarray | None
    sliding: np.ndarray | None
    turns: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=int))


def common_sample_time(logs: Sequence[Log]) -> float:
    """Return the longest sample time [s]: of a log that has more samples, the largest of them would be larger."""
    return max(log.sample_time for log in logs)


def recordings_of(
    log: Log, axis: Axis | None, sample_time: float, *, follows: bool, tells_effort: bool
) -> tuple[tuple[Recording, ...], InputError | None]:
    """Return the stretches of a log with a sample about every `sample_time` [s], and why it tells no friction."""
    sliding, reason = _sliding(log, axis, sample_time) if tells_effort else (None, None)
    motion = log.reference if follows else log.position
    assert motion is not None
    error = motion.values - log.position.values if follows else None
    effort = log.effort.values if tells_effort and log.effort is not None else None
    collected = []
    for part in log.segments:
        picked = _picked(part, log.sample_time, sample_time)
        signals = (None if signal is None else signal[..., picked] for signal in (error, effort, sliding))
        collected.append(Recording(sample_time, motion.values[picked], *signals))  # type: ignore[arg-type]
    return tuple(collected), reason


def _picked(part: slice, own: float, common: float) -> np.ndarray:
    """Return which samples of a segment to take."""
    count = part.stop - part.start
    if common <= own * (1.0 + ALIKE):
        return np.arange(part.start, part.stop)
    return part.start + np.round(np.arange(0.0, (count - 1) * own / common + 1e-9) * common / own).astype(int)


def _sliding(log: Log, axis: Axis | None, sample_time: float) -> tuple[np.ndarray | None, InputError | None]:
    """Return velocity, acceleration and effort as identification treats them; both logs by one filter."""
    cutoff = axis.cutoff if axis is not None and axis.cutoff is not None else CUTOFF_SHARE / sample_time
    try:
        dataset = treat(log, axis, cutoff)
    except InputError as error:  # too short for the filter, or nothing that moves
        return None, error
    collected = np.full((3, len(log)), np.nan)
    for segment in dataset.segments:
        first = int(np.searchsorted(log.time.values, segment.time[0])) + dataset.dropped
        inner = slice(dataset.dropped, segment.time.size - dataset.dropped)
        signals = np.stack([segment.velocity[inner], segment.acceleration[inner], segment.effort[inner]])
        collected[:, first : first + signals.shape[1]] = signals
    return collected, None
