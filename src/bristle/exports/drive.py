"""Tables for drives: steady friction over velocity in the units of the drive, and the losses of such a table.

A table has no pre-sliding distance and no memory, and a symmetric table has no direction. Each loss is stated as a
number of the model or in the units of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bristle.core import Axis, InputError, printable, unit_of
from bristle.core.contracts import STILL, Model
from bristle.exports.described import Request, plain
from bristle.exports.targets import Product
from bristle.identification.parameters import offset_of
from bristle.models.friction.slots import variations_of
from bristle.prediction.drive_table import (
    LevelValues,
    levels_of,
    placed,
    resolved_side,
    reversal_distance,
    table_error,
    without_fall,
)
from bristle.prediction.drive_units import (
    DriveUnit,
    LogUnits,
    TableUnits,
    column_signs,
    drive_units,
    log_units,
    table_units,
)

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

# Entries of one direction; points of a table that are gravity, levels and viscous friction.
FEWEST = 2
MOST = 1000
VALUES = 3
VISCOUS = "force*time/length"
ROUNDING = 1e-9  # of the largest force: smaller differences count as zero
MEANINGS = {
    "gravity": "constant force",
    "F+": "effort of forward sliding is gravity + F+ + D+ * velocity",
    "F-": "effort of backward sliding is gravity - F- + D- * velocity",
    "D+": "viscous friction forward; omit it if the drive has no field for it",
    "D-": "viscous friction backward",
    "inertia": "effort for one unit of acceleration",
}
AT_REST = {
    (
        "table",
        "held",
    ): "at rest (velocity 0): output the entry at zero of the last direction; before the first move, the mean of both "
    "entries",
    ("table", "middle"): "at rest (velocity 0): output the mean of both entries at zero",
    (
        "levels",
        "held",
    ): "at rest: output gravity plus the level of the last direction; before the first move, gravity",
    ("levels", "middle"): "at rest: output gravity",
}
"""Outputs of a drive at rest, by kind of file and rule."""


def write(request: Request) -> Product:
    """Return a curve, or gravity, level and viscous friction for each direction, and the inertia."""
    model = request.model
    units = table_units(request.axis, request.model.kind)
    signs = column_signs(request.axis)
    effort = units.efforts[0]
    if request.points == VALUES:
        curves, levels = levels_and_curves(request)
        ends = np.array([0.0, request.speed])
        forward, backward, rising, falling = (
            level or 0.0
            for level in (
                levels.forward,
                levels.backward,
                levels.viscous_forward,
                levels.viscous_backward,
            )
        )
        sides = {
            1.0: forward + levels.constant + rising * ends,
            -1.0: backward - levels.constant + falling * ends,
        }
        notes = (AT_REST["levels", request.rest], *level_losses(model, curves, levels, effort))
        notes += error_on_log(
            request, {way: np.column_stack([ends, forces]) for way, forces in sides.items()}
        )
        if not levels.inertia:
            notes += ("the inertia is unknown: the model file has no plant with an inertia",)
        notes += said_of_units(request.axis, effort)
        return Product(
            {
                f"{request.name}.csv": _values_text(
                    levels, request, units, (*request.source.lines, *notes)
                )
            },
            notes,
        )
    if not 2 * FEWEST <= request.points <= 2 * MOST:
        raise InputError(
            "out of range", path="points", value=request.points, allowed=f"{VALUES} to {2 * MOST}"
        )
    forward, backward = directions = [
        side_of(model, way, request.speed, request.points // 2) for way in (1.0, -1.0)
    ]
    notes = (AT_REST["table", request.rest],)
    if not signs[0] * signs[1] > 0.0:
        notes += (
            "the log counts effort and position in opposite directions, and so does the table in the units of the log",
        )
    notes += losses(model, forward, backward, effort, symmetric=False)
    notes += (
        *error_on_log(request, {1.0: forward.entries, -1.0: backward.entries}),
        *said_of_units(request.axis, effort),
    )
    head = (*request.source.lines, *notes)
    files: dict[str, str | bytes] = {
        f"{request.name}.csv": _curve_text(directions, units.log, signs, head)
    }
    if units.drive is not None:
        # In a drive, effort and position have the same sign; a column of the log may have the opposite one.
        files[f"{request.name}_drive.csv"] = _curve_text(
            directions, units.drive, (signs[0], signs[0]), head
        )
        notes = (
            *notes,
            f"{request.name}_drive.csv: {units.drive.effort.name} over {units.drive.velocity.name}",
        )
    return Product(files, notes)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return the force that a drive computes from the file in units of the drive, or else of the log."""
    units = table_units(request.axis, request.model.kind)
    signs = column_signs(request.axis)
    if request.points == VALUES:
        return _drive_of_values(str(files[f"{request.name}.csv"]), request, units)
    units_of_file = units.log
    ending = ""
    if units.drive is not None:
        units_of_file = units.drive
        signs = (signs[0], signs[0])
        ending = "_drive"
    # Straight lines between entries, at rest by the rule of the file.
    velocity, effort = np.array(rows_of(str(files[f"{request.name}{ending}.csv"])), dtype=float).T
    velocity = signs[0] * units_of_file.velocity.si * velocity
    effort = signs[1] * units_of_file.effort.si * effort
    sides = {}
    for way in (1.0, -1.0):
        own = np.signbit(velocity) == (way < 0.0)
        order = np.argsort(np.abs(velocity[own]))
        sides[way] = np.column_stack([np.abs(velocity[own]), way * effort[own]])[order]

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        velocity = np.diff(x, prepend=x[:1]) / dt
        way = direction_by(request.rest, velocity)
        speed = np.abs(velocity)
        forward, backward = (
            np.interp(speed, sides[side][:, 0], sides[side][:, 1]) for side in (1.0, -1.0)
        )
        return np.where(
            way == 0.0, 0.5 * (forward - backward), np.where(way > 0.0, forward, -backward)
        )

    return drive


