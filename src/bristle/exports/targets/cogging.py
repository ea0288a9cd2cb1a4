"""Harmonics of cogging."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the harmonics."""
    from bristle.exports.cogging import cogging_notes, cogging_text, waves_of
    from bristle.exports.drive import said_of_units
    from bristle.prediction.drive_units import table_units

    waves = waves_of(request.plant)
    efforts = table_units(request.axis, request.model.kind).efforts
    notes = (*cogging_notes(waves, efforts[0]), *said_of_units(request.axis, efforts[0]))
    return Product({f"{request.name}.csv": cogging_text(waves, efforts, notes, request.source.lines)}, notes)


TARGET = Target(
    name="cogging",
    write=write,
    description="harmonics of cogging, where they were identified",
)
