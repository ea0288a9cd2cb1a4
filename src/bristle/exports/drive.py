"""Tables for drives: what friction settles to over velocity, in the units of the drive, and what such a table loses.

A table knows neither the distance that a contact deflects over after a reversal nor what it remembers, and a
symmetric one no direction. Each loss is a number: of the model, or in the units of the drive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.core.errors import InputError
from bristle.core.variable import KINDS, unit_of
from bristle.engine.steady import steady_force
from bristle.friction import unvaried
from bristle.prediction.drive_table import placed
from bristle.prediction.drive_units import LogUnits

__all__ = [
    "Side",
    "losses",
    "mean_side",
    "reversal_distance",
    "side_of",
    "table_text",
    "tf5200_text",
]

POINTS, FEWEST, MOST = 20, 2, 1000
FINE = 48  # points of the steady curve on each side
NEAREST = 1e-5  # of the largest speed: the first of them
SETTLED_SHARE = 0.95
FINEST, FARTHEST, PACES = 1e-9, 1e-1, 160  # of the way after a reversal [m or rad]
TF5200_POINTS, SCALE_OF_ONE, LONGEST_DELAY, DELAY_UNIT = (
    20,
    1000,
    10,
    {"translational": 1e-7, "rotational": math.radians(1e-4)},
)
SPEED_UNIT = {"translational": ("um/s", 1e-6), "rotational": ("0.001 deg/s", math.radians(1e-3))}


@dataclass(frozen=True)
class Side:
    """One direction of motion: the steady curve, and the entries of the table on it.

    Parameters
    ----------
    curve : ndarray, shape (point, 2)
        Speed [m/s or rad/s], ascending from 0, and force along the motion [N or N*m].
    entries : ndarray, shape (entry, 2)
        Some of them.
    """

    curve: np.ndarray
    entries: np.ndarray

    @property
    def deviation(self) -> float:
        """The largest difference between the curve and straight lines between the entries [N or N*m]."""
        straight = np.interp(self.curve[:, 0], self.entries[:, 0], self.entries[:, 1])
        return float(np.max(np.abs(straight - self.curve[:, 1])))


def side_of(model: Model, direction: float, fastest: float, points: int) -> Side:
    """Return one direction of motion, with at most so many entries.

    Raises
    ------
    InputError
        If the number of entries or the largest speed is out of range.
    """
    if not FEWEST <= points <= MOST:
        raise InputError("out of range", path="points", value=points, allowed=f"{FEWEST} to {MOST}")
    if not 0.0 < fastest < math.inf:
        raise InputError("is needed: how fast the axis moves", path="speed", value=fastest, allowed="> 0",
                         mend='Give it, as in --speed "200 mm/s"')  # fmt: skip
    half = FINE // 2
    speeds = np.union1d(fastest * np.geomspace(NEAREST, 1.0, half), np.linspace(0.0, fastest, half))
    slowest = 1e-9 * fastest
    forces = [direction * steady_force(model, direction * max(speed, slowest)) for speed in speeds.tolist()]
    curve = np.column_stack([speeds, forces])
    return Side(curve, curve[placed(curve, points)])


def mean_side(forward: Side, backward: Side, points: int) -> Side:
    """Return the mean of both directions."""
    curve = 0.5 * (forward.curve + backward.curve)
    return Side(curve, curve[placed(curve, points)])


def reversal_distance(model: Model, speed: float) -> float:
    """Return over which distance after a reversal at a low speed the force changes by 95 % of the change [m or rad]."""
    component, p = model.component, unvaried(model).parameters
    state, memory = component.initial_state(p), component.new_memory(p)
    x, before = 0.0, 0.0
    forces: list[float] = []
    for direction in (-1.0, 1.0):
        forces.clear()
        way = np.diff(np.concatenate([[0.0], np.geomspace(FINEST, FARTHEST, PACES)]))
        for pace in way.tolist():
            x += direction * pace
            force, move = component.trial(state, memory, Motion(direction * speed, x), pace / speed, p)
            state = component.commit(state, memory, move, p)
            forces.append(force)
        if direction < 0.0:
            before = forces[-1]
    change = np.array(forces) - before
    far = np.geomspace(FINEST, FARTHEST, PACES)
    enough = SETTLED_SHARE * change[-1]
    first = int(np.argmax(change >= enough))
    return float(np.interp(enough, change[first - 1 : first + 1], far[first - 1 : first + 1])) if first > 0 else 0.0


def losses(model: Model, forward: Side, backward: Side, scale: LogUnits, *, symmetric: bool) -> tuple[str, ...]:
    """Return what a table loses, a sentence each."""
    effort, x = scale.effort.name, unit_of("length", model.kind)
    deviation = max(forward.deviation, backward.deviation) / scale.effort.si
    notes = [f"straight lines between the entries are off the steady friction by {deviation:.2g} {effort} at most"]
    distance = reversal_distance(model, 1e-3 * float(forward.curve[-1, 0]))
    jump = (forward.curve[0, 1] + backward.curve[0, 1]) / scale.effort.si
    if distance > 0.0:
        notes.append(
            f"memory is lost: at a reversal the table jumps by {jump:.3g} {effort} at once, and the model changes by "
            f"95 % of it over {distance:.2g} {x}"
        )
    if symmetric:
        apart = np.interp(forward.curve[:, 0], backward.curve[:, 0], backward.curve[:, 1]) - forward.curve[:, 1]
        wrong = 0.5 * float(np.max(np.abs(apart))) / scale.effort.si
        if wrong > 0.0:
            notes.append(f"the table is the same for both directions: each is off by up to {wrong:.3g} {effort}")
    varying = [slot for slot in model.name.split("+")[1:] if slot != "asymmetry"]
    if varying:
        notes.append(f"what varies is left out: {', '.join(varying)}")
    return tuple(notes)


def table_text(forward: Side, backward: Side, scale: LogUnits) -> str:
    """Return a table over both directions as CSV, velocity ascending, in the units of the drive."""
    rows = [(-v, -f) for v, f in backward.entries[::-1].tolist()] + forward.entries.tolist()
    lines = [f"{v / scale.velocity.si:.9g},{f / scale.effort.si:.9g}" for v, f in rows]
    return "\n".join([f"velocity [{scale.velocity.name}],effort [{scale.effort.name}]", *lines, ""])


def tf5200_text(model: Model, side: Side, scale: LogUnits, notes: tuple[str, ...], facts: list[str]) -> str:
    """Return the friction compensation of a TwinCAT 3 CNC as its list of compensation values has it."""
    if len(side.entries) > TF5200_POINTS:
        raise InputError("are more entries than the list takes", path="points", value=len(side.entries),
                         allowed=f"{TF5200_POINTS} or fewer")  # fmt: skip
    unit, unit_si = SPEED_UNIT[model.kind]
    delay = round(reversal_distance(model, 1e-3 * float(side.curve[-1, 0])) / DELAY_UNIT[model.kind])
    per_mille = scale.effort.name == "%"
    effort = "0.1 % of rated, as CANopen drives report their torque" if per_mille else scale.effort.name
    factor = scale.effort.si * (0.1 if per_mille else 1.0)
    head = [
        f"Friction compensation of {model.name}: Beckhoff TF5200, list of compensation values.", *facts, *notes,
        f"in: {unit}; out: {effort}. Check the unit of out against the torque that your drive reports.",
        "Also set lr_param.frict_comp 1 in the axis machine data (P-AXIS-00522).",
        f"position_delay: 95 % of the force has turned after {delay} of its units ({_unit_of_delay(model.kind)}); its "
        f"range ends at {LONGEST_DELAY}.",
    ]  # fmt: skip
    rows = [
        ("mode", "3"), ("table_entries", str(len(side.entries))), ("position_delay", str(min(delay, LONGEST_DELAY))),
        ("reversal_lookahead", "0"), ("scaling_factor", str(SCALE_OF_ONE)), ("delay_cycles", "0"),
    ]  # fmt: skip
    for i, (v, f) in enumerate(side.entries.tolist()):
        current = _current(f / factor, rounded=per_mille)
        rows += [(f"table[{i}].in", f"{round(v / unit_si)}"), (f"table[{i}].out", current)]
    lines = [f"# {line}" for line in head] + [f"{'frict_comp.' + key:<40}{value}" for key, value in rows]
    return "\n".join([*lines, ""])


def _unit_of_delay(kind: str) -> str:
    return "0.1 um" if kind == KINDS[0] else "0.0001 deg"


def _current(value: float, *, rounded: bool) -> str:
    return str(round(value)) if rounded else f"{value:.6g}"
