"""The tables ``[run]`` and ``[effort]`` of an experiment: how finely to simulate, and what drives an open loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model, Trajectory, make_model
from bristle.core.errors import InputError
from bristle.core.experiment import OF_A_SAMPLE, RUN, SAMPLES_MAX, Effort, Run
from bristle.core.variable import Kind, Variable
from bristle.files.components import check_keys, component_named, key_of, number_at, numbers_in
from bristle.files.controller import in_effort
from bristle.files.sources import Sources
from bristle.logs.log import Log
from bristle.references import chirp, recorded, s_curve, sine, triangle


def run_from(table: Mapping[str, Any], axis: Axis | None, reference: Model, kind: Kind, path: str) -> Run:
    """Return how long and how finely to simulate."""
    entries = dict(table)
    check_keys(entries, RUN, path)
    if axis is not None:
        of_axis = {"effort_limit": axis.effort_limit, "current_lag": axis.lag or None, "sample_time": axis.sample_time}
        entries = {name: value for name, value in of_axis.items() if value is not None} | entries
    if reference.name == "recorded":
        record = reference.values
        length = len(record["position"]) * record["sample_time"]
        entries = {"sample_time": record["sample_time"], "duration": length, **entries}
    if "effort_limit" in entries:
        entries["effort_limit"] = in_effort(entries["effort_limit"], RUN["effort_limit"].quantity, kind, axis, f"{path}.effort_limit")
    values = numbers_in(entries, RUN, kind, path, needs=("duration", "sample_time"), integers=("substeps", "delay", "seeds"))
    if "substeps" in values and values.get("tolerance"):
        message, place = "stands beside a tolerance, which chooses the steps itself", f"{path}.substeps"
        raise InputError(message, path=place, value=table["substeps"], mend="Leave one of both out")
    duration, settle = values["duration"], values.get("settle", 0.0)
    samples = duration / values["sample_time"]
    if not 3.0 <= samples <= SAMPLES_MAX:
        message, allowed = f"asks for {samples:.3g} samples of {values['sample_time']:g} s", f"3 to {SAMPLES_MAX} samples"
        raise InputError(message, path=f"{path}.duration", value=duration, allowed=allowed, mend="Change duration or sample_time")
    if settle >= duration:
        raise InputError("leaves nothing to judge", path=f"{path}.settle", value=settle, allowed=f"less than the duration, {duration:g} s")
    return Run(**values)


# The functions of time that references are, with an effort for each length.
FUNCTIONS = {function.name: function for function in (sine, chirp, triangle, s_curve)}
CONSTANT, RECORDED = "constant", "recorded"
LEVEL = Variable("force", "effort from the first sample on")


def recorded_in(table: Mapping[str, Any], axis: Axis | None, sources: Sources, path: str) -> Log | None:
    """Return the log whose effort drives an open loop; None where a function of time does."""
    if table.get("model") != RECORDED:
        return None
    check_keys(table, ("model", "file", "axis"), path)
    if "axis" in table:
        axis = sources.axis(table["axis"], f"{path}.axis")
    log = sources.log(table.get("file"), axis, f"{path}.file")
    if log.effort is None or len(log.segments) > 1:
        fault = "has no effort" if log.effort is None else f"has gaps, which split it into {len(log.segments)} parts"
        raise InputError(fault, path=f"{path}.file", value=table["file"], mend="Name a log of effort without gaps")
    return log


def at_rest(kind: Kind, log: Log | None = None) -> Model:
    """Return the reference of an open loop, which nothing follows: a rest, as long as its log."""
    if log is None:
        return sine(kind=kind, amplitude=0.0, frequency=1.0)
    return recorded(kind=kind, position=np.zeros(len(log)), sample_time=log.sample_time)


def effort_from(table: Mapping[str, Any], log: Log | None, run: Run, kind: Kind, path: str) -> Effort:
    """Return what drives an open loop, sample by sample."""
    time = run.sample_time * np.arange(round(run.duration / run.sample_time))
    if log is not None and log.effort is not None:
        at = np.floor(time / log.sample_time + OF_A_SAMPLE).astype(int)
        if at[-1] >= len(log):
            message = f"is longer than the log of the effort, {len(log) * log.sample_time:g} s"
            raise InputError(message, path="run.duration", value=run.duration, mend="Leave duration out")
        return Effort(log.effort.values[at], f"that of {table['file']}")
    if "model" not in table:
        allowed, mend = f"{CONSTANT}, {', '.join(FUNCTIONS)}, {RECORDED}", f'Write model = "sine" under [{path}]'
        raise InputError("names no model", path=path, allowed=allowed, mend=mend)
    numbers = ", ".join(f"{key} = {value}" for key, value in table.items() if key != "model")
    if table["model"] == CONSTANT:
        check_keys(table, ("model", "level"), path)
        level = number_at(table.get("level", 0.0), LEVEL, kind, f"{path}.level")
        return Effort(np.full(time.size, level), f"{CONSTANT}, {numbers}" if numbers else "none")
    registry = {**FUNCTIONS, CONSTANT: sine, RECORDED: sine}  # those too are told of where a name is unknown
    component: Trajectory = component_named(table["model"], registry, f"{path}.model")
    variables = effort_variables(component.name)
    check_keys(table, ("model", *map(key_of, variables)), path)
    model = make_model(component, numbers_in(table, variables, kind, path), kind=kind, validate=True, path=path)
    return Effort(component.sample(time, model.parameters)[0], f"{component.name}, {numbers}")


def effort_variables(name: Any) -> dict[str, Variable]:
    """Return the parameters of what drives an open loop, by the name of its model; none of a recorded one."""
    if name == CONSTANT:
        return {"level": LEVEL}
    component = FUNCTIONS.get(name) if isinstance(name, str) else None
    lengths = {} if component is None else component.variables
    return {key: replace(length, quantity=length.quantity.replace("length", "force")) for key, length in lengths.items()}
