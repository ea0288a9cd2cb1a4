"""Model files: a plant and a friction model with their values, how sure we are of them, and where they come from."""

import inspect
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core.content import Readable, content_of
from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.edge import array, guarded, model, optional
from bristle.core.errors import InputError, located
from bristle.core.slot import Slot
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.components import check_keys, check_schema, key_of, kind_at, model_from, numbers_in, parameters_in, table_at
from bristle.files.operator import OperatorRead, described, operator_beside, with_operator
from bristle.files.permission import CodeRead, code_named
from bristle.files.single import write_whole
from bristle.files.toml import Said, as_toml, read_toml
from bristle.friction import CHANNEL_SLOTS, MODELS, base_of, channel_slots_of, find, with_slots
from bristle.plants import PLANTS
from bristle.plants import find as find_plant

# Key of the provenance: the `digest` of the friction that a log was made with, where a simulation made it.
FITTED_TO = "fitted to"

KEYS = ("schema", "kind", "provenance", "treatment", "plant", "friction", "uncertainty", "bands")
# What is known besides the numbers of a model: the stiffness of all elements, the lag of the loop it was fitted in.
TREATMENT = {
    "cutoff": Variable("frequency", "cut-off of the zero-phase filter of the identification", min=1e-9),
    "decimation": Variable("1", "samples for one row of the identification", min=1.0),
    "velocity_max": Variable("length/time", "largest speed that the model was fitted to", min=0.0),
    "delay": Variable("time", "by how much the effort of the log lags its position"),
    "smoothing": Variable("time", "time constant of a filter that the effort passed more than the position"),
    "position_smoothing": Variable("time", "time constant of a filter that the position passed", min=0.0),
    "slow": Variable("frequency", "cut-off of the instruments that the channels were looked at with", min=0.0),
    "lag": Variable("time", "time constant with which the drive follows its controller", min=0.0),
}

NUMBERS = {
    "scatter": Variable("1", "of the level of friction from reversal to reversal, a share of it", min=0.0),
    "noise": Variable("force", "of the effort, sample by sample", min=0.0),
    "unexplained": Variable("force", "left over beyond noise, encoder and scatter", min=0.0),
    "lasting": Variable("time", "s over which that keeps its side", min=0.0),
    "inflation": Variable("1", "factor set on blocks that were held out", min=0.0),
    "left_in_closed_loop": Variable("length", "of the position in a simulation, beyond all that", min=0.0),
    "left_in_open_loop": Variable("length", "of the position in a simulation, beyond all that", min=0.0),
}


class ModelFile(NamedTuple):
    """What a model file holds.

    Parameters
    ----------
    plant : Model or None
        The plant, where the file has one.
    friction : Model
        The friction model.
    info : dict
        ``"provenance"``, ``"treatment"`` (``cutoff`` [Hz], ``decimation``, ``velocity_max`` [m/s or rad/s], ``delay``,
        ``smoothing``, ``position_smoothing`` and ``lag`` [s] and ``slow`` [Hz] of the identification, where known),
        ``"uncertainty"``: for each parameter ``std``, ``robust_std`` and ``interval`` in SI, where known, and
        ``status``; and ``"bands"``, what bands around a prediction are made of, or None.
    """

    plant: Model | None
    friction: Model
    info: dict[str, Any]


