"""Motion of a friction model, reference of a controller, and transmission of a drive train."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from bristle.core.errors import InputError
from bristle.core.variable import Kind, Variable, variables_of

NOMINAL_LOAD = 1.0
NOMINAL_TEMPERATURE = 293.15  # [K]
NOTHING_TRANSMITTED = 0.0  # [N or N*m]
STILL = 1e-10  # speed below which an axis is at rest [m/s or rad/s]
NOT_KNOWN = math.nan  # an unknown effort


class Motion(NamedTuple):
    """Input of a friction model for one step."""

    v: Annotated[
        float, Variable("length/time", "mean velocity of the step; the sign of zero selects a side")
    ]
    x: Annotated[float, Variable("length", "position at the end of the step")]
    load: Annotated[float, Variable("1", "normal load over its nominal value")] = NOMINAL_LOAD
    temperature: Annotated[float, Variable("temperature", "temperature")] = NOMINAL_TEMPERATURE
    transmitted: Annotated[float, Variable("force", "effort transmitted to the load")] = (
        NOTHING_TRANSMITTED
    )


# The transmitted effort is not recorded: it follows from the plant.
RECORDED: dict[str, Variable] = {
    name: variable
    for name, variable in variables_of(Motion).items()
    if name in Motion._field_defaults and name != "transmitted"
}
"""Channels of the surroundings in a log, by name."""


class Reference(NamedTuple):
    """Reference of a controller at one sample."""

    position: Annotated[float, Variable("length", "desired position")]
    velocity: Annotated[float, Variable("length/time", "desired velocity")]
    acceleration: Annotated[float, Variable("length/time^2", "desired acceleration")]
    effort: Annotated[float, Variable("force", "feedforward effort, added before the limit")] = 0.0


Side = Literal["motor", "load"]


class Screw(NamedTuple):
    """Elastic screw with play, and the table that it moves."""

    M: float
    k: float
    d: float
    gap: float
    arm: float


@dataclass(frozen=True)
class Transmission:
    """Lossless gear and screw (or pinion, or belt) between a motor and its load.

    Examples
    --------
    A motor turns a screw of 5 mm lead through a gear of 2:1; one radian of the motor moves the carriage by 0.4 mm.

    >>> train = Transmission("translational", gear_ratio=2.0, lead=0.005)
    >>> round(train.travel("rotational", "motor"), 7)
    0.0003979
    """

    kind: Kind
    gear_ratio: float = 1.0
    lead: float | None = None

    def travel(self, measured: Kind, side: Side = "load") -> float:
        """Return the movement of the axis per unit of the measured movement [SI per SI]."""
        turned = 1 / self.gear_ratio if measured == "rotational" and side == "motor" else 1.0
        if measured == self.kind:
            return turned
        if self.lead is None:
            raise InputError(
                f"is measured as {'an angle' if measured == 'rotational' else 'a travel'}, but the axis is {self.kind}",
                mend='Write the travel per turn in the axis file, such as lead = "5 mm" under [transmission]',
            )
        per_radian = self.lead / (2 * math.pi)
        return turned * per_radian if self.kind == "translational" else turned / per_radian

    def effort(self, measured: Kind, side: Side = "load") -> float:
        """Return the effort on the axis per unit of the measured effort, at equal power."""
        return 1 / self.travel(measured, side)
