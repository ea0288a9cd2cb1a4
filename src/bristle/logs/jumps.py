"""Where a position is somewhere else from one sample to the next: counters that wrap, units that change, lost parts.

What leaves and comes back within a few samples is a lost reading (`bristle.logs.spikes`). What stays away may be
meant, so it is told and nothing is refused.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.typography import with_unit
from bristle.logs.log_data import LogData

__all__ = ["doubts_about_jumps"]

FACTOR = 10.0  # over the largest step of the rest; a motion has steps of all sizes between none and its fastest
SHARE = 0.01  # of the steps: what happens more often is how this axis moves


def doubts_about_jumps(log: LogData) -> Iterator[str]:
    """Yield in words where the position jumps, but for gaps in time.

    Parameters
    ----------
    log : Log
        Its position is looked at, segment by segment.
    """
    starts = np.concatenate([np.arange(segment.start, segment.stop - 1) for segment in log.segments])
    steps = np.abs(log.position.values[starts + 1] - log.position.values[starts])
    count = _jumps_in(steps)
    if not count:
        return
    first = starts[np.min(np.argpartition(steps, -count)[-count:])]
    jump, usual = float(np.max(steps)), float(np.partition(steps, -count - 1)[-count - 1])
    repeats = f", and {count - 1} times more" if count > 1 else ""
    yield (
        f"the position jumps by {with_unit(jump, log.position.unit)} within a sample, first after "
        f"t = {log.time.values[first]:.6g} s{repeats}; elsewhere its largest step is "
        f"{with_unit(usual, log.position.unit)}: did a counter wrap, a unit change, or a part get lost?"
    )


def _jumps_in(steps: np.ndarray) -> int:
    """Return how many steps are larger than all others by far; 0 where sizes go over into each other."""
    most = min(max(int(SHARE * steps.size), 1), steps.size - 1)
    if most < 1:
        return 0
    largest = np.sort(np.partition(steps, -most - 1)[-most - 1 :])[::-1]
    apart = np.flatnonzero((largest[:-1] > FACTOR * largest[1:]) & (largest[1:] > 0.0))
    return int(apart[-1]) + 1 if apart.size else 0