@guarded(plant=optional(model("plant")), friction=model("friction"))
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
    """Write a model file; numbers come back to the bit.

    Parameters
    ----------
    path : path-like
        The file. A friction model of a user's own is copied beside it.
    plant, friction : Model
        What is written; `plant` may be None.
    estimates : iterable of Estimate
        Standard error and status of each parameter.
    provenance : mapping of str to str
        Where the values come from: version, log, axis, command.
    treatment : mapping
        How the log was treated: ``cutoff`` [Hz], ``decimation`` and ``velocity_max`` [m/s or rad/s]; further entries
        are left out.
    bands : Bands, optional
        What bands around a prediction are made of.
    notes : mapping of str to str
        Why parameters are not identified, by name.

    Raises
    ------
    InputError
        If the friction model is neither one of bristle's own nor read from a file.
    """
    target = Path(path)
    tables: dict[str, Any] = {"schema": 1, "kind": friction.kind, "provenance": provenance or {}, "treatment": {}}
    for name, variable in TREATMENT.items():
        if name in (treatment or {}):
            is_count, value = name == "decimation", (treatment or {})[name]
            unit = "" if is_count else f"{variable.unit(friction.kind)}: "
            tables["treatment"][name] = Said(int(value) if is_count else float(value), f"{unit}{variable.description}")
    if plant is not None:
        tables["plant"] = described(plant)
    values = described(friction)
    del values["model"]
    tables["friction"] = _name_of(friction, target.parent) | values
    tables["uncertainty"] = {}
    for estimate in estimates:
        if estimate.std is not None or estimate.status != "identified":
            entry = {"std": estimate.std, "robust_std": estimate.robust_std, "status": estimate.status}
            entry |= {"note": (notes or {}).get(estimate.name), "interval": estimate.interval}
            tables["uncertainty"][key_of(estimate.name)] = {key: value for key, value in entry.items() if value}
    if bands is not None:
        numbers = {name: Said(float(getattr(bands, name)), said.description) for name, said in NUMBERS.items()}
        # Of as many sets of parameters as a band is drawn from, in seven digits.
        draws = {key_of(name): _short(np.asarray(values)[:40].tolist()) for name, values in bands.draws.items()}
        tables["bands"] = numbers | {"draws": draws}
    write_whole(target, as_toml(tables))


def _short(value: Any) -> Any:
    return list(map(_short, value)) if isinstance(value, list) else float(f"{value:.7g}")


def _name_of(friction: Model, folder: Path) -> dict[str, Any]:
    """Return what names the friction model in the file: names, and files of a user's own, which are copied there."""
    base, *slots = friction.name.split("+")
    inner, over = base_of(friction.component), channel_slots_of(friction.component)
    own = {slot.name: _beside(slot, slot.factor, folder) for slot in over if CHANNEL_SLOTS.get(slot.name) != slot}
    slots = [own.get(slot, slot) for slot in slots]
    if MODELS.get(base) is inner:
        return {"model": "+".join([base, *slots])}
    return {"file": _beside(inner, inner.trial, folder)} | ({"slots": slots} if slots else {})


def _beside(described: FrictionModel | Slot, function: Callable[..., Any], folder: Path) -> str:
    """Copy the file that a model or slot of a user's own is in, as it was loaded, or else as it is; return its name."""
    from bristle.files.user_model import code_of

    code = code_of(described)
    if code is None or code.source.suffix != ".py":
        try:
            code = content_of(inspect.getfile(function))
        except (InputError, TypeError, OSError):
            mend = "Put it into a file of its own and load it from there"
            raise InputError("is in no file, so that a model file cannot name it", path=described.name, mend=mend) from None
    target = folder / code.source.name
    if not os.path.lexists(target):
        write_whole(target, code.data, new=True)
    elif content_of(target).data != code.data:
        mend = "Write the model file elsewhere, or move that file"
        raise InputError("is there already, with another content", path=str(target), mend=mend)
    return code.source.name


