"""What a person hands to `identify` and `predict`: objects or the files that describe them, numbers or text."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.edge import instance, optional, whole
from bristle.core.errors import InputError
from bristle.core.units import quantity
from bristle.core.values import looked_at
from bristle.core.variable import Kind, Variable
from bristle.files.given import AXIS
from bristle.logs.columns import is_table
from bristle.logs.log import Log

__all__ = [
    "CUTOFF",
    "axes_for",
    "checked_model",
    "log_and_axis",
    "logs_and_axes",
    "number_or_text",
    "treatment_of",
]

CUTOFF = Variable("frequency", "cut-off of the zero-phase filter")


def log_and_axis(log: Any, axis: Any) -> tuple[Log, Axis | None]:
    """Return a log and what is known of its axis; a path of either is read, and so is a table of columns.

    Raises
    ------
    InputError
        If one is neither, or its file cannot be used.
    """
    from bristle.files.log import read_log

    axis = looked_at(optional(AXIS), axis, "axis", None)
    if is_table(log):
        return Log.from_columns(log, axis=axis), axis
    converter = instance(Log, "a log or its file", 'Write read_log("axis.csv", axis)', partial(read_log, axis=axis))
    return looked_at(converter, log, "log", None), axis


def axes_for(axes: Sequence[Any], count: int) -> list[Any]:
    """Return an axis for each of `count` logs: the only one there is for all of them, or each its own.

    Raises
    ------
    InputError
        If there is another number of them.
    """
    described = list(axes) or [None]
    if len(described) == 1:
        return described * count
    if len(described) != count:
        raise InputError(f"{len(described)} for {count} logs", path="axis", allowed=f"1, or {count}",
                         mend="Give one axis file for all logs, or one for each, in their order")  # fmt: skip
    return described


def logs_and_axes(log: Any, axis: Any) -> list[tuple[Log, Axis | None]]:
    """Return one log or several, each with what is known of its axis: one axis for all, or as many as logs.

    Raises
    ------
    InputError
        If one is neither a log nor its file, or the axes do not match the logs.
    """
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    if not logs:
        raise InputError("names no log", path="log", mend="Give at least one")
    axes = axes_for(axis if isinstance(axis, (list, tuple)) else [axis], len(logs))
    return [log_and_axis(log, axis) for log, axis in zip(logs, axes, strict=True)]


def number_or_text(value: Any, variable: Variable, kind: Kind, path: str) -> float | None:
    """Return a number in SI from a number or text with a unit; None stays None.

    Raises
    ------
    InputError
        If it is neither, or the unit does not fit.
    """
    return None if value is None else quantity(value, variable, kind, path=path)


def treatment_of(cutoff: Any, decimation: Any, kind: Kind) -> tuple[float | None, int | None]:
    """Return the cut-off [Hz] and the decimation that are asked for, None where none is.

    Raises
    ------
    InputError
        If one is no number, or has the wrong unit.
    """
    rows = optional(whole(1, 10_000))(decimation, "decimation", kind)
    return number_or_text(cutoff, CUTOFF, kind, "cutoff"), rows


def checked_model(model: Any, family: str, path: str) -> Model:
    """Return a model with parameters, of the family that is wanted there.

    Raises
    ------
    InputError
        If it is something else.
    """
    if not isinstance(model, Model):
        raise InputError(f"must be a {family} model with parameters", path=path, value=model)
    model_family = model.component.family
    if model_family != family:
        raise InputError(
            f"must be a {family} model, and is a {model_family} model", path=path, value=model,
            mend="The order is plant, friction, log",
        )  # fmt: skip
    return model
