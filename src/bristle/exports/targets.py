"""The targets that a model can be exported to, and what each writes."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import Experiment, Variant
from bristle.exports.described import Source
from bristle.exports.names import RESERVED

__all__ = ["TARGETS", "Product", "Request", "files_for", "law_for", "name_for", "variant_of"]

NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")


@dataclass(frozen=True)
class Request:
    """What is to be exported, and how.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    name : str
        What files, types and functions are called.
    dt : float
        Time step [s].
    source : Source
        Where the values come from.
    tunable : bool
        Whether parameters may be changed at run time.
    single : bool
        Whether numbers are of single precision.
    axis : Axis or None
        The axis, whose columns tell the units of a table.
    speed : float
        Largest speed of a table [m/s or rad/s].
    points : int
        Entries of a table for each direction, at most.
    mass : float
        What a scene moves [kg or kg*m^2].
    plant : Model or None
        What the friction is on, where it is known.
    """

    model: Model
    name: str
    dt: float
    source: Source = field(default_factory=Source)
    tunable: bool = False
    single: bool = False
    axis: Axis | None = None
    speed: float = 0.0
    points: int = 20
    mass: float = 1.0
    plant: Model | None = None


@dataclass(frozen=True)
class Product:
    """The files of an export.

    Parameters
    ----------
    files : dict of str to str or bytes
        Content by name.
    notes : tuple of str
        What the target loses or does otherwise, a sentence each.
    """

    files: dict[str, str | bytes]
    notes: tuple[str, ...] = ()


def _c(request: Request) -> Product:
    from bristle.exports.c import c_files
    from bristle.exports.subject import subject_of

    if not request.single:
        subject = subject_of(request.model)
        return Product(dict(c_files(subject, request.name, request.source, request.dt, tunable=request.tunable)))
    from bristle.exports.single import CONSTANTS, TOLERANCE

    subject = subject_of(request.model, CONSTANTS)
    files = c_files(subject, request.name, request.source, request.dt, tunable=request.tunable, single=True)
    note = f"single precision: not the bits of bristle; the self-test allows {TOLERANCE:g} of the largest force"
    return Product(dict(files), (note,))


def _wasm(request: Request) -> Product:
    from bristle.exports.subject import subject_of
    from bristle.exports.wasm import wasm_files

    return Product(wasm_files(subject_of(request.model), request.name, request.source))


def _table(request: Request) -> Product:
    from bristle.exports.drive import losses, side_of, table_text
    from bristle.prediction.drive_units import log_units

    forward, backward = [side_of(request.model, way, request.speed, request.points) for way in (1.0, -1.0)]
    scale = log_units(request.axis, request.model.kind)
    notes = losses(request.model, forward, backward, scale, symmetric=False)
    return Product({f"{request.name}.csv": table_text(forward, backward, scale)}, notes)


def _tf5200(request: Request) -> Product:
    from bristle.exports.drive import losses, mean_side, side_of, tf5200_text
    from bristle.prediction.drive_units import log_units

    forward, backward = [side_of(request.model, way, request.speed, request.points) for way in (1.0, -1.0)]
    mean = mean_side(forward, backward, request.points)
    scale = log_units(request.axis, request.model.kind)
    notes = losses(request.model, forward, backward, scale, symmetric=True)
    return Product({f"{request.name}.txt": tf5200_text(request.model, mean, scale, notes, request.source.lines)}, notes)


def _mjcf(request: Request) -> Product:
    from bristle.exports.mjcf import mjcf_notes, mjcf_text

    text = mjcf_text(request.model, request.name, request.source, request.mass)
    return Product({f"{request.name}.xml": text}, mjcf_notes(request.model))


def _fmu(request: Request, fmi: int) -> Product:
    from bristle.exports.fmu import Setting, fmu_files

    setting = Setting(request.name, request.source, request.dt, fmi)
    return Product(*fmu_files(request.model, request.plant, setting))


TARGETS: dict[str, Callable[[Request], Product]] = {
    "c": _c, "wasm": _wasm, "table": _table, "tf5200": _tf5200, "mjcf": _mjcf,
    "fmu2": partial(_fmu, fmi=2), "fmu3": partial(_fmu, fmi=3),
}  # fmt: skip
"""What writes each target."""
ONLY_C = ("c",)
TUNABLE = ("c", "fmu2", "fmu3")


def files_for(target: str, request: Request) -> Product:
    """Return the files of a model for a target.

    Raises
    ------
    InputError
        If there is no such target, or it does not hold what is asked for.
    """
    if target not in TARGETS:
        raise InputError("no such target", path="to", value=target, allowed=", ".join(TARGETS),
                         mend=did_you_mean(target, TARGETS))  # fmt: skip
    if request.tunable and target not in TUNABLE:
        raise InputError("has no parameters that may be changed at run time", path=target,
                         allowed=", ".join(TUNABLE), mend="Leave tunable out")  # fmt: skip
    if request.single and target not in ONLY_C:
        raise InputError("is not written in single precision", path=target, allowed=", ".join(ONLY_C),
                         mend="Leave float32 out")  # fmt: skip
    if request.model.component.family == "hysteresis" and target not in ONLY_C:
        raise InputError("holds no hysteresis operator", path=target, value=request.model.name,
                         allowed=", ".join(ONLY_C))  # fmt: skip
    return TARGETS[target](request)


def law_for(target: str, variant: Variant, name: str, source: Source) -> Product:
    """Return the files of the control law of a variant for a target.

    Raises
    ------
    InputError
        If the target holds no law, or the variant has none that can be exported.
    """
    from bristle.exports.c_law import law_files
    from bristle.exports.law import law_of

    if target not in ONLY_C:
        raise InputError("holds no control law", path="to", value=target, allowed=", ".join(ONLY_C))
    law = law_of(variant)
    ahead = [name for name in law.inputs if name.endswith("_ahead")]
    samples = f"the next {law.samples_ahead} samples" if law.samples_ahead > 1 else "the next sample"
    note = f"the law is told {samples} of the desired motion: {', '.join(ahead)}"
    return Product(dict(law_files(law, name, source)), (note,) if ahead else ())


def variant_of(experiment: Experiment, name: str | None) -> Variant:
    """Return the variant of this name; the only one where none is named.

    Raises
    ------
    InputError
        If there is no such variant, or several and none is named.
    """
    variants = {variant.name: variant for variant in experiment.variants}
    if name is None and len(variants) == 1:
        return experiment.variants[0]
    if name not in variants:
        reason = "must be named: the experiment has several" if name is None else "is not in the experiment"
        raise InputError(reason, path="variant", value=name or "", allowed=", ".join(variants),
                         mend=did_you_mean(name, variants) if name else "")  # fmt: skip
    return variants[name]


def name_for(text: str) -> str:
    """Return a name that files, types and functions can have.

    Raises
    ------
    InputError
        If they cannot.
    """
    if not NAME.fullmatch(text) or text in RESERVED:
        raise InputError("cannot be the name of a function", path="name", value=text,
                         allowed="small letters, digits and _, a letter first, no word of C")  # fmt: skip
    return text
