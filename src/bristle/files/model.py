"""Model files: a plant and a friction model with their values, uncertainties and provenance."""

import inspect
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, Readable, Slot, content_of, located
from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.edge import array, guarded, many, mapping, model, optional
from bristle.core.experiment import COUPLING
from bristle.core.values import Converter
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.components import (
    check_keys,
    check_schema,
    key_of,
    kind_at,
    model_from,
    numbers_in,
    parameters_in,
    table_at,
)
from bristle.files.operator import OperatorRead, described, operator_beside, with_operator
from bristle.files.permission import CodeRead, code_named
from bristle.files.single import write_whole
from bristle.files.toml import Said, as_toml, read_toml
from bristle.models.friction import (
    CHANNEL_SLOTS,
    MODELS,
    base_of,
    channel_slots_of,
    find,
    with_slots,
)
from bristle.models.plants import PLANTS, find as find_plant

# Key of the provenance: the `digest` of the friction in the simulation that made the log.
FITTED_TO = "fitted to"

KEYS = (
    "schema",
    "kind",
    "provenance",
    "treatment",
    "coupling",
    "plant",
    "friction",
    "uncertainty",
    "bands",
)
# Data of the identification of a model, such as cut-off, delay and lag, each with its description.
TREATMENT = {
    "cutoff": Variable(
        "frequency", "cut-off of the zero-phase filter of the identification", min=1e-9
    ),
    "decimation": Variable("1", "samples per row of the identification", min=1.0),
    "velocity_max": Variable("length/time", "largest speed in the fit of the model", min=0.0),
    "delay": Variable("time", "delay of the effort relative to the position in the log"),
    "smoothing": Variable(
        "time", "time constant of an additional filter of the effort relative to the position"
    ),
    "position_smoothing": Variable("time", "time constant of a filter of the position", min=0.0),
    "slow": Variable("frequency", "cut-off of the instruments of the recorded channels", min=0.0),
    "lag": Variable("time", "time constant with which the drive follows its controller", min=0.0),
    "stiffness": Variable(
        "force/length", "stiffness of the position loop that made the log", min=0.0
    ),
    "stiffness_half_width": Variable(
        "force/length", "half-width of the 95 % interval of this stiffness", min=0.0
    ),
}

NUMBERS = {
    "scatter": Variable("1", "relative variation of the friction level between reversals", min=0.0),
    "noise": Variable("force", "noise of the effort per sample", min=0.0),
    "unexplained": Variable("force", "residual beyond noise, encoder and scatter", min=0.0),
    "lasting": Variable("time", "correlation time of the unexplained force", min=0.0),
    "inflation": Variable("1", "factor calibrated on held-out blocks", min=0.0),
    "left_in_closed_loop": Variable(
        "length", "remaining error of the position in a closed-loop simulation", min=0.0
    ),
    "left_in_open_loop": Variable(
        "length", "remaining error of the position in an open-loop simulation", min=0.0
    ),
}


class ModelFile(NamedTuple):
    """Content of a model file.

    Parameters
    ----------
    plant : Model or None
        The plant, or None if the file has only friction.
    friction : Model
        The friction model.
    info : dict
        ``"provenance"``, ``"treatment"`` (``cutoff`` [Hz], ``decimation``, ``velocity_max`` [m/s or rad/s], ``delay``,
        ``smoothing``, ``position_smoothing`` and ``lag`` [s], ``slow`` [Hz] and ``stiffness`` [N/m or N*m/rad] of the
        identification, where known),
        ``"uncertainty"``: for each parameter ``std``, ``robust_std`` and ``interval`` in SI units, where known, and
        ``status``; ``"coupling"`` (``antiresonance`` [Hz] and ``inertia_ratio``) or None; and ``"bands"``, the data for
        bands around a prediction, or None.
    """

    plant: Model | None
    friction: Model
    info: dict[str, Any]


def _treatment(value: Any, path: str, kind: Kind | None) -> dict[str, Any]:
    """Return the numbers of a treatment, which must be finite; a frequency is positive."""
    numbers = mapping(lambda entry, place, _: entry)(value, path, kind)
    for name, number in numbers.items():
        if name in TREATMENT and not isinstance(number, float | int):
            raise InputError("must be a number", path=f"{path}.{name}", value=number)
        if isinstance(number, float | int) and not math.isfinite(number):
            raise InputError("must be finite", path=f"{path}.{name}", value=number)
    if numbers.get("cutoff", 1.0) <= 0.0:
        raise InputError("must be positive", path=f"{path}.cutoff", value=numbers["cutoff"])
    return numbers


def _with(*names: str) -> Converter:
    """Return a converter for an object with these attributes."""

    def convert(value: Any, path: str, kind: Kind | None) -> Any:
        if not all(hasattr(value, name) for name in names):
            raise InputError("has no " + " or no ".join(names), path=path, value=value)
        return value

    return convert


