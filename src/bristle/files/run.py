"""The table ``[run]`` of an experiment: how long and how finely to simulate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import Run
from bristle.core.variable import Kind, Variable
from bristle.files.components import check_keys, number_at
from bristle.files.controller import in_effort

__all__ = ["run_from"]

SAMPLES_MAX = 10_000_000
LONGEST_DELAY = 64.0  # samples: each is a state of the loop, whose poles are looked for with every shorter delay, too

RUN = {
    "duration": Variable("time", "simulated time", min=1e-9),
    "sample_time": Variable("time", "sample time of the controller", min=1e-9),
    "settle": Variable("time", "time at the start that the statistics leave out", min=0.0),
    "effort_limit": Variable("force", "largest effort of the drive", min=0.0),
    "substeps": Variable("1", "integration steps in a sample", min=1.0, max=10_000.0),
    "current_lag": Variable("time", "time constant of the current control of the drive", min=0.0),
    "seeds": Variable("1", "runs, each with other noise", min=1.0, max=1000.0),
    "delay": Variable("1", "samples from a measurement to the effort computed from it", min=0.0, max=LONGEST_DELAY),
}


def run_from(table: Mapping[str, Any], axis: Axis | None, reference: Model, kind: Kind, path: str) -> Run:
    """Return how long and how finely to simulate.

    Parameters
    ----------
    table : mapping
        The table ``[run]``.
    axis : Axis or None
        Gives sample time and limit where the table does not.
    reference : Model
        A recorded one gives sample time and duration where the table does not.
    kind : {"translational", "rotational"}
        Kind of axis.
    path : str
        Key of the table, for messages.

    Raises
    ------
    InputError
        With the path of the key that does not fit, its value and what is allowed.
    """
    given = dict(table)
    check_keys(given, RUN, path)
    if axis is not None and axis.effort_limit is not None:
        given = {"effort_limit": axis.effort_limit, **given}
    if axis is not None and axis.sample_time is not None:
        given = {"sample_time": axis.sample_time, **given}
    if reference.name == "recorded":
        record = reference.values
        length = len(record["position"]) * record["sample_time"]
        given = {"sample_time": record["sample_time"], "duration": length, **given}
    for name in ("duration", "sample_time"):
        if name not in given:
            raise InputError(f"needs {name}", path=path, mend=f"Write {name}, {RUN[name].description}, under [{path}]")
    if "effort_limit" in given:
        columns = axis.columns if axis is not None else {}
        unit, where = RUN["effort_limit"].unit(kind), f"{path}.effort_limit"
        given["effort_limit"] = in_effort(given["effort_limit"], unit, kind, columns, where)
    values: dict[str, Any] = {name: number_at(given[name], RUN[name], kind, f"{path}.{name}") for name in given}
    for name in ("substeps", "delay", "seeds"):
        if name in values:
            values[name] = _whole(values[name], f"{path}.{name}")
    run = Run(**values)
    _check_lengths(run, path)
    return run


def _check_lengths(run: Run, path: str) -> None:
    samples = run.duration / run.sample_time
    if not 3.0 <= samples <= SAMPLES_MAX:
        raise InputError(
            f"asks for {samples:.3g} samples of {run.sample_time:g} s", path=f"{path}.duration", value=run.duration,
            allowed=f"3 to {SAMPLES_MAX} samples", mend="Change duration or sample_time",
        )  # fmt: skip
    if run.settle >= run.duration:
        raise InputError("leaves nothing to judge", path=f"{path}.settle", value=run.settle,
                         allowed=f"less than the duration, {run.duration:g} s")  # fmt: skip


def _whole(value: float, path: str) -> int:
    if not value.is_integer():
        raise InputError("must be a whole number", path=path, value=value)
    return int(value)
