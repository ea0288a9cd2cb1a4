"""Converters of arguments: an axis, a log or an experiment, as an object or as the file that describes it."""

import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from bristle import files
from bristle.core import (
    SIZE_LIMIT,
    Axis,
    Experiment,
    InputError,
    InputWarning,
    Readable,
    TooShortError,
    size_of,
)
from bristle.core.edge import Converter, instance
from bristle.core.values import looked_at
from bristle.logs import Log, is_table, readers

A = TypeVar("A")


# The readers import the checks of files, so they are imported only when a file is given.
def _read_axis(source: Any) -> Axis:
    return files.read_axis(source)


def _read_experiment(source: Any) -> Experiment:
    return files.read_experiment(source)


AXIS: Converter = instance(Axis, "an axis or an axis file", read=_read_axis)
"""Accepts an axis or its file."""
EXPERIMENT: Converter = instance(Experiment, "an experiment or its file", read=_read_experiment)
"""Accepts an experiment or its file."""
LOG: Converter = instance(Log, "a log", 'Write read_log("axis.csv", axis)')


def log_and_axis(log: Any, axis: Any, size_limit: int = SIZE_LIMIT) -> tuple[Log, Axis | None]:
    """Return a log and its axis, if known; read them if a path or a table of columns is given."""
    axis = None if axis is None else looked_at(AXIS, axis, "axis", None)
    if is_table(log):
        return Log.from_columns(log, axis=axis), axis
    read = partial(read_log, axis=axis, size_limit=size_limit)
    return looked_at(
        instance(Log, "a log or a log file", 'Write read_log("axis.csv", axis)', read),
        log,
        "log",
        None,
    ), axis


def axes_for(axis: Any, count: int) -> list[Any]:
    """Return an axis for each of `count` logs: a common axis, or a separate axis for each log."""
    described = (list(axis) if isinstance(axis, (list, tuple)) else [axis]) or [None]
    if len(described) == 1:
        return described * count
    if len(described) != count:
        mend = "Give one axis file for all logs, or one axis file per log in the same order"
        message = f"{len(described)} axis files for {'1 log' if count == 1 else f'{count} logs'}"
        raise InputError(
            message, path="axis", allowed=" or ".join(dict.fromkeys(("1", f"{count}"))), mend=mend
        )
    return described


def logs_and_axes(
    log: Any, axis: Any, *, size_limit: int = SIZE_LIMIT
) -> list[tuple[Log, Axis | None]]:
    """Return one or several logs, each with its axis: one axis for all logs, or one axis per log."""
    logs = list(log) if isinstance(log, (list, tuple)) else [log]
    if not logs:
        raise InputError("names no log", path="log", mend="Give at least one log")
    return without_short(
        [
            partial(log_and_axis, log, of_log, size_limit)
            for log, of_log in zip(logs, axes_for(axis, len(logs)), strict=True)
        ]
    )


def without_short(pairs: Iterable[Callable[[], tuple[Log, A]]]) -> list[tuple[Log, A]]:
    """Return the logs with their axes; of several, leave out those that are too short, with a warning, and a note in the first other."""
    usable, short = [], []
    for pair in pairs:
        try:
            usable.append(pair())
        except TooShortError as error:
            short.append(error)
    if len(short) == 1 and not usable:
        raise short[0]
    facts = [
        f"{error.path} {error.message} ({error.value} instead of {error.allowed})"
        for error in short
    ]
    if not usable:
        raise TooShortError(
            f"all {len(short)} logs are too short: {', '.join(facts)}",
            path="log",
            mend=short[0].mend,
        )
    (first, axis), *further = usable
    for fact in facts:
        first = replace(first, notes=(*first.notes, f"bristle leaves out a log: {fact}"))
        warnings.warn(first.notes[-1], InputWarning, stacklevel=2)
    return [(first, axis), *further]


def read_log(
    path: Readable,
    axis: Axis | Readable | dict[str, Any] | None = None,
    *,
    size_limit: int | str = SIZE_LIMIT,
) -> Log:
    """Return the log in a file, in SI units of the axis, on a uniform time grid.

    Parameters
    ----------
    path : path-like, bytes or file object
        A file in a format that ``bristle log --help`` lists; ``FILE::TABLE`` selects a table.
    axis : Axis, path-like or dict, optional
        The axis, its axis file, or the tables of an axis file. Without it, bristle uses columns with common names, in
        the units that the log states.
    size_limit : int or str
        Limit for the file and for the content that it announces [byte], or text such as ``"2 GB"``.

    Returns
    -------
    Log
        All channels, with unit and source column.

    Raises
    ------
    InputError
        If the axis file or the log cannot be used; the message names the file, the key or column, and the remedy.
    """
    if axis is not None and not isinstance(axis, Axis):
        axis = files.read_axis(axis)
    return readers.read_log(path, axis, size_limit=size_of(size_limit))
