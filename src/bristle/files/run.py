"""The table ``[run]`` of an experiment: how long and how finely to simulate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import RUN, SAMPLES_MAX, Run
from bristle.core.variable import Kind
from bristle.files.components import check_keys, number_at
from bristle.files.controller import in_effort

__all__ = ["run_from"]


def run_from(table: Mapping[str, Any], axis: Axis | None, reference: Model, kind: Kind, path: str) -> Run:
    """Return how long and how finely to simulate."""
    entries = dict(table)
    check_keys(entries, RUN, path)
    if axis is not None and axis.effort_limit is not None:
        entries = {"effort_limit": axis.effort_limit, **entries}
    if axis is not None and axis.lag:
        entries = {"current_lag": axis.lag, **entries}
    if axis is not None and axis.sample_time is not None:
        entries = {"sample_time": axis.sample_time, **entries}
    if reference.name == "recorded":
        record = reference.values
        length = len(record["position"]) * record["sample_time"]
        entries = {"sample_time": record["sample_time"], "duration": length, **entries}
    for name in ("duration", "sample_time"):
        if name not in entries:
            raise InputError(f"needs {name}", path=path, mend=f"Write {name}, {RUN[name].description}, under [{path}]")
    if "effort_limit" in entries:
        columns = axis.columns if axis is not None else {}
        quantity, place = RUN["effort_limit"].quantity, f"{path}.effort_limit"
        entries["effort_limit"] = in_effort(entries["effort_limit"], quantity, kind, columns, place, axis.arm if axis is not None else None)
    values: dict[str, Any] = {name: number_at(entries[name], RUN[name], kind, f"{path}.{name}") for name in entries}
    if "substeps" in values and values.get("tolerance"):
        raise InputError(
            "stands beside a tolerance, which chooses the steps itself",
            path=f"{path}.substeps",
            value=table["substeps"],
            mend="Leave one of both out",
        )
    for name in ("substeps", "delay", "seeds"):
        if name in values:
            values[name] = _integer(values[name], f"{path}.{name}")
    _check_lengths(values["duration"], values["sample_time"], values.get("settle", 0.0), path)
    return Run(**values)


def _check_lengths(duration: float, sample_time: float, settle: float, path: str) -> None:
    samples = duration / sample_time
    if not 3.0 <= samples <= SAMPLES_MAX:
        raise InputError(
            f"asks for {samples:.3g} samples of {sample_time:g} s",
            path=f"{path}.duration",
            value=duration,
            allowed=f"3 to {SAMPLES_MAX} samples",
            mend="Change duration or sample_time",
        )
    if settle >= duration:
        raise InputError("leaves nothing to judge", path=f"{path}.settle", value=settle, allowed=f"less than the duration, {duration:g} s")


def _integer(value: float, path: str) -> int:
    if not value.is_integer():
        raise InputError("must be a whole number", path=path, value=value)
    return int(value)