@dataclass(frozen=True)
class Side:
    """One direction of motion: the steady curve, and the entries of the table on it."""

    curve: np.ndarray
    entries: np.ndarray
    unresolved: float = 0.0

    @property
    def deviation(self) -> float:
        """The largest difference between steady friction and straight lines between the entries [N or N*m]."""
        straight = np.interp(self.curve[:, 0], self.entries[:, 0], self.entries[:, 1])
        largest = float(np.max(np.abs(straight - self.curve[:, 1]))) + self.unresolved
        if largest > ROUNDING * float(np.max(np.abs(self.curve[:, 1]))):
            return largest
        return 0.0


def curve_of(model: Model, direction: float, fastest: float) -> tuple[np.ndarray, float]:
    """Return the steady friction in one direction: speed and force, shape (point, 2), and the error of straight lines between points."""
    if not 0.0 < fastest < math.inf:
        raise InputError(
            "the largest speed of the axis is missing",
            path="speed",
            value=fastest,
            allowed="> 0",
            mend='Give this speed, as in --speed "200 mm/s"',
        )
    return resolved_side(model, direction, fastest)


def side_of(model: Model, direction: float, fastest: float, points: int) -> Side:
    """Return one direction of motion, with at most `points` entries."""
    if not FEWEST <= points <= MOST:
        raise InputError("out of range", path="points", value=points, allowed=f"{FEWEST} to {MOST}")
    return _tabulated(*curve_of(model, direction, fastest), points)


def mean_side(forward: Side, backward: Side, points: int) -> Side:
    """Return the mean of both directions."""
    speeds = np.union1d(forward.curve[:, 0], backward.curve[:, 0])
    forces = [np.interp(speeds, side.curve[:, 0], side.curve[:, 1]) for side in (forward, backward)]
    curve = np.column_stack([speeds, 0.5 * (forces[0] + forces[1])])
    return _tabulated(curve, 0.5 * (forward.unresolved + backward.unresolved), points)


def _tabulated(curve: np.ndarray, unresolved: float, points: int) -> Side:
    """Return a direction of motion with entries that never fall with speed."""
    rising = without_fall(curve)
    return Side(curve, rising[placed(rising, points)], unresolved)


