"""Build a variant of an experiment from its tables: a loop or an open-loop excitation, and the run."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bristle.core import Axis, InputError, experiment, units
from bristle.core.contracts import Controller, Model, Plant, Sensor, Trajectory, make_model
from bristle.core.experiment import (
    FEEDFORWARD,
    LEARNING,
    RUN,
    START,
    Coupling,
    Effort,
    Feedforward,
    Learning,
    Run,
    Start,
    Variant,
)
from bristle.core.variable import Kind, Variable
from bristle.files import components
from bristle.files.components import (
    check_keys,
    choice_at,
    in_effort,
    key_of,
    model_from,
    number_at,
    numbers_in,
    table_at,
)
from bristle.files.sources import Sources
from bristle.logs.log import Log
from bristle.models.controllers import open_loop
from bristle.models.friction import MODELS, with_presliding
from bristle.models.friction.level import rises_with_effort
from bristle.models.plants import PLANTS, find as find_plant
from bristle.models.references import REFERENCES
from bristle.models.sensors import SENSORS

SECTIONS = (
    *("axis", "plant", "friction", "table_friction", "controller", "effort"),
    *("sensor", "reference", "disturbance", "injected", "start", "run"),
)
BESIDE = ("feedforward", "learning")  # other keys of a control law


@dataclass(frozen=True)
class Tables:
    """Tables of a variant, and their places in the file."""

    content: Mapping[str, Any]
    override: Mapping[str, Any] = field(default_factory=dict)
    prefix: str = ""

    def path(self, *keys: str) -> str:
        """Return the path of a table in the file."""
        level: Any = self.override
        for key in keys:
            if not isinstance(level, Mapping) or key not in level:
                return ".".join(keys)
            level = level[key]
        return ".".join((self.prefix, *keys))

    def table(self, section: str) -> dict[str, Any]:
        """Return a section; an empty dict if it is missing."""
        return table_at(self.content.get(section, {}), self.path(section))


def merged(base: Any, override: Any) -> Any:
    """Return a copy of `base` with the values of `override`."""
    if not isinstance(base, Mapping) or not isinstance(override, Mapping):
        return override
    if override.keys() & {"model", "file", "identified"}:
        # Parameters belong to the model of the same table; inner tables have separate models.
        base = {key: value for key, value in base.items() if isinstance(value, Mapping)}
    return {**base, **{key: merged(base.get(key), value) for key, value in override.items()}}


def variant_from(name: str, tables: Tables, sources: Sources) -> Variant:
    """Return the variant described by some tables."""
    content, axis = tables.content, None
    if "axis" in content:
        check_keys(tables.table("axis"), ("file",), tables.path("axis"))
        axis = sources.axis(tables.table("axis").get("file"), f"{tables.path('axis')}.file")
    kind = _kind(tables, axis, sources)
    if "friction" not in content:
        raise InputError(
            "is missing",
            path="friction",
            mend='Write [friction] and, below it, model = "coulomb_viscous"',
        )
    identified, friction = sources.friction(content["friction"], kind, tables.path("friction"))
    if identified is not None and axis is not None and axis.presliding:
        friction = with_presliding(friction, axis.presliding)
    plant = _plant(tables, axis, identified, kind, sources)
    table_friction, has_screw = None, plant.component.screw is not None
    if "table_friction" in content:  # in N and m for every kind of axis
        path = tables.path("table_friction")
        if not has_screw:
            raise InputError(
                "needs a plant with a screw that moves a table",
                path=path,
                value=plant.name,
                allowed="ball_screw",
                mend='Write model = "ball_screw" under [plant], or put the friction under [friction]',
            )
        table_friction = sources.friction(content["table_friction"], "translational", path)[1]
    path, sensor = tables.path("sensor"), tables.table("sensor")
    # By default, the sensor of a plant with a screw is on the motor.
    side = choice_at(
        sensor, "side", experiment.SIDES, path, "no such side", "motor" if has_screw else "load"
    )
    sensor = {key: value for key, value in sensor.items() if key != "side"}
    if not sensor and axis is not None and axis.resolution is not None:
        sensor = {"resolution": axis.resolution}
    own = sources.own(sensor, Sensor, path)
    named = sources.identified(content["friction"], tables.path("friction"))
    coupling, bands = (
        (None, None) if named is None else (named.info.get("coupling"), named.info.get("bands"))
    )
    mechanism: dict[str, Any] = {
        "name": name,
        "plant": plant,
        "friction": friction,
        "table": table_friction,
        "sensor": model_from(sensor, SENSORS, kind=kind, path=path, default="encoder", own=own),
        "sensor_at": side,
        "axis": axis,
        "coupling": Coupling(**coupling) if coupling and not has_screw else None,
        "draws": bands["draws"] if bands else {},
    }
    return (_open_loop if "effort" in content else _closed_loop)(tables, mechanism, kind, sources)


def _closed_loop(
    tables: Tables, mechanism: dict[str, Any], kind: Kind, sources: Sources
) -> Variant:
    axis, plant, start, learning = mechanism["axis"], mechanism["plant"], None, None
    reference = _reference(tables, axis, kind, sources)
    run = run_from(tables.table("run"), axis, reference, kind, tables.path("run"))
    if "learning" in tables.table("controller"):
        path = tables.path("controller", "learning")
        entries = {"k_d": 0.0, **table_at(tables.table("controller")["learning"], path)}
        check_keys(entries, LEARNING, path)
        learning = Learning(
            **numbers_in(entries, LEARNING, kind, path, needs=LEARNING, integers=("trials",))
        )
    if "start" in tables.content:  # else the loop starts at the start of its reference
        path, entries, variables = (
            tables.path("start"),
            tables.table("start"),
            START | {"effort": FEEDFORWARD["offset"]},
        )
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
            raise InputError(
                "needs a closed loop, but [effort] drives the plant in open loop",
                path=tables.path(section),
                mend=f"Remove [{section}] or [effort] from the file",
            )
    path, entries, axis = tables.path("effort"), tables.table("effort"), mechanism["axis"]
    log = recorded_in(entries, axis, sources, path)
    reference = at_rest(kind, log)
    run = run_from(tables.table("run"), axis, reference, kind, tables.path("run"))
    effort, law = effort_from(entries, log, run, kind, path), open_loop(kind=kind)
    return Variant(
        **mechanism,
        controller=law,
        reference=reference,
        feedforward=Feedforward(),
        run=run,
        effort=effort,
    )


def _values_of(model: Model) -> dict[str, Any]:
    """Return the table that describes a model."""
    return {"model": model.name} | {key_of(name): value for name, value in model.values.items()}


def _replayed(section: str, tables: Tables, run: Run, sources: Sources) -> np.ndarray | None:
    """Return the unexplained force or the known input of a log at each sample of a run."""
    if section not in tables.content:
        return None
    path, entries = tables.path(section), tables.table(section)
    check_keys(entries, ("file",), path)
    record = sources.loop_record(entries.get("file"), f"{path}.file")
    force = record.unexplained if section == "disturbance" else record.injected
    if force is None:
        raise InputError(
            "has no column of known inputs",
            path=f"{path}.file",
            value=entries["file"],
            mend=f"Remove [{path}] from the file",
        )
    described, mend = (
        f"the force in {entries['file']}",
        f"Remove duration, or remove [{path}] from the file",
    )
    return _repeated(
        force, record.sample_time, run, described, tables.path("run", "duration"), mend
    )


def _repeated(
    values: np.ndarray, sample_time: float, run: Run, described: str, path: str, mend: str
) -> np.ndarray:
    """Return a recorded signal at each sample of a run; refuse a run that is longer than the signal."""
    at = np.floor(
        run.sample_time / sample_time * np.arange(round(run.duration / run.sample_time))
        + experiment.OF_A_SAMPLE
    )
    if at[-1] >= values.size:
        raise InputError(
            f"is longer than {described}, {values.size * sample_time:g} s",
            path=path,
            value=run.duration,
            mend=mend,
        )
    return values[at.astype(int)]


def _kind(tables: Tables, axis: Axis | None, sources: Sources) -> Kind:
    """Return the kind of axis, from the file, its axis, its identified model, or the units of its parameters."""
    kind = components.kind_at(tables.content["kind"], "kind") if "kind" in tables.content else None
    if kind and axis and kind != axis.kind:
        raise InputError(
            f"does not match the {axis.kind} axis of the axis file", path="kind", value=kind
        )
    if kind or axis:
        return kind or axis.kind  # type: ignore[union-attr]
    friction, plant = tables.table("friction"), tables.table("plant")
    if isinstance(friction.get("file"), str) and friction["file"].endswith(".toml"):
        return sources.model(friction["file"], tables.path("friction", "file")).friction.kind
    variables = PLANTS["inertia"].variables | {
        name: variable for model in MODELS.values() for name, variable in model.variables.items()
    }
    return units.kind_of(plant | friction, variables)


def _plant(
    tables: Tables, axis: Axis | None, identified: Model | None, kind: Kind, sources: Sources
) -> Model:
    path, entries = tables.path("plant"), tables.table("plant")
    if (own := sources.own(entries, Plant, path)) is not None:
        return model_from(entries, PLANTS, kind=kind, path=path, own=own)
    if "model" not in entries and identified is not None:
        entries = _values_of(identified) | entries
    elif "model" not in entries and axis is not None and axis.mass is not None:
        entries = {"M": axis.mass, **entries}
    if not entries:
        raise InputError(
            "is missing",
            path=path,
            mend='Write [plant] and, below it, model = "inertia" and M = "95 kg"',
        )
    return model_from(entries, PLANTS, kind=kind, path=path, default="inertia", find=find_plant)


def _controller(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path = tables.path("controller")
    entries = {key: value for key, value in tables.table("controller").items() if key not in BESIDE}
    own = sources.own(entries, Controller, path)
    if own is None and "model" not in entries and axis is not None and axis.controller is not None:
        running = _values_of(axis.controller)
        entries = {
            key: value for key, value in running.items() if key != "k_i" or "T_n" not in entries
        } | entries
    return components.controller_from(entries, kind=kind, axis=axis, path=path, own=own)


def _feedforward(tables: Tables, plant: Model, kind: Kind, sources: Sources) -> Feedforward:
    path = tables.path("controller", "feedforward")
    entries = table_at(tables.table("controller").get("feedforward", {}), path)
    check_keys(
        entries,
        (*FEEDFORWARD, "friction", "table_friction", "along", "rest", "scaled", "plant"),
        path,
    )
    fed = _fed_plant(entries, plant, kind, tables)
    along: Any = choice_at(
        entries, "along", experiment.ALONG, path, "is not a motion for a compensator"
    )
    rest: Any = choice_at(
        entries, "rest", experiment.RESTS, path, "is not a rule for the force at rest"
    )
    place, friction = (
        tables.path("controller", "feedforward", "friction"),
        entries.get("friction", "none"),
    )
    if isinstance(friction, str) and friction != "none":
        raise InputError(
            "must be a table",
            path=place,
            value=friction,
            allowed='"none", or a friction model as in [friction]',
            mend=f'Write [{place}] and, below it, model = "coulomb_viscous" or file = "model.toml"',
        )
    values: dict[str, Any] = numbers_in(entries, FEEDFORWARD, kind, path)
    scaled: Any = choice_at(
        entries, "scaled", experiment.SCALED, path, "is not a force that the gain scales"
    )
    values |= {"along": along, "rest": rest, "scaled": scaled, "plant": fed}
    if "table_friction" in entries:
        behind = tables.path("controller", "feedforward", "table_friction")
        values["table"] = sources.friction(entries["table_friction"], "translational", behind)[1]
    if friction != "none":
        identified, compensator = sources.friction(friction, kind, place)
        # The plant for a compensator that depends on the transmitted effort, as identified with it.
        mechanism = identified or plant
        carries = (
            mechanism
            if rises_with_effort(compensator) and mechanism.component.inverse is not None
            else None
        )
        values |= {
            "friction": compensator,
            "fitted_to": sources.fitted_to(friction, place),
            "carries": carries,
        }
    try:
        return Feedforward(**values)
    except InputError as error:
        raise error.at(path=f"{path}.{error.path.removeprefix('feedforward.')}") from None


def _fed_plant(
    entries: Mapping[str, Any], plant: Model, kind: Kind, tables: Tables
) -> Model | None:
    """Return the plant that a feedforward knows: none, that of the axis, or another one."""
    path = tables.path("controller", "feedforward")
    if isinstance(entries.get("plant"), Mapping):
        return model_from(
            entries["plant"], PLANTS, kind=kind, path=f"{path}.plant", find=find_plant
        )
    own = choice_at(
        entries,
        "plant",
        ("none", "own"),
        path,
        "is not a plant for the feedforward of gravity and cogging",
    )
    return plant if own == "own" else None


def _reference(tables: Tables, axis: Axis | None, kind: Kind, sources: Sources) -> Model:
    path, entries = tables.path("reference"), tables.table("reference")
    if entries.get("model") == "recorded" and "file" in entries:
        recorded = sources.recorded(entries, axis, path)
        if recorded.kind != kind:
            raise InputError(
                f"is from a {recorded.kind} axis, but this axis is {kind}",
                path=f"{path}.file",
                value=entries["file"],
            )
        return recorded
    return model_from(
        entries, REFERENCES, kind=kind, path=path, own=sources.own(entries, Trajectory, path)
    )


def run_from(
    table: Mapping[str, Any], axis: Axis | None, reference: Model, kind: Kind, path: str
) -> Run:
    """Return the duration and the steps of the simulation."""
    entries = dict(table)
    check_keys(entries, RUN, path)
    if axis is not None:
        of_axis = {
            "effort_limit": axis.effort_limit,
            "current_lag": axis.lag or None,
            "sample_time": axis.sample_time,
        }
        entries = {name: value for name, value in of_axis.items() if value is not None} | entries
    if reference.name == "recorded":
        record = reference.values
        length = len(record["position"]) * record["sample_time"]
        entries = {"sample_time": record["sample_time"], "duration": length, **entries}
    if "effort_limit" in entries:
        entries["effort_limit"] = in_effort(
            entries["effort_limit"],
            RUN["effort_limit"].quantity,
            kind,
            axis,
            f"{path}.effort_limit",
        )
    values = numbers_in(
        entries,
        RUN,
        kind,
        path,
        needs=("duration", "sample_time"),
        integers=("substeps", "delay", "seeds"),
    )
    duration, settle = values["duration"], values.get("settle", 0.0)
    step = values["sample_time"]
    samples = duration / step
    if not 3.0 <= samples <= experiment.SAMPLES_MAX:
        raise InputError(
            f"gives {samples:.3g} samples at a sample time of {step:g} s",
            path=f"{path}.duration",
            value=duration,
            allowed=f"3 to {experiment.SAMPLES_MAX} samples",
            mend="Change duration or sample_time",
        )
    if settle >= duration:
        raise InputError(
            "is not shorter than the run",
            path=f"{path}.settle",
            value=settle,
            allowed=f"less than the duration, {duration:g} s",
        )
    try:
        return Run(**values)
    except InputError as error:
        raise error.at(path=f"{path}.{error.path}") from None


# The time functions of references, with an effort in place of each length.
FUNCTIONS = ("sine", "chirp", "triangle", "s_curve")
CONSTANT, RECORDED = "constant", "recorded"
LEVEL = Variable("force", "effort from the first sample on")


def recorded_in(
    table: Mapping[str, Any], axis: Axis | None, sources: Sources, path: str
) -> Log | None:
    """Return the log whose effort drives an open loop; None for a function of time."""
    if table.get("model") != RECORDED:
        return None
    check_keys(table, ("model", "file", "axis"), path)
    if "axis" in table:
        axis = sources.axis(table["axis"], f"{path}.axis")
    log = sources.log(table.get("file"), axis, f"{path}.file")
    if log.effort is None or len(log.segments) > 1:
        fault = (
            "has no effort"
            if log.effort is None
            else f"has gaps, which split it into {len(log.segments)} parts"
        )
        raise InputError(
            fault,
            path=f"{path}.file",
            value=table["file"],
            mend="Name a log of effort without gaps",
        )
    return log


def at_rest(kind: Kind, log: Log | None = None) -> Model:
    """Return the unused reference of an open loop: a rest with the length of its log."""
    if log is None:
        return REFERENCES["sine"](kind=kind, amplitude=0.0, frequency=1.0)
    return REFERENCES["recorded"](
        kind=kind, position=np.zeros(len(log)), sample_time=log.sample_time
    )


def effort_from(
    table: Mapping[str, Any], log: Log | None, run: Run, kind: Kind, path: str
) -> Effort:
    """Return the effort of an open loop at each sample."""
    time = run.sample_time * np.arange(round(run.duration / run.sample_time))
    if log is not None and log.effort is not None:
        effort = _repeated(
            log.effort.values,
            log.sample_time,
            run,
            "the log of the effort",
            "run.duration",
            "Remove duration",
        )
        return Effort(effort, f"effort of {table['file']}")
    if "model" not in table:
        raise InputError(
            "names no model",
            path=path,
            allowed=f"{CONSTANT}, {', '.join(FUNCTIONS)}, {RECORDED}",
            mend=f'Write model = "sine" under [{path}]',
        )
    numbers = ", ".join(f"{key} = {value}" for key, value in table.items() if key != "model")
    if table["model"] == CONSTANT:
        check_keys(table, ("model", "level"), path)
        level = number_at(table.get("level", 0.0), LEVEL, kind, f"{path}.level")
        return Effort(np.full(time.size, level), f"{CONSTANT}, {numbers}" if numbers else "none")
    # So that the message for an unknown name lists them too.
    without_length = dict.fromkeys((CONSTANT, RECORDED), REFERENCES["sine"])
    registry = {name: REFERENCES[name] for name in FUNCTIONS} | without_length
    component: Trajectory = components.component_named(table["model"], registry, f"{path}.model")
    variables = effort_variables(component.name)
    check_keys(table, ("model", *map(key_of, variables)), path)
    model = make_model(
        component, numbers_in(table, variables, kind, path), kind=kind, validate=True, path=path
    )
    return Effort(component.sample(time, model.parameters)[0], f"{component.name}, {numbers}")


def effort_variables(name: Any) -> dict[str, Variable]:
    """Return the parameters of the effort of an open loop, by the name of its model; empty for a recorded effort."""
    if name == CONSTANT:
        return {"level": LEVEL}
    lengths: Mapping[str, Variable] = {}
    if name in FUNCTIONS:
        lengths = REFERENCES[name].variables
    return {
        key: replace(length, quantity=length.quantity.replace("length", "force"))
        for key, length in lengths.items()
    }


def variables_of_section(
    section: str, variant: Variant, data: Mapping[str, Any]
) -> Mapping[str, Variable] | None:
    """Return the variables of a section that is not a model; None if there is no such section."""
    if section == "effort" and variant.effort is not None:
        return effort_variables(data.get("effort", {}).get("model"))
    if section == "run":
        return RUN
    if section == "controller.feedforward" and variant.effort is None:
        return FEEDFORWARD
    if section == "controller.learning" and variant.learning is not None:
        return LEARNING
    return None
