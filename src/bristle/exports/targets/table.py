"""Effort over velocity as a table, or gravity and two levels."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]

VALUES, FEWEST = 3, 4  # points that are gravity and two levels; the fewest of a table


def write(request: Request) -> Product:
    """Return a curve, or gravity, two levels and the inertia."""
    from bristle.core.errors import InputError
    from bristle.exports.drive import error_on_log, levels_unseen, losses, said_of_units, side_of, table_text
    from bristle.prediction.drive_units import table_units

    if request.points == VALUES:
        return _values(request)
    if request.points < FEWEST:
        raise InputError("out of range", path="points", value=request.points, allowed=f"{VALUES} or more")
    sides = {way: side_of(request.model, way, request.speed, request.points // 2) for way in (1.0, -1.0)}
    units = table_units(request.axis, request.model.kind)
    effort, entries = units.efforts[0], {way: side.entries for way, side in sides.items()}
    notes = (
        *levels_unseen(request.model, request.source),
        *losses(request.model, sides[1.0], sides[-1.0], effort, symmetric=False), *error_on_log(request, entries),
        *said_of_units(request.axis, effort),
    )  # fmt: skip
    files: dict[str, str | bytes] = {f"{request.name}.csv": table_text(sides[1.0], sides[-1.0], units.log)}
    if units.drive is not None:
        files[f"{request.name}_drive.csv"] = table_text(sides[1.0], sides[-1.0], units.drive)
        notes = (*notes, f"{request.name}_drive.csv: {units.drive.effort.name} over {units.drive.velocity.name}")
    return Product(files, notes)


def _values(request: Request) -> Product:
    """Return gravity, one level for each direction, and the inertia."""
    import numpy as np

    from bristle.exports.drive import curve_of, error_on_log, level_losses, levels_unseen, said_of_units, values_text
    from bristle.prediction.drive_table import levels_of
    from bristle.prediction.drive_units import table_units

    curves = {way: curve_of(request.model, way, request.speed) for way in (1.0, -1.0)}
    levels = levels_of(request.plant, request.model, curves)
    units = table_units(request.axis, request.model.kind)
    effort = units.efforts[0]
    forces = {1.0: (levels.forward or 0.0) + levels.constant, -1.0: (levels.backward or 0.0) - levels.constant}
    flat = {way: np.array([[0.0, force]]) for way, force in forces.items()}
    notes = (
        *levels_unseen(request.model, request.source),
        *level_losses(request.model, curves, levels, effort), *error_on_log(request, flat),
        *(() if levels.inertia else ("the inertia is not known: the model file has no plant with one",)),
        *said_of_units(request.axis, effort),
    )  # fmt: skip
    text = values_text(levels, units, inertia=bool(levels.inertia))
    return Product({f"{request.name}.csv": text}, notes)


TARGET = Target(
    name="table",
    title="table for a drive",
    write=write,
    compares=True,
    description="effort over velocity as CSV, in the units of the log and of the drive that AXIS.toml describes; with "
    "--points 3, gravity, a level for each direction and the inertia",
)
