"""FMUs for FMI 2.0, and what makes the target of either version."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from bristle.exports.target import Product, Request, Target

if TYPE_CHECKING:
    from bristle.exports.described import Source
    from bristle.exports.law import Law

__all__ = ["TARGET", "target_of"]


def write(request: Request, *, fmi: int) -> Product:
    """Return one FMU of the friction, and another one of friction and plant."""
    from bristle.exports.fmu import Setting, fmu_files

    setting = Setting(request.name, request.source, request.dt, fmi)
    return Product(*fmu_files(request.model, request.sampled, request.plant, setting))


def write_law(law: Law, name: str, source: Source, *, fmi: int) -> Product:
    """Return the FMU of a control law."""
    from bristle.exports.fmu import Setting, law_fmu_files

    return Product(*law_fmu_files(law, Setting(name, source, law.dt, fmi)))


def target_of(fmi: int) -> Target:
    """Return the target of a version of FMI."""
    return Target(
        name=f"fmu{fmi}",
        title=f"FMU {fmi}",
        write=partial(write, fmi=fmi),
        write_law=partial(write_law, fmi=fmi),
        rest="middle",
        tunable=True,
        needs="a compiler",
        description=f"FMUs for FMI {fmi}.0, of the friction and, where the model file has a plant, of both, for "
        "co-simulation and, where the model has continuous time, model exchange, with a library for each platform that "
        "there is a compiler for; of a control law, for co-simulation",
    )


TARGET = target_of(2)
