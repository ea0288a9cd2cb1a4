"""The way along a recorded velocity, for logs that have no position."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bristle.core.axis import Axis
from bristle.logs.channel import Channel

__all__ = ["integral_of", "remark_on"]


def integral_of(velocity: Channel, unit: str, sample_time: float, segments: Sequence[slice], start: float) -> Channel:
    """Return the integral of a velocity by trapezoids; each segment goes on where the one before it ended."""
    speed = velocity.values
    steps = 0.5 * sample_time * (speed[1:] + speed[:-1])
    for segment in segments[1:]:
        steps[segment.start - 1] = 0.0
    way = start + np.concatenate([[0.0], np.cumsum(steps)])
    return Channel(way, unit, velocity.column, velocity.step * sample_time)


def remark_on(column: str, axis: Axis, *, follows: bool) -> str:
    """Return what is to be said of a position that is the integral of a column."""
    begin = "it begins at the reference" if follows else "it begins at 0"
    terms = [name for name, stated in (("gravity", axis.gravity), ("cogging", axis.cogging)) if stated]
    named = f", here {' and '.join(terms)}," if terms else ""
    return (
        f"the log has no position: it is the integral of column {column}; {begin}, where the axis stood nobody knows, "
        f"and an offset of the speed makes it drift. What depends on the place{named} means nothing"
    )
