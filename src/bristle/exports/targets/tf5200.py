"""Friction compensation of a Beckhoff TF5200 CNC."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the list of compensation values."""
    import numpy as np

    from bristle.exports.drive import error_on_log, levels_unseen, losses, mean_side, said_of_units, side_of
    from bristle.exports.tf5200 import as_written, current_unit, delay_lost, merged, rounding_lost, tf5200_text
    from bristle.identification.parameters import offset_of
    from bristle.prediction.drive_units import table_units

    forward, backward = [side_of(request.model, way, request.speed, request.points) for way in (1.0, -1.0)]
    effort = table_units(request.axis, request.model.kind).efforts[0]
    constant = offset_of(request.model.component.variables, request.model.values)
    current = current_unit(request.axis, effort)
    mean = merged(mean_side(forward, backward, request.points), current, request.model.kind)
    written = as_written(mean.entries, current, request.model.kind)
    entries = {way: written + np.array([0.0, way * constant]) for way in (1.0, -1.0)}
    notes = (
        *levels_unseen(request.model, request.source),
        *losses(request.model, forward, backward, effort, symmetric=True), *rounding_lost(current),
        *delay_lost(request.model, mean), *error_on_log(request, entries), *said_of_units(request.axis, effort),
    )  # fmt: skip
    text = tf5200_text(request.model, mean, current, notes, request.source.lines)
    return Product({f"{request.name}.txt": text}, notes)


TARGET = Target(
    name="tf5200",
    title="Beckhoff TF5200",
    write=write,
    compares=True,
    description="the list of compensation values of the friction compensation of a Beckhoff TF5200 CNC",
)
