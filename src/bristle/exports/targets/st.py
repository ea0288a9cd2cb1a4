"""Structured Text for a PLC."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.described import Source
    from bristle.exports.law import Law

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the function block, its self-test, and both as XML."""
    from bristle.exports.st import st_files
    from bristle.exports.st_names import checked
    from bristle.exports.subject import subject_of

    checked(request.name)
    files = st_files(subject_of(request.model), request.name, request.source, request.dt)
    return Product(dict(files), ("the sign of a velocity of -0.0 is lost: the language cannot tell it from 0.0",))


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
    write_law=write_law,
    operators=True,
    description="a function block in Structured Text for a PLC, its self-test, and both as XML of PLCopen",
)