@guarded(
    plant=optional(model("plant")),
    friction=model("friction"),
    treatment=optional(_treatment),
    estimates=many(_with("std", "status", "interval")),
    bands=optional(_with("draws", "scatter", "noise")),
)
def write_model(
    path: str | os.PathLike[str],
    plant: Model | None,
    friction: Model,
    *,
    estimates: Iterable[Any] = (),
    provenance: Mapping[str, str] | None = None,
    treatment: Mapping[str, float] | None = None,
    bands: Any = None,
    notes: Mapping[str, str] | None = None,
) -> None:
    """Write a model file; numbers are read back exactly.

    Parameters
    ----------
    path : path-like
        The file. A user friction model is copied to the same folder.
    plant, friction : Model
        The models to write; `plant` may be None.
    estimates : iterable of Estimate
        Standard error and status of each parameter.
    provenance : mapping of str to str
        Origin of the values: version, log, axis, command.
    treatment : mapping
        Preprocessing of the log: ``cutoff`` [Hz], ``decimation`` and ``velocity_max`` [m/s or rad/s]; other entries
        are ignored. ``antiresonance`` [Hz] and ``inertia_ratio`` describe an elastic coupling.
    bands : Bands, optional
        Data for bands around a prediction.
    notes : mapping of str to str
        Reasons why parameters are not identified, by name.

    Raises
    ------
    InputError
        If the friction model is neither part of bristle nor read from a file.
    """
    target = Path(path)
    tables: dict[str, Any] = {
        "schema": 1,
        "kind": friction.kind,
        "provenance": provenance or {},
        "treatment": {},
    }
    for name, variable in TREATMENT.items():
        if name in (treatment or {}):
            is_count, value = name == "decimation", (treatment or {})[name]
            unit = "" if is_count else f"{variable.unit(friction.kind)}: "
            tables["treatment"][name] = Said(
                int(value) if is_count else float(value), f"{unit}{variable.description}"
            )
    if treatment and COUPLING.keys() <= treatment.keys():
        tables["coupling"] = {
            name: Said(
                float(treatment[name]), f"{variable.unit(friction.kind)}: {variable.description}"
            )
            for name, variable in COUPLING.items()
        }
    if plant is not None:
        tables["plant"] = described(plant)
    values = described(friction)
    del values["model"]
    tables |= {"friction": _name_of(friction, target.parent) | values, "uncertainty": {}}
    for estimate in estimates:
        if estimate.std is not None or estimate.status != "identified":
            entry = {
                "std": estimate.std,
                "robust_std": estimate.robust_std,
                "status": estimate.status,
                "note": (notes or {}).get(estimate.name),
                "interval": estimate.interval,
            }
            tables["uncertainty"][key_of(estimate.name)] = {
                key: value for key, value in entry.items() if value
            }
    if bands is not None:
        numbers = {
            name: Said(float(getattr(bands, name)), said.description)
            for name, said in NUMBERS.items()
        }
        # The parameter sets for the bands, in seven digits.
        draws = {
            key_of(name): _short(np.asarray(values)[:40].tolist())
            for name, values in bands.draws.items()
        }
        tables["bands"] = numbers | {"draws": draws}
    write_whole(target, as_toml(tables))


def _short(value: Any) -> Any:
    if isinstance(value, list):
        return list(map(_short, value))
    return float(f"{value:.7g}")


def _name_of(friction: Model, folder: Path) -> dict[str, Any]:
    """Return the entries that name the friction model in the file; copy user files to the folder."""
    base, *slots = friction.name.split("+")
    inner, over = base_of(friction.component), channel_slots_of(friction.component)
    own = {
        slot.name: _beside(slot, slot.factor, folder)
        for slot in over
        if CHANNEL_SLOTS.get(slot.name) != slot
    }
    slots = [own.get(slot, slot) for slot in slots]
    if MODELS.get(base) is inner:
        return {"model": "+".join([base, *slots])}
    return {"file": _beside(inner, inner.trial, folder)} | ({"slots": slots} if slots else {})


def _beside(described: FrictionModel | Slot, function: Callable[..., Any], folder: Path) -> str:
    """Copy the file of a user model or slot, as loaded if possible; return its name."""
    from bristle.files.user_model import code_of

    code = code_of(described)
    if code is None or code.source.suffix != ".py":
        try:
            code = content_of(inspect.getfile(function))
        except (InputError, TypeError, OSError):
            raise InputError(
                "is not defined in a file, so a model file cannot refer to it",
                path=described.name,
                mend="Save the model in a separate file and load it from there",
            ) from None
    target = folder / code.source.name
    if not os.path.lexists(target):
        write_whole(target, code.data, new=True)
    elif content_of(target).data != code.data:
        raise InputError(
            "exists already with different content",
            path=str(target),
            mend="Write the model file to another folder, or move the existing file",
        )
    return code.source.name


