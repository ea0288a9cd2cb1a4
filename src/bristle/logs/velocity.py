"""Whether the axis may move as fast as a log says."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.logs.log_data import LogData

__all__ = ["doubts_about_velocity"]

STRIDE = 20  # samples over which the position is differentiated, against quantisation
BEYOND = 0.02  # of the limit: what noise may add to a velocity


def doubts_about_velocity(log: LogData, axis: Axis) -> Iterator[str]:
    """Yield in words where the axis exceeds its limit."""
    if axis.velocity_limit is None:
        return
    steps = [np.abs(np.diff(log.position.values[segment][::STRIDE])) for segment in log.segments]
    fastest = max((float(step.max()) for step in steps if step.size), default=0.0) / (STRIDE * log.sample_time)
    if fastest > (1.0 + BEYOND) * axis.velocity_limit:
        unit = unit_of("length/time", log.kind)
        yield (
            f"the axis moves at up to {with_unit(fastest, unit)}, faster than its limit of "
            f"{with_unit(axis.velocity_limit, unit)} in the axis file: is the unit of the position right?"
        )
