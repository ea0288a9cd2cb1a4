"""A recorded motion for the page: where the contact went, and the friction that was measured there.

The effort is filtered as it was for the identification, and what the plant takes of it is taken off. There are not more
points than a page can carry: turns are kept, and between them what is evenly apart. Positions are whole numbers of a
step that is a share of the travel, so that the page has the very numbers that are written here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.logs.check import parted
from bristle.logs.log import Log
from bristle.logs.turns import turning_points
from bristle.prediction.predict import rows_as_fitted

__all__ = ["MOST", "Replay", "decimated", "replay_of_log", "replay_of_traces", "turns_of"]

MOST = 10_000
"""Points that a page carries at most."""
STEPS = 2**28  # of the position, over its travel
TURNS = 0.5  # share of the points that turns may take
FASTEST = 0.4  # of the sampling frequency, for a cut-off
GAP = 1.5  # times the time from row to row: a rest that is no row


class Replay(NamedTuple):
    """A motion: time [s], position in steps of a length [m or rad], friction [N or N*m], and where stretches begin.

    Turns of less than ``depth`` [m or rad] are left out. Friction is the effort where the inertia is not known.
    """

    time: np.ndarray
    steps: np.ndarray
    step: float
    friction: np.ndarray
    begins: tuple[int, ...]
    depth: float
    has_inertia: bool

    @property
    def position(self) -> np.ndarray:
        """Position from the lowest one on [m or rad]."""
        return self.step * self.steps


def replay_of_log(log: Log, axis: Axis | None, plant: Model | None, treatment: Mapping[str, Any] | None = None) -> Replay:
    """Return a log as a motion to be replayed."""
    if log.effort is None:
        raise InputError("has no effort to compare with", path="log", mend="Name its column in the axis")
    log, treated = parted(log, axis), treatment or {}
    cutoff = treated.get("cutoff") or (axis.cutoff if axis is not None else None)
    most = FASTEST / log.sample_time
    cutoff = most if cutoff is not None and cutoff * log.sample_time >= 0.5 else cutoff
    rows = rows_as_fitted(log, axis, {**treated, "cutoff": cutoff})
    parts = []
    for segment in rows.segments:
        plant_effort = rows.mechanical_along(plant, segment) if plant is not None else 0.0
        columns = (segment.time, segment.position, segment.effort - plant_effort)
        parts.append([rows.without_edges(column) for column in columns])
    return decimated(parts, has_inertia=plant is not None)


def replay_of_traces(time: np.ndarray, velocity: np.ndarray, friction: np.ndarray) -> Replay:
    """Return the rows that a model was fitted to as a motion: the position is the sum of the velocities."""
    steps = np.diff(time)
    row = float(np.median(steps))
    moving = np.where(steps < GAP * row, steps, 0.0)
    position = np.concatenate(([0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * moving)))
    return decimated([[time, position, friction]], has_inertia=True)


def decimated(parts: Sequence[Sequence[np.ndarray]], *, has_inertia: bool, most: int = MOST) -> Replay:
    """Return stretches of time, position and friction with no more points than `most`, their turns among them."""
    positions = [part[1] for part in parts]
    low = min(float(np.min(x)) for x in positions)
    travel = max(float(np.max(x)) for x in positions) - low
    depth, turns = 0.0, [turns_of(x, 0.0) for x in positions]
    while sum(map(len, turns)) > TURNS * most:
        depth = max(2.0 * depth, travel / STEPS)
        turns = [turns_of(x, depth) for x in positions]
    left = most - sum(map(len, turns))
    stride = -(-sum(x.size for x in positions) // max(left, 1))
    chosen = [np.union1d(turn, np.arange(0, x.size, stride)) for x, turn in zip(positions, turns, strict=True)]
    begins = tuple(np.cumsum([0, *map(len, chosen)])[:-1].tolist())
    time, position, friction = (np.concatenate([part[i][rows] for part, rows in zip(parts, chosen, strict=True)]) for i in range(3))
    step = (travel or 1.0) / STEPS
    return Replay(time, np.round((position - low) / step), step, friction.astype(np.float32), begins, depth, has_inertia)


def turns_of(x: np.ndarray, depth: float) -> np.ndarray:
    """Return both ends, and where a motion turns by more than a depth, as indices."""
    return np.unique([0, *turning_points(x, depth), x.size - 1])
