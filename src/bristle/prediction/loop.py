"""The loop of an axis with what was identified: what feeding the friction forward gains."""

from __future__ import annotations

import math

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.experiment import Experiment
from bristle.friction import is_static, with_presliding
from bristle.logs.log import Log
from bristle.prediction.predict import unexplained_force
from bristle.simulation.compensation import compensation_experiment

__all__ = ["loop_of"]


def loop_of(plant: Model, friction: Model, log: Log, axis: Axis, *, cutoff: float | None = None) -> Experiment | None:
    """Return the loop of an axis without and with compensation, on the reference that a log holds.

    What the model does not explain of the log is replayed as a disturbance, so that the compensator is not
    judged on its own model.

    Parameters
    ----------
    plant, friction : Model
        The identified mechanism; its friction is also what is fed forward.
    log : Log
        Its reference is followed, over the longest stretch without a gap.
    axis : Axis
        Controller, encoder, limit and pre-sliding distance.
    cutoff : float, optional
        Cut-off of the identification [Hz]; the axis decides where it is not given.

    Returns
    -------
    Experiment or None
        None where the axis has no controller, or the log no reference or effort.
    """
    if axis.controller is None or log.reference is None or log.effort is None:
        return None
    longest = max(log.segments, key=lambda part: part.stop - part.start)
    simulated = friction
    if axis.presliding and is_static(friction):
        simulated = with_presliding(friction, axis.presliding)
    return compensation_experiment(
        plant,
        simulated,
        friction,
        axis.controller,
        log.reference.values[longest],
        log.sample_time,
        resolution=axis.resolution or 0.0,
        effort_limit=axis.effort_limit or math.inf,
        disturbance=unexplained_force(plant, friction, log, axis, cutoff=cutoff)[longest],
        name=axis.name,
    )
