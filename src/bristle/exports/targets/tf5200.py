"""Friction compensation of a Beckhoff TF5200 CNC."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the list of compensation values."""
    import numpy as np

    from bristle.exports.drive import error_on_log, losses, mean_side, side_of
    from bristle.exports.effect_of import loop_for, samples_ahead
    from bristle.exports.tf5200 import ROUNDED, as_written, current_unit, delay_lost, merged, tf5200_text
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
        *losses(request.model, forward, backward, effort, symmetric=True),
        ROUNDED,
        *delay_lost(request.model, mean),
        *error_on_log(request, entries),
    )
    ahead = samples_ahead(loop_for(request))
    text = tf5200_text(request.model, mean, current, ahead, notes, request.source.lines)
    return Product({f"{request.name}.txt": text}, notes)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return what the control computes from the list."""
    from bristle.exports.tf5200 import current_unit, drive_of_list
    from bristle.prediction.drive_units import table_units

    effort = table_units(request.axis, request.model.kind).efforts[0]
    current = current_unit(request.axis, effort)
    return drive_of_list(str(files[f"{request.name}.txt"]), request.model.kind, current)


TARGET = Target(
    name="tf5200",
    title="Beckhoff TF5200",
    write=write,
    reads=reads,
    compares=True,
    pushes=True,
    description="the list of compensation values of the friction compensation of a Beckhoff TF5200 CNC; it takes the "
    "rated effort of the drive from AXIS.toml",
)
