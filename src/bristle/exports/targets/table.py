"""Effort over velocity as a table, or gravity, two levels and viscous friction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

__all__ = ["TARGET"]

VALUES, FEWEST = 3, 4  # points that are gravity, levels and viscous friction; the fewest of a table


def write(request: Request) -> Product:
    """Return a curve, or gravity, level and viscous friction for each direction, and the inertia."""
    from bristle.core.errors import InputError
    from bristle.exports.drive import AT_REST, MOST, error_on_log, losses, said_of_units, side_of, table_text
    from bristle.prediction.drive_units import column_signs, table_units

    if request.points == VALUES:
        return _values(request)
    if not FEWEST <= request.points <= 2 * MOST:
        raise InputError("out of range", path="points", value=request.points, allowed=f"{VALUES} to {2 * MOST}")
    sides = {way: side_of(request.model, way, request.speed, request.points // 2) for way in (1.0, -1.0)}
    units, signs = table_units(request.axis, request.model.kind), column_signs(request.axis)
    effort, entries = units.efforts[0], {way: side.entries for way, side in sides.items()}
    notes = (
        AT_REST["table", request.rest],
        *_said_of_sign(signs),
        *losses(request.model, sides[1.0], sides[-1.0], effort, symmetric=False),
        *error_on_log(request, entries),
        *said_of_units(request.axis, effort),
    )
    head = (*request.source.lines, *notes)
    files: dict[str, str | bytes] = {f"{request.name}.csv": table_text(sides[1.0], sides[-1.0], units.log, signs, head)}
    if units.drive is not None:
        # A drive counts effort as it counts positions; a column of the log may run against both.
        own = (signs[0], signs[0])
        files[f"{request.name}_drive.csv"] = table_text(sides[1.0], sides[-1.0], units.drive, own, head)
        notes = (*notes, f"{request.name}_drive.csv: {units.drive.effort.name} over {units.drive.velocity.name}")
    return Product(files, notes)


def _said_of_sign(signs: tuple[float, float]) -> tuple[str, ...]:
    if signs[0] * signs[1] > 0.0:
        return ()
    return ("the effort column of the log runs against its position column, and so does the table in its units",)


def _values(request: Request) -> Product:
    """Return gravity, level and viscous friction for each direction, and the inertia."""
    import numpy as np

    from bristle.exports.drive import AT_REST, curve_of, error_on_log, level_losses, said_of_units, values_text
    from bristle.prediction.drive_table import levels_of
    from bristle.prediction.drive_units import table_units

    curves = {way: curve_of(request.model, way, request.speed) for way in (1.0, -1.0)}
    levels = levels_of(request.plant, request.model, curves)
    units = table_units(request.axis, request.model.kind)
    effort, fastest = units.efforts[0], request.speed
    slopes = {1.0: levels.viscous_forward or 0.0, -1.0: levels.viscous_backward or 0.0}
    forces = {1.0: (levels.forward or 0.0) + levels.constant, -1.0: (levels.backward or 0.0) - levels.constant}
    lines = {way: np.array([[0.0, force], [fastest, force + slopes[way] * fastest]]) for way, force in forces.items()}
    notes = (
        AT_REST["levels", request.rest],
        *level_losses(request.model, curves, levels, effort),
        *error_on_log(request, lines),
        *(() if levels.inertia else ("the inertia is not known: the model file has no plant with one",)),
        *said_of_units(request.axis, effort),
    )
    head = (*request.source.lines, *notes)
    return Product({f"{request.name}.csv": values_text(levels, request, units, head, inertia=bool(levels.inertia))}, notes)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return what a drive computes from the file in the units of the drive, or of the log where those are all."""
    from bristle.exports.drive import drive_of_table, drive_of_values
    from bristle.prediction.drive_units import column_signs, table_units

    units, signs = table_units(request.axis, request.model.kind), column_signs(request.axis)
    rest = request.rest
    if request.points == VALUES:
        return drive_of_values(str(files[f"{request.name}.csv"]), request, units)
    if units.drive is not None:
        return drive_of_table(str(files[f"{request.name}_drive.csv"]), units.drive, (signs[0], signs[0]), rest)
    return drive_of_table(str(files[f"{request.name}.csv"]), units.log, signs, rest)


TARGET = Target(
    name="table",
    title="table for a drive",
    write=write,
    reads=reads,
    compares=True,
    rest="held",
    pushes=True,
    description="effort over velocity as CSV, in the units of the log and of the drive that AXIS.toml describes; with "
    "--points 3, gravity, level and viscous friction for each direction, and the inertia",
)
