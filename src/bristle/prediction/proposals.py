"""Proposals of an identification for the axis file, and the gain at which its feedforward is safe to try."""

from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.identification import Fit, ProposedLine, SecondPass, proposed_lines
from bristle.prediction.claims import Compensation
from bristle.prediction.drive_table import reversal_distance

SAFE_ERROR = 50.0  # model error at which a feedforward at gain 1 halves the friction force [%]
FIRST_GAIN = 0.25


def proposals_of(fit: Fit, axis: Axis, tried: SecondPass | None = None) -> list[dict[str, Any]]:
    """Return the lines for the axis file: those that bristle took with their held-out errors [%], and those that it only proposes."""
    lines = ()
    errors = {}
    if tried is not None:
        lines = tried.lines
        errors = {"error_without": tried.error_without, "error_with": tried.error_with}
    further = [
        line
        for line in proposed_lines(fit, axis)
        if (line.section, line.key) not in {line[:2] for line in lines}
    ]
    if axis.presliding is None and not fit.plant.values.get("k"):
        distance = reversal_distance(fit.friction, float(np.max(np.abs(fit.traces.velocity))))
        if distance:
            further.append(ProposedLine("plant", "presliding", distance, "reversal_distance"))
    proposals = [
        line._asdict() | {"taken": tried is not None and tried.taken} | errors for line in lines
    ]
    return proposals + [
        line._asdict() | {"taken": False, "error_without": None, "error_with": None}
        for line in further
    ]


def first_gain(fit: Fit, compensation: Compensation | None = None) -> float:
    """Return the gain at which a feedforward of the model is safe to try; 0 if the model explains less than half of the friction.

    It is also 0 if the log is faulty, or moves in one direction only. It is small if bristle does not promise an improvement.

    A feedforward at gain :math:`g` leaves :math:`(1 - g) F + g e` of the friction force :math:`F`, with the model error
    :math:`e`. Parameters need not be identified for that.
    """
    faulty = any(
        diagnostic.severity == "error" or diagnostic.code == "one_direction"
        for diagnostic in fit.diagnostics
    )
    if faulty or fit.friction_alone_error_percent >= SAFE_ERROR:
        return 0.0
    if compensation and compensation.claims:
        return compensation.rule.gain
    return FIRST_GAIN
