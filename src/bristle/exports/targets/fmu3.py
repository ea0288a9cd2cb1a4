"""FMUs for FMI 3.0."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return one FMU of the friction, and another one of friction and plant."""
    from bristle.exports.fmu import Setting, fmu_files

    setting = Setting(request.name, request.source, request.dt, fmi=3)
    return Product(*fmu_files(request.model, request.plant, setting))


TARGET = Target(
    name="fmu3",
    title="FMU 3",
    write=write,
    tunable=True,
    needs="a compiler",
    description="FMUs for FMI 3.0, of the friction and, where the model file has a plant, of both, with a library for "
    "each platform that there is a compiler for",
)
