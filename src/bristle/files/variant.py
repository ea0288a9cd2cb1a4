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
    content, axis = tables.content, None
    if "axis" in content:
        check_keys(tables.table("axis"), ("file",), tables.path("axis"))
        axis = sources.axis(tables.table("axis").get("file"), f"{tables.path('axis')}.file")
    kind = _kind(tables, axis, sources)
    if "friction" not in content:
        raise InputError("is missing", path="friction", mend='Write [friction] and, below it, model = "coulomb_viscous"')
    identified, friction = sources.friction(content["friction"], kind, tables.path("friction"))
    if identified is not None and axis is not None and axis.presliding:
        friction = with_presliding(friction, axis.presliding)
    plant = _plant(tables, axis, identified, kind, sources)
    table_friction, has_screw = None, plant.component.screw is not None
    if "table_friction" in content:  # in N and m whatever the kind of axis
        path = tables.path("table_friction")
        if not has_screw:
            message, mend = (
                "needs a plant with a table behind a screw",
                'Write model = "ball_screw" under [plant], or put the friction under [friction]',
            )
            raise InputError(message, path=path, value=plant.name, allowed="ball_screw", mend=mend)
        table_friction = sources.friction(content["table_friction"], "translational", path)[1]
    path, sensor = tables.path("sensor"), tables.table("sensor")
    # The sensor reads the side of the motor, unless the file says otherwise.
    side = choice_at(sensor, "side", SIDES, path, "no such side", "motor" if has_screw else "load")
    sensor = {key: value for key, value in sensor.items() if key != "side"}
    if not sensor and axis is not None and axis.resolution is not None:
        sensor = {"resolution": axis.resolution}
    own = sources.own(sensor, Sensor, path)
    mechanism: dict[str, Any] = {
        "name": name,
        "plant": plant,
        "friction": friction,
        "table": table_friction,
        "sensor": model_from(sensor, SENSORS, kind=kind, path=path, default="encoder", own=own),
        "sensor_at": side,
        "axis": axis,
    }
    return (_open_loop if "effort" in content else _closed_loop)(tables, mechanism, kind, sources)


def _closed_loop(tables: Tables, mechanism: dict[str, Any], kind: Kind, sources: Sources) -> Variant:
    axis, plant, start, learning = mechanism["axis"], mechanism["plant"], None, None
    reference = _reference(tables, axis, kind, sources)
    run = run_from(tables.table("run"), axis, reference, kind, tables.path("run"))
    if "learning" in tables.table("controller"):
        path = tables.path("controller", "learning")
        entries = {"k_d": 0.0, **table_at(tables.table("controller")["learning"], path)}
        check_keys(entries, LEARNING, path)
        learning = Learning(**numbers_in(entries, LEARNING, kind, path, needs=LEARNING, integers=("trials",)))
    if "start" in tables.content:  # else the loop begins where its reference does
        path, entries, variables = tables.path("start"), tables.table("start"), START | {"effort": FEEDFORWARD["offset"]}
        check_keys(entries, variables, path)
        start = Start(**numbers_in(entries, variables, kind, path, needs=("position",)))
    return Variant(
        **mechanism,
        controller=_controller(tables, axis, kind, sources),
        reference=reference,
        feedforward=_feedforward(tables, plant, kind, sources),
        learning=learning,
        disturbance=_replayed("disturbance", tables, run, sources),
        injected=_replayed("injected", tables, run, sources),
        start=start,
        run=run,
    )


def _open_loop(tables: Tables, mechanism: dict[str, Any], kind: Kind, sources: Sources) -> Variant:
    for section in ("controller", "reference"):
        if section in tables.content:
            mend = f"Take [{section}] or [effort] out of the file"
            raise InputError("belongs to a loop, and [effort] drives the plant without one", path=tables.path(section), mend=mend)
    path, entries, axis = tables.path("effort"), tables.table("effort"), mechanism["axis"]
    log = recorded_in(entries, axis, sources, path)
    reference = at_rest(kind, log)
    run = run_from(tables.table("run"), axis, reference, kind, tables.path("run"))
    effort, law = effort_from(entries, log, run, kind, path), open_loop(kind=kind)
    return Variant(**mechanism, controller=law, reference=reference, feedforward=Feedforward(), run=run, effort=effort)


def _values_of(model: Model) -> dict[str, Any]:
    """Return a model as the table that would describe it."""
    return {"model": model.name} | {key_of(name): value for name, value in model.values.items()}


def _replayed(section: str, tables: Tables, run: Run, sources: Sources) -> np.ndarray | None:
    """Return the force that no model explains, or the known input of a log, at each sample of a run."""
    if section not in tables.content:
        return None
    path, entries = tables.path(section), tables.table(section)
    check_keys(entries, ("file",), path)
    record = sources.loop_record(entries.get("file"), f"{path}.file")
    force = record.unexplained if section == "disturbance" else record.injected
    if force is None:
        mend = f"Take [{path}] out of the file"
        raise InputError("has no column of known inputs", path=f"{path}.file", value=entries["file"], mend=mend)
    at = np.floor(run.sample_time / record.sample_time * np.arange(round(run.duration / run.sample_time)) + OF_A_SAMPLE)
    if at[-1] >= force.size:
        message = f"is longer than the force in {entries['file']}, {force.size * record.sample_time:g} s"
        mend = f"Leave duration out, or take [{path}] out of the file"
        raise InputError(message, path=tables.path("run", "duration"), value=run.duration, mend=mend)
    return force[at.astype(int)]


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
    own, place, friction = entries.get("plant", "none"), f"{path}.plant", entries.get("friction", "none")
    if own not in ("none", "own"):
        allowed = '"none", or "own": those of [plant]'
        raise InputError("is no plant whose gravity and cogging are fed forward", path=place, value=own, allowed=allowed)
    along: Any = choice_at(entries, "along", ALONG, path, "is no motion that a compensator follows")
    rest: Any = choice_at(entries, "rest", RESTS, path, "is no rule for the force at rest")
    place = tables.path("controller", "feedforward", "friction")
    if isinstance(friction, str) and friction != "none":
        mend = f'Write [{place}] and, below it, model = "coulomb_viscous" or file = "model.toml"'
        allowed = '"none", or a friction model as in [friction]'
        raise InputError("must be a table", path=place, value=friction, allowed=allowed, mend=mend)
    values: dict[str, Any] = numbers_in(entries, FEEDFORWARD, kind, path)
    values |= {"along": along, "rest": rest, "plant": plant if own == "own" else None}
    if friction == "none":
        return Feedforward(friction=None, fitted_to="", carries=None, **values)
    identified, compensator = sources.friction(friction, kind, place)
    # The plant whose effort passes through a compensator that asks for it, as it was identified with it.
    mechanism = identified or plant
    carries = mechanism if rises_with_effort(compensator) and mechanism.component.inverse is not None else None
    return Feedforward(friction=compensator, fitted_to=sources.fitted_to(friction, place), carries=carries, **values)


def _reference(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path, entries = tables.path("reference"), tables.table("reference")
    if entries.get("model") == "recorded" and "file" in entries:
        recorded = sources.recorded(entries, axis, path)
        if recorded.kind != kind:
            raise InputError(f"is of a {recorded.kind} axis, and this one is {kind}", path=f"{path}.file", value=entries["file"])
        return recorded
    return model_from(entries, REFERENCES, kind=kind, path=path, own=sources.own(entries, Trajectory, path))
