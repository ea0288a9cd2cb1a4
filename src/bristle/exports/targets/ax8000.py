"""Friction compensation of a Beckhoff AX8000 drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.effect import Drive

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the objects with their values."""
    from bristle.exports.ax8000 import ax8000_text, friction_of, sides_lost
    from bristle.exports.drive import curve_of, level_losses
    from bristle.prediction.drive_table import levels_of
    from bristle.prediction.drive_units import table_units

    curves = {way: curve_of(request.model, way, request.speed) for way in (1.0, -1.0)}
    levels = levels_of(request.plant, request.model, curves)
    effort = table_units(request.axis, request.model.kind).efforts[0]
    friction = friction_of(request.model, levels, request.speed)
    notes = (
        *level_losses(request.model, curves, levels, effort, turns=friction.spring > 0.0),
        *sides_lost(levels, effort.name, effort.si),
        *_said_of_spring(friction.spring),
    )
    text = ax8000_text(friction, request.axis, request.model.kind, (*request.source.lines, *notes))
    return Product({f"{request.name}.csv": text}, notes)


def _said_of_spring(spring: float) -> tuple[str, ...]:
    if spring:
        return ("0x3144:01 turns 95 % of the friction over the distance of the model; that it does is not documented",)
    return ("0x3144:01 is not written: the model turns at once, and what the drive does with 0 is not documented",)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive:
    """Return what the drive computes from the objects."""
    from bristle.exports.ax8000 import drive_of_objects

    return drive_of_objects(str(files[f"{request.name}.csv"]), request.axis)


TARGET = Target(
    name="ax8000",
    title="Beckhoff AX8000",
    write=write,
    reads=reads,
    pushes=True,
    description="static and dynamic friction of a Beckhoff AX8000 or AMP8000 drive, objects 0x3144:02 and :03, and its "
    "spring rate, :01, where the model knows it",
)
