"""Friction compensation of a TwinCAT 3 CNC: its list of compensation values.

Velocities, distance and entries have the units of the documentation; currents are in 0.1 % of rated, the unit of the
torque in CANopen drives.

References
----------
.. [1] Beckhoff, "TF5200 | TwinCAT 3 CNC, friction compensation", compensation values P-COMP-00041 to P-COMP-00047.
   https://infosys.beckhoff.com/content/1033/tf5200_friction_comp/352391819.html
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bristle.core import Axis, InputError
from bristle.exports.described import Request
from bristle.exports.drive import (
    Side,
    behind_comments,
    error_on_log,
    last_direction,
    losses,
    mean_side,
    side_of,
)
from bristle.exports.effect import Drive
from bristle.exports.loops import lead_of
from bristle.exports.targets import Product
from bristle.identification.parameters import offset_of
from bristle.prediction.drive_table import reversal_distance
from bristle.prediction.drive_units import DriveUnit, table_units

MOST = 20
SCALE_OF_ONE = 1000
LONGEST_DELAY = 10
MOST_AHEAD = 4
DELAY_UNIT = {"translational": ("0.1 um", 1e-7), "rotational": ("0.0001 deg", math.radians(1e-4))}
SPEED_UNIT = {"translational": ("um/s", 1e-6), "rotational": ("0.001 deg/s", math.radians(1e-3))}
PER_MILLE = "0.1 % of rated"


def write(request: Request) -> Product:
    """Return the list of compensation values, with its losses and its origin as comments."""
    model = request.model
    delay_unit, delay_si = DELAY_UNIT[request.model.kind]
    unit, unit_si = SPEED_UNIT[request.model.kind]
    forward, backward = [side_of(model, way, request.speed, request.points) for way in (1.0, -1.0)]
    effort = table_units(request.axis, model.kind).efforts[0]
    constant = offset_of(model.component.variables, model.values)
    current = _current_unit(request.axis, effort)
    mean = merged(mean_side(forward, backward, request.points), current, model.kind)
    entries = [(round(v / unit_si), round(f / current.si)) for v, f in mean.entries.tolist()]
    if len(entries) > MOST:
        raise InputError(
            "exceeds the length of the list of the CNC",
            path="points",
            value=len(entries),
            allowed=f"{MOST} entries or fewer",
        )
    written = np.array([[v * unit_si, float(f) * current.si] for v, f in entries])
    delay = round(reversal_distance(model, float(mean.curve[-1, 0])) / delay_si)
    ahead = lead_of(request)
    notes = (
        *losses(model, forward, backward, effort, symmetric=True),
        f"currents are integers in {PER_MILLE}: rounding changes each current by up to half of this unit",
    )
    if delay > LONGEST_DELAY:
        notes += (
            f"position_delay has its largest value, {LONGEST_DELAY}, but the friction needs {delay} x {delay_unit} to reverse",
        )
    notes += error_on_log(
        request, {way: written + np.array([0.0, way * constant]) for way in (1.0, -1.0)}
    )
    head = [
        f"Friction compensation of {model.name}: Beckhoff TF5200, list of compensation values.",
        *request.source.lines,
        *notes,
        f"Unit of in: {unit}. Unit of out: {PER_MILLE}, as for the torque of CANopen drives. Check the values of out against the "
        "torque that your drive reports.",
        "Also set lr_param.frict_comp 1 in the axis machine data (P-AXIS-00522).",
        f"position_delay: 95 % of the force reverses within {delay} x {delay_unit}; the largest value is {LONGEST_DELAY}.",
        f"reversal_lookahead: cycles by which the current leads a reversal; this axis needs {ahead}, the largest value is {MOST_AHEAD}.",
    ]
    rows = {
        "mode": 3,
        "table_entries": len(entries),
        "position_delay": min(delay, LONGEST_DELAY),
        "reversal_lookahead": min(ahead, MOST_AHEAD),
        "scaling_factor": SCALE_OF_ONE,
        "delay_cycles": 0,
    }
    for i, (v, f) in enumerate(entries):
        rows |= {f"table[{i}].in": v, f"table[{i}].out": f}
    lines = [f"{'frict_comp.' + key:<40}{value}" for key, value in rows.items()]
    return Product({f"{request.name}.txt": behind_comments(head, *lines)}, notes)


def _current_unit(axis: Axis | None, effort: DriveUnit) -> DriveUnit:
    """Return the unit of the currents, 0.1 % of rated."""
    if axis is not None and axis.rated:
        return DriveUnit(PER_MILLE, 1e-3 * axis.rated)
    if effort.name != "%":
        raise InputError(
            f"needs the rated effort, because the list contains integers in {PER_MILLE} effort",
            path="tf5200",
            value=effort.name,
            allowed="an effort column in %, or rated in the axis file",
            mend='Write rated = "2.4 N*m", the rated torque of the drive, under [effort] of the axis file, and pass this file with --axis',
        )
    return DriveUnit(PER_MILLE, 0.1 * effort.si)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return the force that the control computes from the list and the commanded velocity, with a weight near reversals.

    The current decays over ``reversal_lookahead`` cycles before a reversal and builds up over ``position_delay`` after it;
    it stays during a stop without a reversal (P-COMP-00043, P-COMP-00044).
    """
    kind = request.model.kind
    current = _current_unit(request.axis, table_units(request.axis, kind).efforts[0])
    rows = (
        line.split()
        for line in str(files[f"{request.name}.txt"]).splitlines()
        if not line.startswith("#")
    )
    values = {key.removeprefix("frict_comp."): float(value) for key, value in rows}
    entries = range(int(values["table_entries"]))
    speeds = SPEED_UNIT[kind][1] * np.array([values[f"table[{i}].in"] for i in entries])
    scale = values["scaling_factor"] / SCALE_OF_ONE * current.si
    forces = scale * np.array([values[f"table[{i}].out"] for i in entries])
    distance = DELAY_UNIT[kind][1] * values["position_delay"]
    cycles = int(values["reversal_lookahead"])

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        velocity = np.diff(x, prepend=x[:1]) / dt
        way = last_direction(velocity)
        weight = np.ones(x.size)
        for turn in np.flatnonzero(np.diff(way)) + 1:
            before = np.arange(max(turn - cycles, 0), turn)
            weight[before] = np.minimum(weight[before], (turn - before) / (cycles + 1.0))
            if distance > 0.0:
                reached = np.abs(x[turn:] - x[turn - 1]) / distance
                if np.any(reached >= 1.0):
                    built = int(np.argmax(reached >= 1.0))
                else:
                    built = reached.size
                weight[turn:] = 1.0  # an unfinished earlier reversal ends here
                weight[turn : turn + built] = reached[:built]
        return way * weight * np.interp(np.abs(velocity), speeds, forces)

    return drive


def merged(side: Side, current: DriveUnit, kind: str) -> Side:
    """Return a side without the entries that rounding makes redundant or puts at one speed."""
    written = [
        (round(v / SPEED_UNIT[kind][1]), round(f / current.si)) for v, f in side.entries.tolist()
    ]
    apart = [k for k in range(len(written)) if k == 0 or written[k][0] != written[k - 1][0]]
    neighbours = zip(apart, [None, *apart[:-1]], [*apart[1:], None], strict=True)
    numbers = [
        k
        for k, low, high in neighbours
        if low is None or high is None or not written[low][1] == written[k][1] == written[high][1]
    ]
    return replace(side, entries=side.entries[numbers])
