"""Lines that an identification proposes for the axis file, as data: gravity, offset, cogging, pre-sliding distance."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis, Cogging
from bristle.identification import Fit
from bristle.prediction.drive_table import reversal_distance

SAFE_ERROR = 50.0  # model error at which a feedforward at gain 1 halves the friction force [%]
FIRST_GAIN = 0.25


class ProposedLine(NamedTuple):
    """A line for the axis file: section, key, value in SI units of the axis, and the code of its reason."""

    section: str
    key: str
    value: Any
    reason: str


def proposals_of(fit: Fit, axis: Axis) -> list[ProposedLine]:
    """Return the lines that would improve the next identification of this axis."""
    lines: list[ProposedLine] = []
    for diagnostic in fit.diagnostics:
        numbers, code = diagnostic.numbers, diagnostic.code
        if code == "missing_ripple" and numbers["pulls"] == "alike" and numbers["harmonics"] and not axis.cogging:
            lines += [ProposedLine("cogging", key, numbers[key], code) for key in ("turner", "harmonics", "travel")]
        if code == "weight_guessed" and axis.offset == "identify":
            lines.append(ProposedLine("plant", "offset", numbers["weight"], code))
        if code == "missing_gravity" and not axis.gravity:
            lines.append(ProposedLine("plant", "gravity", "link", code))
    if axis.presliding is None and not fit.plant.values.get("k"):
        distance = reversal_distance(fit.friction, float(np.max(np.abs(fit.traces.velocity))))
        lines += [ProposedLine("plant", "presliding", distance, "reversal_distance")] if distance else []
    return lines


def first_gain(fit: Fit) -> float:
    """Return the gain at which a feedforward of the model is safe to try; 0 if the model explains less than half of the friction.

    A feedforward at gain :math:`g` leaves :math:`(1 - g) F + g e` of the friction force :math:`F`, with the model error
    :math:`e`. Parameters need not be identified for that.
    """
    return FIRST_GAIN if fit.friction_alone_error_percent < SAFE_ERROR else 0.0


def axis_with(axis: Axis, proposals: Sequence[ProposedLine]) -> Axis:
    """Return an axis with proposed lines."""
    values = {(proposal.section, proposal.key): proposal.value for proposal in proposals}
    if ("cogging", "travel") in values:
        turn = Cogging(values["cogging", "turner"], values["cogging", "travel"], tuple(values["cogging", "harmonics"]))
        axis = replace(axis, cogging=(*axis.cogging, turn))
    if ("plant", "offset") in values:
        axis = replace(axis, offset=values["plant", "offset"])
    if ("plant", "gravity") in values:
        axis = replace(axis, gravity=True)
    return replace(axis, presliding=values.get(("plant", "presliding"), axis.presliding))
