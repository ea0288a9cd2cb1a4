r"""Friction compensation of a Beckhoff AX8000 or AMP8000 drive: static friction, dynamic friction, spring rate.

.. math:: u = f + D\,v, \qquad \dot f = k\,v, \quad |f| \le F

with the static friction :math:`F` (0x3144:02), the dynamic friction factor :math:`D` of the feedforward
velocity (0x3144:03), and the static friction spring rate :math:`k` (0x3144:01). The objects are the same in both
directions. The behaviour of :math:`f` at a reversal is not documented: the spring is an assumption from the name and
the unit of its object.

References
----------
.. [1] Beckhoff, "AX8xxx, axis module, object dictionary", 0x3144 VelocityControl parameters friction.
   https://infosys.beckhoff.com/content/1033/ax8xxx_object/18798211723.html
"""

from collections.abc import Mapping

import numpy as np

from bristle.core import Axis, unit_of
from bristle.exports.described import Request, plain
from bristle.exports.drive import (
    behind_comments,
    last_direction,
    level_losses,
    levels_and_curves,
    rows_of,
)
from bristle.exports.effect import Drive
from bristle.exports.targets import Product
from bristle.prediction.drive_table import SETTLED_SHARE, reversal_distance
from bristle.prediction.drive_units import table_units

STATIC = "0x3144:02"
DYNAMIC = "0x3144:03"
SPRING = "0x3144:01"
QUANTITIES = {STATIC: "force", DYNAMIC: "force*time/length", SPRING: "force/length"}
TITLES = {
    STATIC: "Static friction torque/force",
    DYNAMIC: "Dynamic friction factor",
    SPRING: "Static friction spring rate",
}


def write(request: Request) -> Product:
    """Return the objects with their values: means of both directions, static friction, dynamic factor, spring rate."""
    curves, levels = levels_and_curves(request)
    axis = request.axis
    kind = request.model.kind
    effort = table_units(axis, kind).efforts[0]
    level, slope = (
        float(np.mean([value for value in pair if value is not None]))
        for pair in (
            (levels.forward, levels.backward),
            (levels.viscous_forward, levels.viscous_backward),
        )
    )
    static = max(level, 0.0)
    distance = reversal_distance(request.model, request.speed)
    # The spring makes 95 % of the change over the pre-sliding distance of the model.
    values = {STATIC: static, DYNAMIC: max(slope, 0.0), SPRING: 0.0}
    if distance:
        values[SPRING] = 2.0 * SETTLED_SHARE * static / distance
    notes = [*level_losses(request.model, curves, levels, effort, turns=values[SPRING] > 0.0)]
    if (
        levels.forward is not None
        and levels.backward is not None
        and levels.forward != levels.backward
    ):
        apart = effort.of(0.5 * abs(levels.forward - levels.backward))
        notes.append(
            f"each object has one value for both directions: the friction is wrong by {apart:.3g} {effort.name} in each direction"
        )
    if levels.constant:
        force = f"{effort.of(levels.constant):.3g} {effort.name}"
        notes.append(
            f"the objects do not contain the constant force of {force}: set this force separately in the drive"
        )
    of_spring = "0x3144:01 is not written: the friction of the model reverses at once, and Beckhoff does not document the value 0"
    if values[SPRING]:
        of_spring = (
            "0x3144:01 is set so that 95 % of the friction reverses within the pre-sliding distance; "
            "Beckhoff does not document this behaviour"
        )
    notes.append(of_spring)
    of_motor = kind
    if axis is not None and axis.arm is not None:
        of_motor = "rotational"
    rows = [
        f"{index},{_of_motor(value, index, axis):.9g},{plain(unit_of(QUANTITIES[index], of_motor))},{TITLES[index]}"
        for index, value in values.items()
        if index != SPRING or value
    ]
    head = [
        "Friction compensation of a Beckhoff AX8000 or AMP8000: object 0x3144 (channel B: 0x3544), REAL32.",
        "Units: as with the default value of object 0x3005:09. The drive computes the compensation from the feedforward velocity.",
        *request.source.lines,
        *notes,
    ]
    return Product(
        {f"{request.name}.csv": behind_comments(head, "object,value,unit,name", *rows)},
        tuple(notes),
    )


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return the force that the drive computes from the objects: a spring that slips, and viscous friction."""
    rows = rows_of(str(files[f"{request.name}.csv"]))
    values = {
        index: float(value) / _of_motor(1.0, index, request.axis) for index, value, *_ in rows
    }
    static, dynamic, spring = (values.get(index, 0.0) for index in (STATIC, DYNAMIC, SPRING))

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        steps = np.diff(x, prepend=x[:1])
        if not spring:
            return static * last_direction(steps / dt) + dynamic * steps / dt
        force = np.zeros(x.size)
        for k in range(1, x.size):
            force[k] = min(static, max(-static, force[k - 1] + spring * steps[k]))
        return force + dynamic * steps / dt

    return drive


def _of_motor(value: float, index: str, axis: Axis | None) -> float:
    """Return a value in SI units of the axis as a torque of the motor, or as a torque per angle or angular velocity."""
    arm = 1.0
    if axis is not None and axis.arm is not None:
        arm = axis.arm
    if index == STATIC:
        return value * arm
    return value * arm**2
