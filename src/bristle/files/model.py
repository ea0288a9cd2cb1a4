"""Model files: a plant and a friction model with their values, how sure we are of them, and where they come from."""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bristle.core.content import Readable, content_of
from bristle.core.contracts import FrictionModel, Model, make_model
from bristle.core.edge import guarded, model, optional
from bristle.core.errors import InputError, located
from bristle.core.slot import Slot
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.components import check_keys, check_schema, key_of, kind_at, model_from, numbers_in, parameters_in, table_at
from bristle.files.operator import OperatorRead, operator_beside, with_operator
from bristle.files.permission import CodeRead, code_named
from bristle.files.single import write_whole
from bristle.files.toml import read_toml
from bristle.friction import CHANNEL_SLOTS, MODELS, base_of, channel_slots_of, find, with_slots
from bristle.plants import PLANTS
from bristle.plants import find as find_plant

if TYPE_CHECKING:
    from tomlkit.items import Table


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
    import tomlkit

    target = Path(path)
    document = tomlkit.document()
    lists: dict[str, str] = {}
    document.add("schema", tomlkit.item(1))
    document.add("kind", tomlkit.item(friction.kind))
    if provenance:
        document.add("provenance", tomlkit.item(dict(provenance)))
    if treatment:
        table = tomlkit.table()
        for name, variable in TREATMENT.items():
            if name in treatment:
                is_count = name == "decimation"
                item = tomlkit.item(int(treatment[name]) if is_count else float(treatment[name]))
                item.comment(variable.description if is_count else f"{variable.unit(friction.kind)}: {variable.description}")
                table.add(name, item)
        document.add("treatment", table)
    if plant is not None:
        document.add("plant", _table(plant, {"model": plant.name}, lists))
    document.add("friction", _table(friction, _name_of(friction, target.parent), lists))
    uncertain = [estimate for estimate in estimates if estimate.std is not None or estimate.status != "identified"]
    if uncertain:
        uncertainty = tomlkit.table(is_super_table=True)
        for estimate in uncertain:
            entry = {"std": estimate.std, "robust_std": estimate.robust_std, "status": estimate.status}
            entry["note"] = (notes or {}).get(estimate.name)
            entry["interval"] = list(estimate.interval) if estimate.interval else None
            uncertainty.add(key_of(estimate.name), tomlkit.item({key: value for key, value in entry.items() if value}))
        document.add("uncertainty", uncertainty)
    if bands is not None:
        document.add("bands", _bands_table(bands))
    text = tomlkit.dumps(document)
    for mark, numbers in lists.items():
        text = text.replace(f'"{mark}"', numbers, 1)
    write_whole(target, text)


def _table(model: Model, head: Mapping[str, Any], tables: dict[str, str]) -> Table:
    """Return a model as a table; of a long list a mark, and the list as text in `tables`."""
    import tomlkit

    table = tomlkit.table()
    for key, value in head.items():
        table.add(key, value)
    for name, value in model.values.items():
        variable = model.component.variables[name]
        plain = value.tolist() if hasattr(value, "tolist") else value
        if isinstance(plain, list) and len(plain) > 256:
            mark = f"numbers {len(tables)} of {model.name}"
            plain, tables[mark] = mark, f"[{', '.join(map(repr, plain))}]"
        item = tomlkit.item(plain)
        item.comment(f"{variable.unit(model.kind)}: {' '.join(variable.description.split())}")
        table.add(key_of(name), item)
    return table


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
        return ModelFile(plant, friction, info | {"bands": _bands_at(data.get("bands"), parameters)})


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


NUMBERS = {
    "scatter": "of the level of friction from reversal to reversal, a share of it",
    "noise": "of the effort, sample by sample",
    "unexplained": "left over beyond noise, encoder and scatter",
    "lasting": "s over which that keeps its side",
    "inflation": "factor set on blocks that were held out",
    "left_in_closed_loop": "of the position in a simulation, beyond all that",
    "left_in_open_loop": "of the position in a simulation, beyond all that",
}


def _bands_table(bands: Any) -> Table:
    """Return the table of a model file, with as many sets of parameters as a band is drawn from."""
    import tomlkit

    def short(value: Any) -> Any:
        return [short(entry) for entry in value] if np.ndim(value) else float(f"{float(value):.7g}")

    table, draws = tomlkit.table(), tomlkit.table()
    for name, comment in NUMBERS.items():
        table.add(name, float(getattr(bands, name)))
        table[name].comment(comment)
    for name, values in bands.draws.items():
        draws.add(key_of(name), tomlkit.item([short(draw) for draw in values[:40]]))
    table.add("draws", draws)
    return table


def _bands_at(value: Any, parameters: Collection[str]) -> dict[str, Any] | None:
    """Return the table as `bristle.identification.simulated_bands.Bands` takes it; None where there is none."""
    if value is None:
        return None
    table = table_at(value, "bands")
    check_keys(table, (*NUMBERS, "draws"), "bands")
    bands: dict[str, Any] = {}
    for name in NUMBERS:
        number, path = table.get(name), f"bands.{name}"
        if name not in table:
            raise InputError(
                "is missing, as from an earlier version", path=path, mend="Identify again, or leave [bands] out to predict without bands"
            )
        if isinstance(number, bool) or not isinstance(number, (int, float)) or not math.isfinite(number) or number < 0:
            mend = "Leave [bands] out to predict without bands"
            raise InputError("must be a number", path=path, value=number, allowed=">= 0", mend=mend)
        bands[name] = float(number)
    names = {key_of(name): name for name in parameters}
    draws = table_at(table.get("draws", {}), "bands.draws")
    check_keys(draws, names, "bands.draws")
    bands["draws"] = {}
    for key, draw in draws.items():
        try:
            numbers = np.array(draw, dtype=float)
        except (TypeError, ValueError):
            numbers = np.zeros(())
        if numbers.ndim not in (1, 2) or not np.all(np.isfinite(numbers)):
            raise InputError("must be a list of numbers, or of lists of one length", path=f"bands.draws.{key}")
        bands["draws"][names[key]] = numbers
    if len({len(draw) for draw in bands["draws"].values()}) > 1:
        raise InputError("must have as many numbers for each parameter", path="bands.draws")
    return bands
