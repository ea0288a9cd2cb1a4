"""Start values for the friction compensation of a SINUMERIK."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the machine data."""
    from bristle.exports.drive import curve_of, memory_lost
    from bristle.exports.sinumerik import sinumerik_text, start_values
    from bristle.prediction.drive_units import table_units

    forward, backward = [curve_of(request.model, way, request.speed) for way in (1.0, -1.0)]
    values = start_values(request.axis, float(forward[0, 1] + backward[0, 1]))
    effort = table_units(request.axis, request.model.kind).efforts[0]
    notes = ("start values, to be tuned by the circularity test", *memory_lost(request.model, forward, backward, effort))
    return Product({f"{request.name}.txt": sinumerik_text(request.model, values, notes, request.source.lines)}, notes)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive | None:
    """Return the effort that the pulses command: what they do is known in a loop alone."""
    from bristle.exports.effect_of import loop_for
    from bristle.exports.sinumerik import drive_of_data

    if request.axis is None or loop_for(request) is None:
        return None
    return drive_of_data(str(files[f"{request.name}.txt"]), request.axis, request.model.kind)


TARGET = Target(
    name="sinumerik",
    title="SINUMERIK",
    write=write,
    reads=reads,
    pushes=True,
    description="start values for the friction compensation of a SINUMERIK, to be tuned by the circularity test",
)
