"""C99: a source that compiles alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.described import Source
    from bristle.exports.law import Law

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the source, in double precision or in single."""
    from bristle.exports.c import c_files
    from bristle.exports.subject import subject_of
    from bristle.prediction.drive_units import command_units

    units = command_units(request.axis, request.model.kind) if request.model.component.family == "friction" else None
    if not request.single:
        subject = subject_of(request.sampled)
        files = c_files(subject, request.name, request.source, request.dt, tunable=request.tunable, units=units)
        return Product(dict(files))
    from bristle.exports.single import CONSTANTS, single_note

    subject = subject_of(request.sampled, CONSTANTS)
    files = c_files(subject, request.name, request.source, request.dt, tunable=request.tunable, single=True, units=units)
    return Product(dict(files), (single_note("force"),))


def write_law(law: Law, name: str, source: Source) -> dict[str, str | bytes]:
    """Return the files of a control law."""
    from bristle.exports.c_law import law_files

    return dict(law_files(law, name, source))


TARGET = Target(
    name="c",
    title="C",
    write=write,
    rest="held",
    pushes=True,
    write_law=write_law,
    tunable=True,
    single=True,
    operators=True,
    description="C99: a header, a source that compiles alone, an example, and a self-test that proves that the target "
    "gives the same bits; nothing is compiled here, and no compiler is needed",
)
