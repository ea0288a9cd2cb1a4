"""What a friction model sees of a step, and what a controller is asked to follow."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from bristle.core.variable import Variable, variables_of

__all__ = ["NOMINAL_LOAD", "NOMINAL_TEMPERATURE", "NOTHING_TRANSMITTED", "NOT_KNOWN", "RECORDED", "Motion", "Reference"]

NOMINAL_LOAD = 1.0
NOMINAL_TEMPERATURE = 293.15  # [K]
NOTHING_TRANSMITTED = 0.0  # [N or N*m]
NOT_KNOWN = math.nan  # an effort that nobody tells


class Motion(NamedTuple):
    """What a friction model sees of one step."""

    v: Annotated[float, Variable("length/time", "mean velocity of the step; the sign of zero is a side")]
    x: Annotated[float, Variable("length", "position at the end of the step")]
    load: Annotated[float, Variable("1", "normal load over its nominal value")] = NOMINAL_LOAD
    temperature: Annotated[float, Variable("temperature", "temperature")] = NOMINAL_TEMPERATURE
    transmitted: Annotated[float, Variable("force", "effort that passes on to the load")] = NOTHING_TRANSMITTED


# What passes on to the load is recorded by nobody: it follows from the plant.
RECORDED: dict[str, Variable] = {
    name: variable for name, variable in variables_of(Motion).items() if name in Motion._field_defaults and name != "transmitted"
}
"""What of its surroundings a log has a channel for, by name."""


class Reference(NamedTuple):
    """What a controller is asked to follow at one sample."""

    position: Annotated[float, Variable("length", "desired position")]
    velocity: Annotated[float, Variable("length/time", "desired velocity")]
    acceleration: Annotated[float, Variable("length/time^2", "desired acceleration")]
    effort: Annotated[float, Variable("force", "effort fed forward, added before the limit")] = 0.0
