"""Experiments that a log contains: slides at constant velocity, loops before sliding, break-aways, chirps, moves."""

from __future__ import annotations

import numpy as np

from bristle.core.axis import Axis
from bristle.core.edge import guarded, instance, optional
from bristle.logs.legs import graininess
from bristle.logs.log import Log
from bristle.logs.passage import Passage
from bristle.logs.stretch import Stretch

__all__ = ["passages", "passages_along"]


@guarded(log=instance(Log, "a log", "Write read_log(...)"), axis=optional(instance(Axis, "an axis")))
def passages(log: Log, axis: Axis | None = None) -> tuple[Passage, ...]:
    """Return the experiments that a log contains, in order.

    Parameters
    ----------
    log : Log
        Position over time, and the effort where there is one.
    axis : Axis, optional
        Its encoder and its pre-sliding distance, where known.
    """
    position, effort = log.position.values, None if log.effort is None else log.effort.values
    resolution = axis.resolution if axis is not None else None
    grain = graininess(position, resolution or log.position.step)
    ordered: list[Passage] = []
    for part in log.segments or (slice(0, position.size),):
        ordered += passages_along(
            log.time.values[part],
            position[part],
            None if effort is None else effort[part],
            grain,
            presliding=axis.presliding if axis is not None else None,
            start=part.start or 0,
        )
    return tuple(ordered)


def passages_along(
    time: np.ndarray, position: np.ndarray, effort: np.ndarray | None, grain: float, *, presliding: float | None = None, start: int = 0
) -> list[Passage]:
    """Return the experiments that one stretch without a gap contains, in order."""
    return Stretch(time, position, effort, grain, presliding, start).passages() if time.size > 1 else []
