"""The targets that a model can be exported to, and what each writes."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import Experiment, Variant
from bristle.core.typography import printable
from bristle.exports.described import Source
from bristle.exports.names import RESERVED

if TYPE_CHECKING:
    from bristle.exports.law import Law
    from bristle.logs.log import Log

__all__ = ["TARGETS", "Product", "Request", "files_for", "law_for", "name_for", "variant_of"]

NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")
DUST = 1e-9  # of the largest force: a difference that is none
VALUES, FEWEST = 3, 4  # points that are gravity and two levels; the fewest of a table


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
        Entries of a table, at most; 3 of a ``table`` are gravity and one level for each direction.
    mass : float
        What a scene moves [kg or kg*m^2].
    plant : Model or None
        What the friction is on, where it is known.
    log : Log or None
        Along whose motion a table is compared with the model.
    info : mapping
        What a model file tells besides: ``provenance``, which log it was fitted to, and how that was treated,
        ``treatment``.
    draws : int
        How many draws of what was identified.
    drawn : mapping of str to ndarray
        Those that the identification left, by name of a parameter.
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
    log: Log | None = None
    info: Mapping[str, Any] = field(default_factory=dict)
    draws: int = 0
    drawn: Mapping[str, np.ndarray] = field(default_factory=dict)


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


def _cuda(request: Request) -> Product:
    from bristle.exports.cuda import cuda_files
    from bristle.exports.subject import subject_of

    files, notes = cuda_files(subject_of(request.model), request.name, request.source, request.dt)
    return Product(dict(files), notes)


def _st(request: Request) -> Product:
    from bristle.exports.st import st_files
    from bristle.exports.st_names import checked
    from bristle.exports.subject import subject_of

    checked(request.name)
    files = st_files(subject_of(request.model), request.name, request.source, request.dt)
    return Product(dict(files), ("the sign of a velocity of -0.0 is lost: the language cannot tell it from 0.0",))


def _table(request: Request) -> Product:
    from bristle.exports.drive import levels_unseen, losses, said_of_units, side_of, table_text
    from bristle.prediction.drive_units import table_units

    if request.points == VALUES:
        return _values(request)
    if request.points < FEWEST:
        raise InputError("out of range", path="points", value=request.points, allowed=f"{VALUES} or more")
    sides = {way: side_of(request.model, way, request.speed, request.points // 2) for way in (1.0, -1.0)}
    units = table_units(request.axis, request.model.kind)
    effort, entries = units.efforts[0], {way: side.entries for way, side in sides.items()}
    notes = (
        *levels_unseen(request.model, request.source),
        *losses(request.model, sides[1.0], sides[-1.0], effort, symmetric=False), *_error_on_log(request, entries),
        *said_of_units(request.axis, effort),
    )  # fmt: skip
    files: dict[str, str | bytes] = {f"{request.name}.csv": table_text(sides[1.0], sides[-1.0], units.log)}
    if units.drive is not None:
        files[f"{request.name}_drive.csv"] = table_text(sides[1.0], sides[-1.0], units.drive)
        notes = (*notes, f"{request.name}_drive.csv: {units.drive.effort.name} over {units.drive.velocity.name}")
    return Product(files, notes)


def _values(request: Request) -> Product:
    """Return gravity, one level for each direction, and the inertia."""
    from bristle.exports.drive import curve_of, level_losses, levels_unseen, said_of_units, values_text
    from bristle.prediction.drive_table import levels_of
    from bristle.prediction.drive_units import table_units

    curves = {way: curve_of(request.model, way, request.speed) for way in (1.0, -1.0)}
    levels = levels_of(request.plant, request.model, curves)
    units = table_units(request.axis, request.model.kind)
    effort = units.efforts[0]
    forces = {1.0: (levels.forward or 0.0) + levels.constant, -1.0: (levels.backward or 0.0) - levels.constant}
    flat = {way: np.array([[0.0, force]]) for way, force in forces.items()}
    notes = (
        *levels_unseen(request.model, request.source),
        *level_losses(request.model, curves, levels, effort), *_error_on_log(request, flat),
        *(() if levels.inertia else ("the inertia is not known: the model file has no plant with one",)),
        *said_of_units(request.axis, effort),
    )  # fmt: skip
    text = values_text(levels, units, inertia=bool(levels.inertia))
    return Product({f"{request.name}.csv": text}, notes)


def _tf5200(request: Request) -> Product:
    from bristle.exports.drive import levels_unseen, losses, mean_side, said_of_units, side_of
    from bristle.exports.tf5200 import as_written, current_unit, rounding_lost, tf5200_text
    from bristle.identification.roles import offset_of
    from bristle.prediction.drive_units import table_units

    forward, backward = [side_of(request.model, way, request.speed, request.points) for way in (1.0, -1.0)]
    mean = mean_side(forward, backward, request.points)
    effort = table_units(request.axis, request.model.kind).efforts[0]
    constant = offset_of(request.model.component.variables, request.model.values)
    current = current_unit(request.axis, effort)
    written = as_written(mean.entries, current, request.model.kind)
    entries = {way: written + np.array([0.0, way * constant]) for way in (1.0, -1.0)}
    notes = (
        *levels_unseen(request.model, request.source),
        *losses(request.model, forward, backward, effort, symmetric=True), *rounding_lost(current),
        *_error_on_log(request, entries), *said_of_units(request.axis, effort),
    )  # fmt: skip
    text = tf5200_text(request.model, mean, current, notes, request.source.lines)
    return Product({f"{request.name}.txt": text}, notes)


def _sinumerik(request: Request) -> Product:
    from bristle.exports.drive import curve_of, levels_unseen, memory_lost
    from bristle.exports.sinumerik import sinumerik_text, start_values
    from bristle.prediction.drive_units import table_units

    forward, backward = [curve_of(request.model, way, request.speed) for way in (1.0, -1.0)]
    values = start_values(request.axis, float(forward[0, 1] + backward[0, 1]))
    effort = table_units(request.axis, request.model.kind).efforts[0]
    notes = (
        *levels_unseen(request.model, request.source),
        "start values, to be tuned by the circularity test",
        *memory_lost(request.model, forward, backward, effort),
    )
    return Product({f"{request.name}.txt": sinumerik_text(request.model, values, notes, request.source.lines)}, notes)


def _cogging(request: Request) -> Product:
    from bristle.exports.cogging import cogging_notes, cogging_text, waves_of
    from bristle.exports.drive import said_of_units
    from bristle.prediction.drive_units import table_units

    waves = waves_of(request.plant)
    efforts = table_units(request.axis, request.model.kind).efforts
    notes = (*cogging_notes(waves, efforts[0]), *said_of_units(request.axis, efforts[0]))
    return Product({f"{request.name}.csv": cogging_text(waves, efforts, notes, request.source.lines)}, notes)


def _error_on_log(request: Request, entries: Mapping[float, np.ndarray]) -> tuple[str, ...]:
    """Return how far a table is from the model along the log that was given, in a sentence."""
    if request.log is None:
        return ()
    from bristle.prediction.drive_units import log_units
    from bristle.prediction.table_error import table_error

    effort, treatment = log_units(request.axis, request.model.kind).effort, request.info.get("treatment", {})
    scale = max(float(np.max(np.abs(side[:, 1]))) for side in entries.values())
    error = table_error(request.model, request.plant, request.log, request.axis, entries, treatment)
    largest, rms = (f"{effort.of(value if value > DUST * scale else 0.0):.2g} {effort.name}" for value in error)
    own = request.log.origin.checksum in request.info.get("provenance", {}).values()
    which = "its own log" if own else printable(request.log.origin.name)
    return (f"largest error of the table against the model on {which} {largest}; {rms} root mean square",)


def _mjcf(request: Request) -> Product:
    from bristle.exports.mjcf import mjcf_notes, mjcf_text

    text = mjcf_text(request.model, request.name, request.source, request.mass)
    return Product({f"{request.name}.xml": text}, mjcf_notes(request.model))


def _draws(request: Request) -> Product:
    from bristle.exports.draws import draws_files

    return Product(*draws_files(request.model, request.plant, request.drawn, request.draws or DRAWS, request.name))


def _fmu(request: Request, fmi: int) -> Product:
    from bristle.exports.fmu import Setting, fmu_files

    setting = Setting(request.name, request.source, request.dt, fmi)
    return Product(*fmu_files(request.model, request.plant, setting))


def _law_in_c(law: Law, name: str, source: Source) -> dict[str, str | bytes]:
    from bristle.exports.c_law import law_files

    return dict(law_files(law, name, source))


def _law_in_st(law: Law, name: str, source: Source) -> dict[str, str | bytes]:
    from bristle.exports.st_law import st_law_files
    from bristle.exports.st_names import checked

    checked(name)
    return dict(st_law_files(law, name, source))


LAWS: dict[str, Callable[[Law, str, Source], dict[str, str | bytes]]] = {"c": _law_in_c, "st": _law_in_st}
TARGETS: dict[str, Callable[[Request], Product]] = {
    "c": _c, "wasm": _wasm, "st": _st, "cuda": _cuda, "table": _table, "tf5200": _tf5200,
    "sinumerik": _sinumerik, "cogging": _cogging, "mjcf": _mjcf, "draws": _draws,
    "fmu2": partial(_fmu, fmi=2), "fmu3": partial(_fmu, fmi=3),
}  # fmt: skip
"""What writes each target."""
ONLY_C = ("c",)
OPERATORS = ("c", "st", "cuda")
TUNABLE = ("c", "fmu2", "fmu3")
TABLES = ("table", "tf5200")
DRAWS = 1000


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
    if request.log is not None and target not in TABLES:
        raise InputError("is no table that could be compared on a log", path=target, allowed=", ".join(TABLES),
                         mend="Leave the log out")  # fmt: skip
    if request.draws and target != "draws":
        raise InputError("holds one model, not draws of it", path=target, allowed="draws", mend="Leave draws out")
    if request.model.component.family == "hysteresis" and target not in OPERATORS:
        raise InputError("holds no hysteresis operator", path=target, value=request.model.name,
                         allowed=", ".join(OPERATORS))  # fmt: skip
    return TARGETS[target](request)


def law_for(target: str, variant: Variant, name: str, source: Source) -> Product:
    """Return the files of the control law of a variant for a target.

    Raises
    ------
    InputError
        If the target holds no law, or the variant has none that can be exported.
    """
    from bristle.exports.law import law_of

    if target not in LAWS:
        raise InputError("holds no control law", path="to", value=target, allowed=", ".join(LAWS))
    law = law_of(variant)
    ahead = [name for name in law.inputs if name.endswith("_ahead")]
    samples = f"the next {law.samples_ahead} samples" if law.samples_ahead > 1 else "the next sample"
    note = f"the law is told {samples} of the desired motion: {', '.join(ahead)}"
    return Product(LAWS[target](law, name, source), (note,) if ahead else ())


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
