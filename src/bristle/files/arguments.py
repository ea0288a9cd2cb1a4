"""What a call may hand in as an axis, a log or an experiment: the thing, or the file that describes it."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from bristle import files
from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Readable, size_of
from bristle.core.edge import Converter, instance
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment
from bristle.core.values import looked_at
from bristle.logs import readers
from bristle.logs.log import Log, is_table

# Readers bring what checks files, which a call that hands in the thing itself need not wait for.
AXIS: Converter = instance(Axis, "an axis or its file", read=lambda source: files.read_axis(source))  # noqa: PLW0108
"""Takes an axis or its file."""
EXPERIMENT: Converter = instance(Experiment, "an experiment or its file", read=lambda source: files.read_experiment(source))  # noqa: PLW0108
LOG: Converter = instance(Log, "a log", 'Write read_log("axis.csv", axis)')


def log_and_axis(log: Any, axis: Any) -> tuple[Log, Axis | None]:
    """Return a log and what is known of its axis; a path of either is read, and so is a table of columns."""
    axis = None if axis is None else looked_at(AXIS, axis, "axis", None)
    if is_table(log):
        return Log.from_columns(log, axis=axis), axis
    converter = instance(Log, "a log or its file", 'Write read_log("axis.csv", axis)', partial(read_log, axis=axis))
    return looked_at(converter, log, "log", None), axis


def axes_for(axes: Sequence[Any], count: int) -> list[Any]:
    """Return an axis for each of `count` logs: the only one there is for all of them, or each its own."""
    described = list(axes) or [None]
    if len(described) == 1:
        return described * count
    if len(described) != count:
        mend = "Give one axis file for all logs, or one for each, in their order"
        raise InputError(f"{len(described)} for {count} logs", path="axis", allowed=f"1, or {count}", mend=mend)
    return described


def logs_and_axes(log: Any, axis: Any) -> list[tuple[Log, Axis | None]]:
    """Return one log or several, each with what is known of its axis: one axis for all, or as many as logs."""
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    if not logs:
        raise InputError("names no log", path="log", mend="Give at least one")
    axes = axes_for(axis if isinstance(axis, (list, tuple)) else [axis], len(logs))
    return [log_and_axis(log, axis) for log, axis in zip(logs, axes, strict=True)]


def read_log(path: Readable, axis: Axis | Readable | dict[str, Any] | None = None, *, size_limit: int | str = SIZE_LIMIT) -> Log:
    """Return the log in a file, in SI of the axis, on a uniform grid of time.

    Parameters
    ----------
    path : path-like, bytes or file object
        A file of any format that ``bristle log --help`` names; ``FILE::TABLE`` names a table in it.
    axis : Axis, path-like or dict, optional
        The axis, or the file that describes it, or the tables that one would hold. Without it columns called as usual
        are taken, in the units that the log says.
    size_limit : int or str
        Largest file, and largest content that a file announces [byte], or text such as ``"2 GB"``.

    Returns
    -------
    Log
        All channels, each with unit and source column.

    Raises
    ------
    InputError
        If the axis file or the log cannot be used; the message names file, key or column, and the mend.
    """
    if axis is not None and not isinstance(axis, Axis):
        axis = files.read_axis(axis)
    return readers.read_log(path, axis, size_limit=size_of(size_limit))
