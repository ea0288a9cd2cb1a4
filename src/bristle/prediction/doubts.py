"""Whether a prediction can be trusted at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.logs.check import RECORDED, checked
from bristle.logs.log import Log
from bristle.logs.look import CheckThresholds
from bristle.simulation.result import Prediction

__all__ = ["with_doubts"]

NOTHING_PERCENT = 100.0  # error of predicting zero
FAR = 1.5  # times the largest speed that the model was fitted to
WORSE = {"position": "position_worse_than_none", "force": "effort_worse_than_none"}
SPAN = 20  # samples over which a speed is taken


def with_doubts(prediction: Prediction, log: Log, axis: Axis | None, velocity_max: float | None) -> Prediction:
    """Return a prediction with what speaks against it."""
    settings = CheckThresholds.among(axis.settings if axis else {})
    wrong = (found for found in checked(log, axis, settings) if found.code in RECORDED)
    doubts: list[Diagnostic] = []
    for signal, code in WORSE.items():
        percent = prediction.metrics.get(f"{signal}_error_percent")
        if not doubts and isinstance(percent, float) and percent > NOTHING_PERCENT:
            doubts.append(Diagnostic(code, numbers={"percent": percent}))
    top = _largest_speed(log)
    if velocity_max is not None and top > FAR * velocity_max:
        doubts.append(Diagnostic("beyond_speed", "", "warning", {"speed": top, "fitted_speed": velocity_max}, log.kind))
    return replace(prediction, diagnostics=(*doubts, *wrong, *prediction.diagnostics))


def _largest_speed(log: Log) -> float:
    position = log.position.values
    parts = [position[part] for part in log.segments or (slice(None),)]
    travels = [np.max(np.abs(positions[SPAN:] - positions[:-SPAN])) for positions in parts if positions.size > SPAN]
    return float(max(travels, default=0.0)) / (SPAN * log.sample_time)
