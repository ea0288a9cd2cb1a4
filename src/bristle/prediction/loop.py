"""The loop of an axis with what was identified: what feeding the friction forward gains."""

from __future__ import annotations

import math

import numpy as np

from bristle.controllers.limits import within_drive
from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Start
from bristle.friction import with_presliding
from bristle.logs.log import Log
from bristle.plants.terms import effort_of_columns
from bristle.prediction.predict import unexplained_force
from bristle.simulation.compensation import compensation_experiment
from bristle.simulation.recorded.closed_loop import beginning_of, desired_of, resumed_effort_at

__all__ = ["longest_of", "loop_of"]


def loop_of(
    plant: Model,
    friction: Model,
    log: Log,
    axis: Axis,
    *,
    cutoff: float | None = None,
    lag: float | None = None,
    delay: float | None = None,
    smoothing: float | None = None,
    slow: float | None = None,
    position_smoothing: float | None = None,
) -> Experiment | None:
    """Return the loop of an axis without and with compensation, on the reference that a log holds.

    What the model does not explain of the log is replayed as a disturbance, so that the compensator is not
    judged on its own model. The loops begin where the log does, at its position and velocity, with the effort that
    acted there.
    """
    if axis.controller is None or log.reference is None or log.effort is None:
        return None
    longest, limit = longest_of(log), axis.effort_limit or math.inf
    injected = log.injected_effort[longest] if np.any(log.injected_effort) else None
    left = unexplained_force(
        plant, friction, log, axis, cutoff=cutoff, delay=delay, smoothing=smoothing, slow=slow, position_smoothing=position_smoothing
    )
    beside = effort_of_columns(plant, [column.values for column in log.regressors])
    left = left if beside is None else left + beside
    return compensation_experiment(
        plant,
        with_presliding(friction, axis.presliding or 0.0),
        friction,
        axis.controller,
        log.reference.values[longest],
        log.sample_time,
        resolution=axis.resolution or 0.0,
        effort_limit=limit,
        lag=axis.lag if lag is None else lag,
        disturbance=left[longest],
        injected=injected,
        start=_start(within_drive(axis.controller, limit, injected), log, axis, longest),
        name=axis.name,
    )


def longest_of(log: Log) -> slice:
    """Return the longest stretch of a log without a gap, which is followed again."""
    return max(log.segments, key=lambda part: part.stop - part.start)


def _start(law: Model, log: Log, axis: Axis, part: slice) -> Start:
    """Return the motion and the effort that a stretch of a log begins with."""
    assert log.reference is not None
    beginning = beginning_of(log, part.start, axis.resolution)
    desired = desired_of(log.reference.values[part], log.sample_time)
    resumed = resumed_effort_at(law, desired, log, part.start, beginning)
    return Start(beginning.x, beginning.v, beginning.acceleration, resumed)
