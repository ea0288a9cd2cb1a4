"""Whether a prediction can be trusted at all, in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of
from bristle.logs.log import Log
from bristle.simulation.result import Prediction

__all__ = ["with_doubts"]

NOTHING_PERCENT = 100.0  # error of predicting zero
FAR = 1.5  # times the largest speed that the model was fitted to
SPAN = 20  # samples over which a speed is taken


def with_doubts(prediction: Prediction, log: Log, velocity_max: float | None) -> Prediction:
    """Return a prediction with what speaks against it among its notes.

    Parameters
    ----------
    prediction : Prediction
        A model run on a log.
    log : Log
        The log.
    velocity_max : float or None
        Largest speed that the model was fitted to [m/s or rad/s], where known.
    """
    return replace(prediction, notes=(*_about_error(prediction), *_about_speed(log, velocity_max), *prediction.notes))


def _about_error(prediction: Prediction) -> tuple[str, ...]:
    off = prediction.metrics.get("position_error_percent")
    if isinstance(off, float) and off > NOTHING_PERCENT:
        return (
            f"warning: a position of zero would be nearer to the log than what the model predicts "
            f"({number(off, digits=2)} % off): "
            "an open loop runs away where nothing holds the axis; predict in inverse or closed-loop mode",
        )
    error = prediction.metrics.get("force_error_percent")
    if not isinstance(error, float) or error <= NOTHING_PERCENT:
        return ()
    return (
        f"warning: an effort of zero would be nearer to the log than what the model predicts "
        f"({number(error, digits=2)} % off): "
        "check that the model is of this axis, and units and signs in the axis file",
    )


def _about_speed(log: Log, velocity_max: float | None) -> tuple[str, ...]:
    top = _largest_speed(log)
    if velocity_max is None or top <= FAR * velocity_max:
        return ()
    there, known = (with_unit(one, unit_of("length/time", log.kind)) for one in (top, velocity_max))
    return (
        f"warning: the log moves at up to {there}, the model was fitted to no more than {known}: beyond, its friction "
        "is an extrapolation",
    )


def _largest_speed(log: Log) -> float:
    position = log.position.values
    parts = [position[part] for part in log.segments or (slice(None),)]
    travels = [np.max(np.abs(one[SPAN:] - one[:-SPAN])) for one in parts if one.size > SPAN]
    return float(max(travels, default=0.0)) / (SPAN * log.sample_time)
