"""How far the friction that a drive takes from a table is from the model, along the motion of a log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.engine.checks import finite
from bristle.identification.dataset import Segment, transmitted_by
from bristle.logs.check import parted
from bristle.logs.log import Log
from bristle.prediction.predict import rows_as_fitted

__all__ = ["TableError", "table_error"]


class TableError(NamedTuple):
    """What a table errs by along a log: at most, and its root mean square [N or N*m]."""

    largest: float
    rms: float


def table_error(
    friction: Model, plant: Model | None, log: Log, axis: Axis | None, sides: Mapping[float, np.ndarray], treatment: Mapping[str, float]
) -> TableError:
    """Return how far a table is from the model along the motion of a log, as the identification sees that motion."""
    if friction.kind != log.kind:
        raise InputError(
            "is of another kind of axis than the model",
            path="log",
            value=log.kind,
            allowed=friction.kind,
            mend="Give the axis file of this log",
        )
    if log.effort is None:
        raise InputError("has no effort", path="log", mend="Name its column in the axis file")
    rows = rows_as_fitted(parted(log, axis), axis, treatment)
    gaps = []
    for segment, contact in zip(rows.segments, rows.contacts(friction, plant), strict=True):
        force = segment.friction(friction, rows.sample_time, contact, transmitted_by(friction, plant, segment))
        gaps.append(rows.without_edges(force - _of_table(sides, segment)))
    gap = finite(np.concatenate(gaps), friction, "friction")
    return TableError(float(np.max(np.abs(gap))), float(np.sqrt(np.mean(gap**2))))


def _of_table(sides: Mapping[float, np.ndarray], segment: Segment) -> np.ndarray:
    """Return the force of a table along a segment; at rest, of the side that the motion came to rest on."""
    forward, backward = (np.interp(np.abs(segment.velocity), sides[way][:, 0], sides[way][:, 1]) for way in (1.0, -1.0))
    return np.where(np.signbit(segment.velocity), -backward, forward)