def read_model(path: Readable, *, related: bool = True, allow_code: bool = False) -> ModelFile:
    """Return the content of a model file.

    Parameters
    ----------
    path : path-like, bytes or file object
        The file.
    related : bool
        False also reads a friction model whose values violate a condition, such as f_p > F_S, so that a check can report it.
    allow_code : bool
        Whether a user model in a file that it names may run without earlier permission.

    Raises
    ------
    InputError
        With the file, the key, the value and the allowed values.
    """
    data, source, _ = read_toml(path, path="model", what="a friction model or a model file")
    with located(source):
        check_keys(data, KEYS, "")
        check_schema(data)
        kind = kind_at(data.get("kind", KINDS[0]), "kind")
        if "friction" not in data:
            raise InputError(
                "is missing",
                path="friction",
                mend='Write [friction] and, below it, model = "coulomb_viscous"',
            )
        place: dict[str, Any] = {"kind": kind, "folder": source.parent, "path": "friction"}
        friction = friction_from(data["friction"], **place, related=related, allow_code=allow_code)
        plant = (
            model_from(data["plant"], PLANTS, kind=kind, path="plant", find=find_plant)
            if "plant" in data
            else None
        )
        parameters = set(friction.values) | set(plant.values if plant else ()) | {"s", "lag"}
        info: dict[str, Any] = {
            name: table_at(data.get(name, {}), name)
            for name in ("uncertainty", "provenance", "treatment")
        }
        check_keys(info["uncertainty"], [key_of(name) for name in parameters], "uncertainty")
        check_keys(info["treatment"], TREATMENT, "treatment")
        coupling = table_at(data["coupling"], "coupling") if "coupling" in data else None
        info["coupling"] = coupling and numbers_in(
            coupling, COUPLING, kind, "coupling", needs=COUPLING
        )
        info["treatment"] = numbers_in(
            info["treatment"], TREATMENT, kind, "treatment", integers=("decimation",)
        )
        return ModelFile(
            plant, friction, info | {"bands": _bands_at(data.get("bands"), parameters, kind)}
        )


def friction_from(
    table: Any,
    *,
    kind: Kind,
    folder: Path,
    path: str,
    related: bool = True,
    allow_code: bool = False,
    read_operator: OperatorRead | None = None,
    read_code: CodeRead | None = None,
) -> Model:
    """Return the friction model of a table, by name or from a user file."""
    entries = with_operator(
        table_at(table, path), kind, path, read_operator or operator_beside(folder)
    )
    read_code = read_code or partial(code_named, folder=folder, allow_code=allow_code)
    beside = ("file", "slots") if "file" in entries else ("model",)
    component = _component_of(entries, path, read_code)
    values = parameters_in(entries, component, path, beside=beside)
    return make_model(component, values, kind=kind, validate=True, related=related, path=path)


def _component_of(table: Mapping[str, Any], path: str, read_code: CodeRead) -> FrictionModel:
    """Return the friction model that a table names, with its slots; both may be in user files."""
    from bristle.files.user_model import component_in, slots_in

    if "file" in table:
        slots, place = table.get("slots", []), f"{path}.slots"
        if not isinstance(slots, list) or not all(isinstance(slot, str) for slot in slots):
            raise InputError("must be a list of names", path=place, value=slots)
        component = component_in(table, FrictionModel, path=path, read_code=read_code)
        return with_slots(component, slots_in(slots, place, read_code), place)
    named, place = table.get("model"), f"{path}.model"
    if not isinstance(named, str):
        raise InputError(
            "names no model",
            path=place,
            value=named,
            allowed=", ".join(MODELS),
            mend=f'Write model = "coulomb_viscous" under [{path}]',
        )
    base, *slots = named.split("+")
    if not any(slot.endswith(".py") for slot in slots):
        return find(named, place)
    return with_slots(find(base, place).inner, slots_in(slots, place, read_code), place)


def _bands_at(value: Any, parameters: Collection[str], kind: Kind) -> dict[str, Any] | None:
    """Return the table in the form of `bristle.identification.simulated_bands.Bands`; None if it is missing."""
    if value is None:
        return None
    table, names = table_at(value, "bands"), {key_of(name): name for name in parameters}
    check_keys(table, (*NUMBERS, "draws"), "bands")
    if missing := [name for name in NUMBERS if name not in table]:
        raise InputError(
            "is missing: an earlier version of bristle wrote the file",
            path=f"bands.{missing[0]}",
            mend="Identify again, or remove [bands] to predict without bands",
        )
    draws = table_at(table.get("draws", {}), "bands.draws")
    check_keys(draws, names, "bands.draws")
    rows = array(ndim=2, least=1, single=True)
    drawn = {
        names[key]: np.atleast_1d(rows(draw, f"bands.draws.{key}", kind))
        for key, draw in draws.items()
    }
    if len(set(map(len, drawn.values()))) > 1:
        raise InputError(
            "must have the same number of values for each parameter", path="bands.draws"
        )
    return numbers_in(table, NUMBERS, kind, "bands") | {"draws": drawn}
