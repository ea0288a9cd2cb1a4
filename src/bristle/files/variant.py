"""One variant of an experiment, from its tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bristle.controllers import open_loop
from bristle.core import units
from bristle.core.axis import Axis
from bristle.core.contracts import Controller, Model, Plant, Sensor, Trajectory
from bristle.core.errors import InputError
from bristle.core.experiment import (
    ALONG,
    FEEDFORWARD,
    LEARNING,
    OF_A_SAMPLE,
    RESTS,
    SIDES,
    START,
    Feedforward,
    Learning,
    Run,
    Start,
    Variant,
)
from bristle.core.variable import Kind
from bristle.files.components import check_keys, choice_at, key_of, kind_at, model_from, numbers_in, table_at
from bristle.files.controller import controller_from
from bristle.files.run import at_rest, effort_from, recorded_in, run_from
from bristle.files.sources import Sources
from bristle.friction import MODELS, with_presliding
from bristle.friction.level import rises_with_effort
from bristle.plants import PLANTS
from bristle.plants import find as find_plant
from bristle.references import REFERENCES
from bristle.sensors import SENSORS

SECTIONS = (
    "axis",
    "plant",
    "friction",
    "table_friction",
    "controller",
    "effort",
    "sensor",
    "reference",
    "disturbance",
    "injected",
    "start",
    "run",
)

BESIDE = ("feedforward", "learning")  # of the parameters of a control law


@dataclass(frozen=True)
class Tables:
    """The tables of one variant, and where each of them stands in the file."""

    content: Mapping[str, Any]
    override: Mapping[str, Any] = field(default_factory=dict)
    prefix: str = ""

    def path(self, *keys: str) -> str:
        """Return the path in the file of a table."""
        level: Any = self.override
        for key in keys:
            if not isinstance(level, Mapping) or key not in level:
                return ".".join(keys)
            level = level[key]
        return ".".join((self.prefix, *keys))

    def table(self, section: str) -> dict[str, Any]:
        """Return a section, empty where the file has none."""
        return table_at(self.content.get(section, {}), self.path(section))


def merged(base: Any, override: Any) -> Any:
    """Return `base` with what `override` says instead; neither is changed."""
    if not isinstance(base, Mapping) or not isinstance(override, Mapping):
        return override
    if override.keys() & {"model", "file", "identified"}:
        # Parameters belong to the model that was named with them; tables inside have a model of their own.
        base = {key: value for key, value in base.items() if isinstance(value, Mapping)}
    return {**base, **{key: merged(base.get(key), value) for key, value in override.items()}}


def variant_from(name: str, tables: Tables, sources: Sources) -> Variant:
    """Return the variant that some tables describe."""
    axis = _axis(tables, sources)
    kind = _kind(tables, axis, sources)
    if "friction" not in tables.content:
        raise InputError("is missing", path="friction", mend='Write [friction] and, below it, model = "coulomb_viscous"')
    identified, friction = sources.friction(tables.content["friction"], kind, tables.path("friction"))
    if identified is not None and axis is not None and axis.presliding:
        friction = with_presliding(friction, axis.presliding)
    plant = _plant(tables, axis, identified, kind, sources)
    mechanism: dict[str, Any] = {
        "name": name,
        "plant": plant,
        "friction": friction,
        "table": _table_friction(tables, plant, sources),
        "sensor": _sensor(tables, axis, kind, sources),
        "sensor_at": _side(tables, plant),
        "axis": axis,
    }
    if "effort" in tables.content:
        return _open_loop(tables, mechanism, kind, sources)
    reference = _reference(tables, axis, kind, sources)
    run = run_from(tables.table("run"), axis, reference, kind, tables.path("run"))
    return Variant(
        **mechanism,
        controller=_controller(tables, axis, kind, sources),
        reference=reference,
        feedforward=_feedforward(tables, plant, kind, sources),
        learning=_learning(tables, kind),
        disturbance=_replayed("disturbance", tables, run, sources),
        injected=_replayed("injected", tables, run, sources),
        start=_start(tables, kind),
        run=run,
    )


def _replayed(section: str, tables: Tables, run: Run, sources: Sources) -> np.ndarray | None:
    """Return the force that no model explains, or the known input of a log, at each sample of a run."""
    if section not in tables.content:
        return None
    path, entries = tables.path(section), tables.table(section)
    check_keys(entries, ("file",), path)
    record = sources.loop_record(entries.get("file"), f"{path}.file")
    force = record.unexplained if section == "disturbance" else record.injected
    if force is None:
        raise InputError("has no column of known inputs", path=f"{path}.file", value=entries["file"], mend=f"Take [{path}] out of the file")
    at = np.floor(run.sample_time / record.sample_time * np.arange(round(run.duration / run.sample_time)) + OF_A_SAMPLE)
    if at[-1] >= force.size:
        raise InputError(
            f"is longer than the force in {entries['file']}, {force.size * record.sample_time:g} s",
            path=tables.path("run", "duration"),
            value=run.duration,
            mend=f"Leave duration out, or take [{path}] out of the file",
        )
    return force[at.astype(int)]


def _start(tables: Tables, kind: Kind) -> Start | None:
    """Return where a loop begins; None for where its reference does."""
    if "start" not in tables.content:
        return None
    path, entries, known = tables.path("start"), tables.table("start"), START | {"effort": FEEDFORWARD["offset"]}
    check_keys(entries, known, path)
    return Start(**numbers_in(entries, known, kind, path, needs=("position",)))


def _open_loop(tables: Tables, mechanism: dict[str, Any], kind: Kind, sources: Sources) -> Variant:
    for section in ("controller", "reference"):
        if section in tables.content:
            raise InputError(
                "belongs to a loop, and [effort] drives the plant without one",
                path=tables.path(section),
                mend=f"Take [{section}] or [effort] out of the file",
            )
    path, entries = tables.path("effort"), tables.table("effort")
    log = recorded_in(entries, mechanism["axis"], sources, path)
    reference = at_rest(kind, log)
    run = run_from(tables.table("run"), mechanism["axis"], reference, kind, tables.path("run"))
    return Variant(
        **mechanism,
        controller=open_loop(kind=kind),
        reference=reference,
        feedforward=Feedforward(),
        run=run,
        effort=effort_from(entries, log, run, kind, path),
    )


def _axis(tables: Tables, sources: Sources) -> Axis | None:
    if "axis" not in tables.content:
        return None
    path = tables.path("axis")
    table = tables.table("axis")
    check_keys(table, ("file",), path)
    return sources.axis(table.get("file"), f"{path}.file")


def _kind(tables: Tables, axis: Axis | None, sources: Sources) -> Kind:
    """Return the kind of axis: as the file says, its axis, its identified model, or the units of its parameters."""
    kind = kind_at(tables.content["kind"], "kind") if "kind" in tables.content else None
    if kind and axis and kind != axis.kind:
        raise InputError(f"does not match the axis file, which is {axis.kind}", path="kind", value=kind)
    if kind or axis:
        return kind or axis.kind  # type: ignore[union-attr]
    friction, plant = tables.table("friction"), tables.table("plant")
    if isinstance(friction.get("file"), str) and friction["file"].endswith(".toml"):
        return sources.model(friction["file"], tables.path("friction", "file")).friction.kind
    variables = PLANTS["inertia"].variables | {name: variable for model in MODELS.values() for name, variable in model.variables.items()}
    return units.kind_of(plant | friction, variables)


def _values_of(model: Model) -> dict[str, Any]:
    """Return a model as the table that would describe it."""
    return {"model": model.name} | {key_of(name): value for name, value in model.values.items()}


def _plant(tables: Tables, axis: Axis | None, identified: Model | None, kind: Kind, sources: Sources) -> Model:
    path, entries = tables.path("plant"), tables.table("plant")
    if (own := sources.own(entries, Plant, path)) is not None:
        return model_from(entries, PLANTS, kind=kind, path=path, own=own)
    if "model" not in entries and identified is not None:
        entries = _values_of(identified) | entries
    elif "model" not in entries and axis is not None and axis.mass is not None:
        entries = {"M": axis.mass, **entries}
    if not entries:
        raise InputError("is missing", path=path, mend='Write [plant] and, below it, model = "inertia" and M = "95 kg"')
    return model_from(entries, PLANTS, kind=kind, path=path, default="inertia", find=find_plant)


def _controller(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path = tables.path("controller")
    entries = {key: value for key, value in tables.table("controller").items() if key not in BESIDE}
    own = sources.own(entries, Controller, path)
    if own is None and "model" not in entries and axis is not None and axis.controller is not None:
        running = _values_of(axis.controller)
        entries = {key: value for key, value in running.items() if key != "k_i" or "T_n" not in entries} | entries
    return controller_from(entries, kind=kind, axis=axis, path=path, own=own)


def _feedforward(tables: Tables, plant: Model, kind: Kind, sources: Sources) -> Feedforward:
    path = tables.path("controller", "feedforward")
    entries = table_at(tables.table("controller").get("feedforward", {}), path)
    check_keys(entries, (*FEEDFORWARD, "friction", "along", "rest", "plant"), path)
    own = entries.get("plant", "none")
    if own not in ("none", "own"):
        raise InputError(
            "is no plant whose gravity and cogging are fed forward",
            path=f"{path}.plant",
            value=own,
            allowed='"none", or "own": those of [plant]',
        )
    along: Any = choice_at(entries, "along", ALONG, path, "is no motion that a compensator follows")
    rest: Any = choice_at(entries, "rest", RESTS, path, "is no rule for the force at rest")
    friction = entries.get("friction", "none")
    full_path = tables.path("controller", "feedforward", "friction")
    if isinstance(friction, str) and friction != "none":
        raise InputError(
            "must be a table",
            path=full_path,
            value=friction,
            allowed='"none", or a friction model as in [friction]',
            mend=f'Write [{full_path}] and, below it, model = "coulomb_viscous" or file = "model.toml"',
        )
    values = numbers_in(entries, FEEDFORWARD, kind, path)
    compensator, fitted_to, carries = None, "", None
    if friction != "none":
        (identified, compensator), fitted_to = (sources.friction(friction, kind, full_path), sources.fitted_to(friction, full_path))
        # The plant whose effort passes through a compensator that asks for it, as it was identified with it.
        mechanism = identified or plant
        carries = mechanism if rises_with_effort(compensator) and mechanism.component.inverse is not None else None
    return Feedforward(
        friction=compensator, along=along, rest=rest, fitted_to=fitted_to, plant=plant if own == "own" else None, carries=carries, **values
    )


def _learning(tables: Tables, kind: Kind) -> Learning | None:
    if "learning" not in tables.table("controller"):
        return None
    path = tables.path("controller", "learning")
    entries = {"k_d": 0.0, **table_at(tables.table("controller")["learning"], path)}
    check_keys(entries, LEARNING, path)
    return Learning(**numbers_in(entries, LEARNING, kind, path, needs=LEARNING, whole=("trials",)))


def _table_friction(tables: Tables, plant: Model, sources: Sources) -> Model | None:
    """Return the friction of the table of a plant with a screw, in N and m whatever the kind of axis."""
    if "table_friction" not in tables.content:
        return None
    path = tables.path("table_friction")
    if plant.component.screw is None:
        raise InputError(
            "needs a plant with a table behind a screw",
            path=path,
            value=plant.name,
            allowed="ball_screw",
            mend='Write model = "ball_screw" under [plant], or put the friction under [friction]',
        )
    return sources.friction(tables.content["table_friction"], "translational", path)[1]


def _side(tables: Tables, plant: Model) -> str:
    """Return which side of the screw the sensor reads: that of the motor, unless the file says otherwise."""
    usual = "motor" if plant.component.screw is not None else "load"
    return choice_at(tables.table("sensor"), "side", SIDES, tables.path("sensor"), "no such side", usual)


def _sensor(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path = tables.path("sensor")
    entries = {key: value for key, value in tables.table("sensor").items() if key != "side"}
    if not entries and axis is not None and axis.resolution is not None:
        entries = {"resolution": axis.resolution}
    own = sources.own(entries, Sensor, path)
    return model_from(entries, SENSORS, kind=kind, path=path, default="encoder", own=own)


def _reference(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path, entries = tables.path("reference"), tables.table("reference")
    if entries.get("model") == "recorded" and "file" in entries:
        recorded = sources.recorded(entries, axis, path)
        if recorded.kind != kind:
            raise InputError(f"is of a {recorded.kind} axis, and this one is {kind}", path=f"{path}.file", value=entries["file"])
        return recorded
    own = sources.own(entries, Trajectory, path)
    return model_from(entries, REFERENCES, kind=kind, path=path, own=own)
