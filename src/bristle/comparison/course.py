"""Means over cycles and around reversals, as they are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bristle.comparison.cycles import Cycle
from bristle.comparison.measures import turns_in
from bristle.comparison.result import Course, Turn
from bristle.comparison.sides import Side

__all__ = ["course_of", "turn_courses"]

BEFORE, BEHIND = 1.0, 3.0  # windows around a reversal that are shown


def course_of(before: Side, after: Side, *, follows: bool) -> Course:
    """Return the mean of each motion, one behind the other: following error, or effort where there is no reference."""
    sample_time = before.recordings[0].sample_time
    signal = "error" if follows else "effort"
    kinds = list(dict.fromkeys(cycle.kind for cycle in before.cycles))
    parts = []
    for kind in kinds:
        cycles = [[cycle_ for cycle_ in side.cycles if cycle_.kind == kind] for side in (before, after)]
        count = min(cycle_.count for own in cycles for cycle_ in own)
        parts.append(
            [
                _mean_of(before, cycles[0], "motion", count),
                _mean_of(before, cycles[0], signal, count),
                _mean_of(after, cycles[1], signal, count),
            ]
        )
    motion, low, high = (np.concatenate(cycle_) for cycle_ in zip(*parts, strict=True))
    return Course(sample_time * np.arange(motion.size), motion, low, high)


def _mean_of(side: Side, cycles: Sequence[Cycle], signal: str, count: int) -> np.ndarray:
    rows = (getattr(side.recordings[cycle_.recording], signal)[cycle_.samples][:count] for cycle_ in cycles)
    return np.mean(list(rows), axis=0)


def turn_courses(before: Side, after: Side, window: int) -> tuple[Turn, ...]:
    """Return the mean following error around the reversals of each direction that both sides have."""
    collected = []
    steps = np.arange(-round(BEFORE * window), round(BEHIND * window) + 1)
    for name, forward in (("forward_to_backward", False), ("backward_to_forward", True)):
        curves = [_around(side, steps, window, forward=forward) for side in (before, after)]
        if all(curve is not None for curve in curves):
            collected.append(Turn(name, before.recordings[0].sample_time * steps, *curves))  # type: ignore[arg-type]
    return tuple(collected)


def _around(side: Side, steps: np.ndarray, window: int, *, forward: bool) -> np.ndarray | None:
    rows = []
    for cycle in side.cycles:
        recording = side.recordings[cycle.recording]
        error = recording.error
        assert error is not None
        rows += [
            error[place + steps]
            for place in turns_in(recording, cycle, window, forward=forward)
            if place + steps[0] >= 0 and place + steps[-1] < error.size
        ]
    return np.mean(rows, axis=0) if rows else None