def read_model(path: Readable, *, related: bool = True, allow_code: bool = False) -> ModelFile:
    """Return what a model file holds.

    Parameters
    ----------
    path : path-like, bytes or file object
        The file.
    related : bool
        False reads a friction model whose values break a condition between them, such as f_p > F_S, to say what is
        wrong with it.
    allow_code : bool
        Whether a model of a person's own, in a file that this one names, may run without having been allowed before.

    Raises
    ------
    InputError
        With file, key, value and what is allowed there.
    """
    data, source, _ = read_toml(path, path="model", what="a friction model or a model file")
    with located(source):
        check_keys(data, KEYS, "")
        check_schema(data)
        kind = kind_at(data.get("kind", KINDS[0]), "kind")
        if "friction" not in data:
            raise InputError("is missing", path="friction", mend='Write [friction] and, below it, model = "coulomb_viscous"')
        place: dict[str, Any] = {"kind": kind, "folder": source.parent, "path": "friction"}
        friction = friction_from(data["friction"], **place, related=related, allow_code=allow_code)
        plant = model_from(data["plant"], PLANTS, kind=kind, path="plant", find=find_plant) if "plant" in data else None
        parameters = set(friction.values) | set(plant.values if plant else ()) | {"s", "lag"}
        info: dict[str, Any] = {name: table_at(data.get(name, {}), name) for name in ("uncertainty", "provenance", "treatment")}
        check_keys(info["uncertainty"], [key_of(name) for name in parameters], "uncertainty")
        check_keys(info["treatment"], TREATMENT, "treatment")
        info["treatment"] = numbers_in(info["treatment"], TREATMENT, kind, "treatment", integers=("decimation",))
        return ModelFile(plant, friction, info | {"bands": _bands_at(data.get("bands"), parameters, kind)})


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
    """Return the friction model of a table, by name or from a user's own file."""
    entries = with_operator(table_at(table, path), kind, path, read_operator or operator_beside(folder))
    read_code = read_code or partial(code_named, folder=folder, allow_code=allow_code)
    beside = ("file", "slots") if "file" in entries else ("model",)
    component = _component_of(entries, path, read_code)
    values = parameters_in(entries, component, path, beside=beside)
    return make_model(component, values, kind=kind, validate=True, related=related, path=path)


def _component_of(table: Mapping[str, Any], path: str, read_code: CodeRead) -> FrictionModel:
    """Return the friction model that a table names, with its slots; either may be of a person's own, in a file."""
    from bristle.files.user_model import component_in, slots_in

    if "file" in table:
        slots, place = table.get("slots", []), f"{path}.slots"
        if not isinstance(slots, list) or not all(isinstance(slot, str) for slot in slots):
            raise InputError("must be a list of names", path=place, value=slots)
        component = component_in(table, FrictionModel, path=path, read_code=read_code)
        return with_slots(component, slots_in(slots, place, read_code), place)
    named, place = table.get("model"), f"{path}.model"
    if not isinstance(named, str):
        mend = f'Write model = "coulomb_viscous" under [{path}]'
        raise InputError("names no model", path=place, value=named, allowed=", ".join(MODELS), mend=mend)
    base, *slots = named.split("+")
    if not any(slot.endswith(".py") for slot in slots):
        return find(named, place)
    return with_slots(find(base, place).inner, slots_in(slots, place, read_code), place)


def _bands_at(value: Any, parameters: Collection[str], kind: Kind) -> dict[str, Any] | None:
    """Return the table as `bristle.identification.simulated_bands.Bands` takes it; None where there is none."""
    if value is None:
        return None
    table, names = table_at(value, "bands"), {key_of(name): name for name in parameters}
    check_keys(table, (*NUMBERS, "draws"), "bands")
    if missing := [name for name in NUMBERS if name not in table]:
        mend = "Identify again, or leave [bands] out to predict without bands"
        raise InputError("is missing, as from an earlier version", path=f"bands.{missing[0]}", mend=mend)
    draws = table_at(table.get("draws", {}), "bands.draws")
    check_keys(draws, names, "bands.draws")
    rows = array(ndim=2, least=1, single=True)
    drawn = {names[key]: np.atleast_1d(rows(draw, f"bands.draws.{key}", kind)) for key, draw in draws.items()}
    if len(set(map(len, drawn.values()))) > 1:
        raise InputError("must have as many numbers for each parameter", path="bands.draws")
    return numbers_in(table, NUMBERS, kind, "bands") | {"draws": drawn}
