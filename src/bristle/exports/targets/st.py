"""Structured Text for a PLC."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.described import Source
    from bristle.exports.law import Law

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the function block, its self-test, both as XML, and as files of TwinCAT 3."""
    from bristle.exports.single import CONSTANTS, single_note
    from bristle.exports.st import OUT, st_files
    from bristle.exports.st_names import checked
    from bristle.exports.subject import subject_of
    from bristle.prediction.drive_units import command_units

    checked(request.name)
    subject = subject_of(request.sampled, CONSTANTS if request.single else None)
    units = command_units(request.axis, request.model.kind) if not subject.is_operator else None
    files = st_files(subject, request.name, request.source, request.dt, tunable=request.tunable, single=request.single, units=units)
    notes = ["the sign of a velocity of -0.0 is lost: the language cannot tell it from 0.0"]
    notes += [single_note(OUT[subject.is_operator])] if request.single else []
    return Product(dict(files), tuple(notes))


def write_law(law: Law, name: str, source: Source) -> dict[str, str | bytes]:
    """Return the files of a control law."""
    from bristle.exports.st_law import st_law_files
    from bristle.exports.st_names import checked

    checked(name)
    return dict(st_law_files(law, name, source))


TARGET = Target(
    name="st",
    title="Structured Text",
    write=write,
    rest="held",
    pushes=True,
    write_law=write_law,
    tunable=True,
    single=True,
    operators=True,
    description="a function block in Structured Text for a PLC, its self-test, and both as XML of PLCopen and as files of TwinCAT 3",
)