def losses(
    model: Model, forward: Side, backward: Side, effort: DriveUnit, *, symmetric: bool
) -> tuple[str, ...]:
    """Return the losses of a table, one sentence each."""
    deviation = effort.of(max(forward.deviation, backward.deviation))
    falls = any(np.any(np.diff(side.curve[:, 1]) < 0.0) for side in (forward, backward))
    off = f"differ from the steady friction of the model by at most {deviation:.2g} {effort.name}"
    reason = ""
    if falls:
        reason = ": the table leaves out friction that falls with speed, which pushes too much at a start or stop"
    notes = [f"straight lines between the entries {off}{reason}"]
    notes += memory_lost(model, forward.entries, backward.entries, effort)
    if symmetric:
        constant = offset_of(model.component.variables, model.values)
        ahead = forward.curve
        back = backward.curve
        apart = np.interp(ahead[:, 0], back[:, 0], back[:, 1]) - ahead[:, 1] + 2.0 * constant
        wrong = 0.5 * effort.of(float(np.max(np.abs(apart))))
        if wrong > ROUNDING * effort.of(float(np.max(np.abs(ahead[:, 1])))):
            notes.append(
                f"the table is the same for both directions: it is wrong by up to {wrong:.3g} {effort.name} in each direction"
            )
        if constant:
            force = f"{effort.of(constant):.3g} {effort.name}"
            notes.append(
                f"the table does not contain the constant force of {force}: set this force separately in the drive"
            )
    return (*notes, *_variation_lost(model))


def level_losses(
    model: Model,
    curves: Mapping[float, np.ndarray],
    levels: LevelValues,
    effort: DriveUnit,
    *,
    turns: bool = False,
) -> tuple[str, ...]:
    """Return the losses of one level per direction, one sentence each; with `turns` the drive reverses the force gradually."""
    both, alone = (
        f"{effort.of(value):.2g} {effort.name}"
        for value in (levels.deviation, levels.deviation_of_levels)
    )
    head = (
        f"level plus viscous friction is at most {both} below the steady friction of the model, and never above it; "
        f"the level alone is at most {alone} below it"
    )
    jumps = ()
    if not turns:
        jumps = memory_lost(model, without_fall(curves[1.0]), without_fall(curves[-1.0]), effort)
    return (head, *jumps, *_variation_lost(model))


def memory_lost(
    model: Model, forward: np.ndarray, backward: np.ndarray, effort: DriveUnit
) -> list[str]:
    """Return a sentence on the distance of a reversal; empty for a model whose friction jumps, too."""
    distance = reversal_distance(model, float(forward[-1, 0]))
    if distance == 0.0:
        return []
    jump = effort.of(forward[0, 1] + backward[0, 1])
    x = unit_of("length", model.kind)
    return [
        f"the memory of the model is lost: at a reversal the compensation jumps by {jump:.3g} {effort.name}, but the force of "
        f"the model makes 95 % of this change over {distance:.2g} {x}"
    ]


def _variation_lost(model: Model) -> list[str]:
    varying = variations_of(model.component)
    if varying:
        return [
            f"the friction of the model varies with {', '.join(varying)}, but the table does not"
        ]
    return []


def said_of_units(axis: Axis | None, effort: DriveUnit) -> tuple[str, ...]:
    """Return a sentence on efforts that are not in percent of rated; empty if they are."""
    if axis is None:
        return ("no axis file was given, so the units are SI at the axis",)
    unrated = axis.rated is None and effort.name != "%"
    if unrated:
        return (f"the axis file has no rated effort: efforts are in {effort.name}, as in the log",)
    return ()


def error_on_log(request: Request, entries: Mapping[float, np.ndarray]) -> tuple[str, ...]:
    """Return a sentence on the error of a table against the model along the given log."""
    if request.log is None:
        return ()
    effort = log_units(request.axis, request.model.kind).effort
    treatment = request.info.get("treatment", {})
    scale = max(float(np.max(np.abs(side[:, 1]))) for side in entries.values())
    error = table_error(request.model, request.plant, request.log, request.axis, entries, treatment)
    largest, rms = (
        f"{effort.of(value if value > ROUNDING * scale else 0.0):.2g} {effort.name}"
        for value in error
    )
    own = request.log.origin.checksum in request.info.get("provenance", {}).values()
    source = "the log of the identification"
    if not own:
        source = printable(request.log.origin.name)
    return (f"largest error of the table against the model along {source}: {largest}, rms {rms}",)


def levels_and_curves(request: Request) -> tuple[dict[float, np.ndarray], LevelValues]:
    """Return the steady friction by direction, and its levels with viscous friction."""
    curves = {way: curve_of(request.model, way, request.speed)[0] for way in (1.0, -1.0)}
    return curves, levels_of(request.plant, request.model, curves)


