"""Tables for drives: what friction settles to over velocity, in the units of the drive, and what such a table loses.

A table knows neither the distance that a contact deflects over after a reversal nor what it remembers, and a
symmetric one no direction. Each loss is a number: of the model, or in the units of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.typography import printable
from bristle.core.variable import unit_of
from bristle.exports.described import Source
from bristle.friction.slots import variations_of
from bristle.identification.parameters import Role, acts_in_sliding, offset_of
from bristle.prediction.drive_table import LevelValues
from bristle.prediction.drive_units import DriveUnit, LogUnits, TableUnits
from bristle.prediction.reversal import reversal_distance
from bristle.prediction.steady_side import placed, resolved_side

if TYPE_CHECKING:
    from bristle.exports.target import Request

__all__ = [
    "Side",
    "curve_of",
    "error_on_log",
    "level_losses",
    "levels_unseen",
    "losses",
    "mean_side",
    "memory_lost",
    "said_of_units",
    "side_of",
    "table_text",
    "values_text",
]

FEWEST, MOST = 2, 1000
ROUNDING = 1e-9  # of the largest force: a difference that is none
SEEN = ("identified", "held")
MEANINGS = {
    "gravity": "constant force",
    "F+": "forward sliding takes gravity + F+",
    "F-": "backward sliding takes gravity - F-",
    "inertia": "effort for one unit of acceleration",
}


@dataclass(frozen=True)
class Side:
    """One direction of motion: the steady curve, and the entries of the table on it.

    Parameters
    ----------
    curve : ndarray, shape (point, 2)
        Speed [m/s or rad/s], ascending from 0, and force along the motion [N or N*m].
    entries : ndarray, shape (entry, 2)
        Some of them.
    unresolved : float
        How far the steady friction may be off straight lines between the points of the curve [N or N*m].
    """

    curve: np.ndarray
    entries: np.ndarray
    unresolved: float = 0.0

    @property
    def deviation(self) -> float:
        """The largest difference between steady friction and straight lines between the entries [N or N*m]."""
        straight = np.interp(self.curve[:, 0], self.entries[:, 0], self.entries[:, 1])
        largest = float(np.max(np.abs(straight - self.curve[:, 1]))) + self.unresolved
        return largest if largest > ROUNDING * float(np.max(np.abs(self.curve[:, 1]))) else 0.0


def curve_of(model: Model, direction: float, fastest: float) -> np.ndarray:
    """Return the steady friction in one direction: speed and force, shape (point, 2), as close as straight lines need.

    Raises
    ------
    InputError
        If the largest speed is out of range.
    """
    if not 0.0 < fastest < math.inf:
        raise InputError("is needed: how fast the axis moves", path="speed", value=fastest, allowed="> 0",
                         mend='Give it, as in --speed "200 mm/s"')  # fmt: skip
    return resolved_side(model, direction, fastest)[0]


def side_of(model: Model, direction: float, fastest: float, points: int) -> Side:
    """Return one direction of motion, with at most so many entries.

    Raises
    ------
    InputError
        If the number of entries or the largest speed is out of range.
    """
    if not FEWEST <= points <= MOST:
        raise InputError("out of range", path="points", value=points, allowed=f"{FEWEST} to {MOST}")
    curve = curve_of(model, direction, fastest)
    return Side(curve, curve[placed(curve, points)], resolved_side(model, direction, fastest)[1])


def mean_side(forward: Side, backward: Side, points: int) -> Side:
    """Return the mean of both directions."""
    speeds = np.union1d(forward.curve[:, 0], backward.curve[:, 0])
    forces = [np.interp(speeds, side.curve[:, 0], side.curve[:, 1]) for side in (forward, backward)]
    curve = np.column_stack([speeds, 0.5 * (forces[0] + forces[1])])
    return Side(curve, curve[placed(curve, points)], 0.5 * (forward.unresolved + backward.unresolved))


def levels_unseen(model: Model, source: Source) -> tuple[str, ...]:
    """Return which levels of friction no log has shown, a sentence each, from what a model file says of them."""
    notes = []
    for name, variable in model.component.variables.items():
        entry = source.uncertainty.get(name, {})
        doubt = entry.get("note") or ("" if entry.get("status", "identified") in SEEN else "not identified")
        of_sliding = acts_in_sliding(variable) and not Role.BREAK_AWAY.fits(variable)
        if of_sliding and entry.get("status") != "held" and doubt:
            notes.append(f"do not use these forces before a log has shown them: {name}, {doubt}")
    return tuple(notes)


def losses(
    model: Model, forward: Side, backward: Side, effort: DriveUnit, *, symmetric: bool
) -> tuple[str, ...]:  # fmt: skip
    """Return what a table loses, a sentence each."""
    deviation = effort.of(max(forward.deviation, backward.deviation))
    notes = [f"straight lines between the entries are off the steady friction by {deviation:.2g} {effort.name} at most"]
    notes += memory_lost(model, forward.curve, backward.curve, effort)
    if symmetric:
        notes += _directions_lost(model, forward.curve, backward.curve, effort)
    return (*notes, *_variation_lost(model))


def level_losses(
    model: Model, curves: Mapping[float, np.ndarray], levels: LevelValues, effort: DriveUnit
) -> tuple[str, ...]:  # fmt: skip
    """Return what one level for each direction loses, a sentence each."""
    deviation = effort.of(levels.deviation)
    head = f"a level for each direction is off the steady friction by {deviation:.2g} {effort.name} at most"
    return (head, *memory_lost(model, curves[1.0], curves[-1.0], effort), *_variation_lost(model))


def memory_lost(model: Model, forward: np.ndarray, backward: np.ndarray, effort: DriveUnit) -> list[str]:
    """Return how far a reversal goes where a table jumps, in a sentence; none where friction turns at once."""
    distance = reversal_distance(model, float(forward[-1, 0]))
    if distance == 0.0:
        return []
    jump, x = effort.of(forward[0, 1] + backward[0, 1]), unit_of("length", model.kind)
    return [
        f"memory is lost: at a reversal the table jumps by {jump:.3g} {effort.name} at once, and the model changes by "
        f"95 % of it over {distance:.2g} {x}"
    ]


def _directions_lost(model: Model, forward: np.ndarray, backward: np.ndarray, effort: DriveUnit) -> list[str]:
    constant = offset_of(model.component.variables, model.values)
    apart = np.interp(forward[:, 0], backward[:, 0], backward[:, 1]) - forward[:, 1] + 2.0 * constant
    wrong = 0.5 * effort.of(float(np.max(np.abs(apart))))
    notes = []
    if wrong > ROUNDING * effort.of(float(np.max(np.abs(forward[:, 1])))):
        notes.append(f"the table is the same for both directions: each is off by up to {wrong:.3g} {effort.name}")
    if constant:
        notes.append(f"the constant force, {effort.of(constant):.3g} {effort.name}, is not in it: set it apart")
    return notes


def _variation_lost(model: Model) -> list[str]:
    varying = variations_of(model.component)
    return [f"what varies is left out: {', '.join(varying)}"] if varying else []


def said_of_units(axis: Axis | None, effort: DriveUnit) -> tuple[str, ...]:
    """Return why efforts are not in percent of rated, in a sentence; none where they are."""
    if axis is None:
        return ("without an axis file the units are SI of the axis",)
    if axis.rated is None and effort.name != "%":
        return (f"the axis file has no rated effort: efforts are in {effort.name}, as in the log",)
    return ()


def error_on_log(request: Request, entries: Mapping[float, np.ndarray]) -> tuple[str, ...]:
    """Return how far a table is from the model along the log that was given, in a sentence."""
    if request.log is None:
        return ()
    from bristle.prediction.drive_units import log_units
    from bristle.prediction.table_error import table_error

    effort, treatment = log_units(request.axis, request.model.kind).effort, request.info.get("treatment", {})
    scale = max(float(np.max(np.abs(side[:, 1]))) for side in entries.values())
    error = table_error(request.model, request.plant, request.log, request.axis, entries, treatment)
    largest, rms = (f"{effort.of(value if value > ROUNDING * scale else 0.0):.2g} {effort.name}" for value in error)
    own = request.log.origin.checksum in request.info.get("provenance", {}).values()
    which = "its own log" if own else printable(request.log.origin.name)
    return (f"largest error of the table against the model on {which} {largest}; {rms} root mean square",)


def table_text(forward: Side, backward: Side, units: LogUnits) -> str:
    """Return a table over both directions as CSV, velocity ascending."""
    rows = [(-v, -f) for v, f in backward.entries[::-1].tolist()] + forward.entries.tolist()
    lines = [f"{units.velocity.of(v):.9g},{units.effort.of(f):.9g}" for v, f in rows]
    return "\n".join([f"velocity [{units.velocity.name}],effort [{units.effort.name}]", *lines, ""])


def values_text(levels: LevelValues, units: TableUnits, *, inertia: bool) -> str:
    """Return gravity, one level for each direction and, where it is known, the inertia, as CSV."""
    named = {"gravity": levels.constant, "F+": levels.forward, "F-": levels.backward}
    rows = [
        (name, unit.of(value), unit.name)
        for unit in units.efforts for name, value in named.items() if value is not None
    ]  # fmt: skip
    if inertia:
        rows += [("inertia", unit.of(levels.inertia), unit.name) for unit in units.inertias]
    lines = (f"{name},{amount:.9g},{unit},{MEANINGS[name]}" for name, amount, unit in rows)
    return "\n".join(["value,amount,unit,meaning", *lines, ""])
