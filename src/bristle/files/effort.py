"""The table ``[effort]`` of an experiment: what drives an open loop, as a function of time or as a log has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model, Trajectory, make_model
from bristle.core.errors import InputError
from bristle.core.experiment import Effort, Run
from bristle.core.variable import Kind, Variable
from bristle.files.components import check_keys, component_named, key_of, number_at
from bristle.files.sources import Sources
from bristle.logs.log import Log
from bristle.references import chirp, recorded, s_curve, sine, triangle

__all__ = ["at_rest", "effort_from", "effort_variables", "recorded_in"]

# The functions of time that references are, with an effort for each length.
FUNCTIONS = {function.name: function for function in (sine, chirp, triangle, s_curve)}
CONSTANT, RECORDED = "constant", "recorded"
LEVEL = Variable("force", "effort from the first sample on")
BETWEEN = 1e-6  # of a sample: times that are told in decimals are not exact


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
        at = np.floor(time / log.sample_time + BETWEEN).astype(int)
        if at[-1] >= len(log):
            raise InputError(
                f"is longer than the log of the effort, {len(log) * log.sample_time:g} s",
                path="run.duration",
                value=run.duration,
                mend="Leave duration out",
            )
        return Effort(log.effort.values[at], f"that of {table['file']}")
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
    registry = {**FUNCTIONS, CONSTANT: sine, RECORDED: sine}  # those too are told of where a name is unknown
    component: Trajectory = component_named(table["model"], registry, f"{path}.model")
    variables = {key_of(name): (name, variable) for name, variable in effort_variables(component.name).items()}
    check_keys(table, ("model", *variables), path)
    values = {name: number_at(table[key], variable, kind, f"{path}.{key}") for key, (name, variable) in variables.items() if key in table}
    model = make_model(component, values, kind=kind, validate=True, path=path)
    return Effort(component.sample(time, model.parameters)[0], f"{component.name}, {numbers}")


def effort_variables(name: Any) -> dict[str, Variable]:
    """Return the parameters of what drives an open loop, by the name of its model; none of a recorded one."""
    if name == CONSTANT:
        return {"level": LEVEL}
    component = FUNCTIONS.get(name) if isinstance(name, str) else None
    return {} if component is None else {key: _of_effort(length) for key, length in component.variables.items()}


def _of_effort(variable: Variable) -> Variable:
    """Return a parameter of a reference as one of an effort."""
    return replace(variable, quantity=variable.quantity.replace("length", "force"))