def behind_comments(remarks: Iterable[str], *lines: str, mark: str = "#") -> str:
    """Return lines of a file below remarks as comments."""
    return "\n".join([*(f"{mark} {plain(remark)}" for remark in remarks), *lines, ""])


def rows_of(text: str) -> list[list[str]]:
    """Return the cells of a table without its comments and head."""
    return [line.split(",") for line in text.splitlines() if not line.startswith("#")][1:]


def _curve_text(
    sides: Sequence[Side], units: LogUnits, signs: tuple[float, float], remarks: Sequence[str]
) -> str:
    """Return a table over both directions as CSV with comments, velocity ascending."""
    forward, backward = sides
    rows = [(-v, -f) for v, f in backward.entries[::-1].tolist()] + forward.entries.tolist()
    if not signs[0] > 0.0:
        rows = rows[::-1]
    turned = [(signs[0] * v, signs[1] * f) for v, f in rows]
    lines = [f"{units.velocity.of(v):.9g},{units.effort.of(f):.9g}" for v, f in turned]
    return behind_comments(
        remarks, f"velocity [{units.velocity.name}],effort [{units.effort.name}]", *lines
    )


def last_direction(velocity: np.ndarray) -> np.ndarray:
    """Return the direction of motion at each sample: that of the last motion during rests, 0 before the first motion."""
    direction = direction_by("middle", velocity)
    return direction[np.maximum.accumulate(np.where(direction != 0.0, np.arange(velocity.size), 0))]


def direction_by(rest: str, velocity: np.ndarray) -> np.ndarray:
    """Return the direction of the output force at each sample; 0 is the mean of both directions, for rests under rule "middle"."""
    if rest == "held":
        return last_direction(velocity)
    return np.where(np.abs(velocity) > STILL, np.sign(velocity), 0.0)


def _values_text(
    levels: LevelValues, request: Request, units: TableUnits, remarks: Sequence[str]
) -> str:
    """Return gravity, level and viscous friction for each direction and, if known, the inertia, as CSV."""
    # Forward is the direction in which the position of the drive grows, and a positive effort moves it forward.
    named = {"gravity": levels.constant, "F+": levels.forward, "F-": levels.backward}
    slopes_of = {"D+": levels.viscous_forward, "D-": levels.viscous_backward}
    if not column_signs(request.axis)[0] > 0.0:
        named = {"gravity": -levels.constant, "F+": levels.backward, "F-": levels.forward}
        slopes_of = {"D+": levels.viscous_backward, "D-": levels.viscous_forward}
    rows = [(name, value, unit) for unit in units.efforts for name, value in named.items()]
    slopes = (
        DriveUnit(unit_of(VISCOUS, request.model.kind), 1.0),
        *drive_units(request.axis, request.model.kind).of(VISCOUS),
    )
    rows += [(name, value, unit) for unit in slopes for name, value in slopes_of.items()]
    if levels.inertia:
        rows += [("inertia", levels.inertia, unit) for unit in units.inertias]
    lines = [
        f"{name},{unit.of(value):.9g},{unit.name},{MEANINGS[name]}"
        for name, value, unit in rows
        if value is not None
    ]
    return behind_comments(remarks, "value,amount,unit,meaning", *lines)


def _drive_of_values(text: str, request: Request, units: TableUnits) -> Drive:
    """Return the force that a drive with a field for each value computes from gravity, levels and viscous friction."""
    kind = request.model.kind
    sign = column_signs(request.axis)[0]
    si_of = {
        unit.name: unit.si
        for unit in (*units.efforts, *drive_units(request.axis, kind).of(VISCOUS))
    }
    si_of[unit_of(VISCOUS, kind)] = 1.0
    values = {
        name: float(amount) * si_of[unit]
        for name, amount, unit, _ in rows_of(text)
        if unit in si_of
    }

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        velocity = sign * np.diff(x, prepend=x[:1]) / dt
        way = direction_by(request.rest, velocity)
        level = np.where(way > 0.0, values["F+"], np.where(way < 0.0, -values["F-"], 0.0))
        slope = np.where(velocity > 0.0, values.get("D+", 0.0), values.get("D-", 0.0))
        return sign * (values["gravity"] + level + slope * velocity)

    return drive
