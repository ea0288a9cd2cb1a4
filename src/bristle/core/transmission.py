"""How movements and efforts on one side of a drive train appear on the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from bristle.core.errors import InputError
from bristle.core.variable import Kind

__all__ = ["Screw", "Side", "Transmission"]

Side = Literal["motor", "load"]


class Screw(NamedTuple):
    """What lies between a motor and the friction of a table: an elastic screw with play, and the table itself."""

    M: float
    k: float
    d: float
    gap: float
    arm: float


@dataclass(frozen=True)
class Transmission:
    """A gear and a screw (or pinion, or belt) between a motor and its load, without losses.

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
        """Return the movement of the axis for a unit movement measured elsewhere [SI per SI]."""
        turned = 1 / self.gear_ratio if measured == "rotational" and side == "motor" else 1.0
        if measured == self.kind:
            return turned
        if self.lead is None:
            raise InputError(
                f"is measured as {'an angle' if measured == 'rotational' else 'a travel'}, and the axis is {self.kind}",
                mend='Write the travel for one turn in the axis file, such as lead = "5 mm" under [transmission]',
            )
        per_radian = self.lead / (2 * math.pi)
        return turned * per_radian if self.kind == "translational" else turned / per_radian

    def effort(self, measured: Kind, side: Side = "load") -> float:
        """Return the effort on the axis for a unit effort measured elsewhere: the power is the same."""
        return 1 / self.travel(measured, side)
