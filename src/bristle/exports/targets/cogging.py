"""Harmonics of cogging."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

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


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive | None:
    """Return what a drive computes from the harmonics."""
    from bristle.exports.cogging import drive_of_harmonics
    from bristle.prediction.drive_units import table_units

    if request.plant is None:
        return None
    effort = table_units(request.axis, request.model.kind).efforts[0]
    return drive_of_harmonics(str(files[f"{request.name}.csv"]), request.plant, effort)


TARGET = Target(
    name="cogging", write=write, reads=reads, pushes=True, of_cogging=True, description="harmonics of cogging, where they were identified"
)
