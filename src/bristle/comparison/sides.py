"""The two sides of a comparison: stretches of their logs on one grid of time, in cycles with numbers of motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.comparison.cycles import Cycle, alike, cut, with_turns
from bristle.comparison.recording import Recording, common_sample_time, recordings_of
from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.logs.log import Log

__all__ = ["LogAndAxis", "Side", "sides_of"]

LogAndAxis = tuple[Log, Axis | None]


@dataclass(frozen=True)
class Side:
    """One side."""

    recordings: Sequence[Recording]
    cycles: Sequence[Cycle]
    reason: InputError | None = None

    def of(self, numbers: np.ndarray) -> Side:
        """Return the side with some of its cycles."""
        return replace(self, cycles=[self.cycles[number] for number in numbers])

    @property
    def kinds(self) -> list[int]:
        """The motion of each cycle."""
        return [cycle.kind for cycle in self.cycles]


def sides_of(before: Sequence[LogAndAxis], after: Sequence[LogAndAxis], *, follows: bool, tells_effort: bool) -> tuple[Side, Side, bool]:
    """Return both sides, and whether their cycles are whole ones."""
    sample_time = common_sample_time([log for log, _ in (*before, *after)])
    recordings: tuple[list[Recording], list[Recording]] = ([], [])
    reasons: list[InputError | None] = [None, None]
    for number, logs_given in enumerate((before, after)):
        for log, axis in logs_given:
            parts, reason = recordings_of(log, axis, sample_time, follows=follows, tells_effort=tells_effort)
            recordings[number].extend(parts)
            reasons[number] = reasons[number] or reason
    turned = with_turns([*recordings[0], *recordings[1]], measured=not follows)
    first, second = turned[: len(recordings[0])], turned[len(recordings[0]) :]
    *cycles, complete = cut(first, second)
    low, high = alike((first, cycles[0]), (second, cycles[1]), complete=complete, measured=not follows)
    return Side(first, low, reasons[0]), Side(second, high, reasons[1]), complete
