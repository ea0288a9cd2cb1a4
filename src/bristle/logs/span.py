"""A part of a log: what lies between two times."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.channel import CHANNELS, Channel
from bristle.logs.log_data import LogData

__all__ = ["within"]

R = TypeVar("R", bound=LogData)

FEWEST = 10


def within(log: R, span: tuple[float, float]) -> R:
    """Return the part of a log between two times [s] of its own clock."""
    time = log.time.values
    first, last = (int(index) for index in np.searchsorted(time, span))
    if last - first < FEWEST:
        raise InputError(
            "holds next to nothing of the log",
            path="log.span",
            value=f"{span[0]:g} to {span[1]:g} s",
            allowed=f"within {time[0]:g} to {time[-1]:g} s",
        )

    def part(channel: Channel | None) -> Channel | None:
        return None if channel is None else replace(channel, values=channel.values[first:last])

    segments = [(max(segment.start, first) - first, min(segment.stop, last) - first) for segment in log.segments]
    return replace(
        log,
        **{name: part(getattr(log, name)) for name in CHANNELS},
        further={name: part(channel) for name, channel in log.further.items()},
        injected=tuple(replace(channel, values=channel.values[first:last]) for channel in log.injected),
        regressors=tuple(replace(channel, values=channel.values[first:last]) for channel in log.regressors),
        segments=tuple(slice(start, stop) for start, stop in segments if stop > start),
        notes=(*log.notes, f"only what lies between {span[0]:g} and {span[1]:g} s was used"),
    )
