"""Summarise a log: columns, rates, ranges, and all problems for which bristle would refuse it."""

from typing import Any, NamedTuple

import numpy as np

from bristle.core import SIZE_LIMIT, Axis, InputError, Readable, guarded, printable, size_of
from bristle.logs.assembly import assembled, clock_for
from bristle.logs.channel import Channel, quantisation
from bristle.logs.check import CheckThresholds, checked
from bristle.logs.gather import axis_of, gather
from bristle.logs.log import Log, log_of
from bristle.logs.passages import Passage, passages
from bristle.logs.problems import problems_of
from bristle.logs.readers import read_table, with_known
from bristle.logs.table import Table


class Summary(NamedTuple):
    """Summary of a log as plain data, and the log itself with its experiments if it has no problem."""

    data: dict[str, Any]
    log: Log | None = None
    passages: tuple[Passage, ...] = ()


@guarded()
def summarize(
    given: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT
) -> dict[str, Any]:
    """Return a summary of a log, as plain data.

    Parameters
    ----------
    given : path-like, bytes, file object or Content
        The file.
    axis : Axis, optional
        Names of the columns; without it, bristle uses columns with usual names.
    size_limit : int
        Largest file, and largest content announced by a file [byte].

    Returns
    -------
    dict
        ``file``, ``format``, ``checksum``, ``columns`` (as in the file: name, unit, samples, min, max, mean, std, step),
        ``constants``, ``channels`` (the same in SI units of the axis), ``sample_time`` [s], ``rate`` [Hz], ``duration`` [s],
        ``segments``, ``passages`` (the experiments in it: `bristle.logs.Passage`), ``notes``, ``diagnostics`` (findings of
        the checks, as data) and ``problems``; None if unknown.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    return summary_of(
        with_known(read_table(given, axis and axis.table, size_limit=size_of(size_limit)), axis),
        axis,
    ).data


def summary_of(table: Table, axis: Axis | None = None) -> Summary:
    """Return the summary of the table of a log; without an axis, from columns with usual names."""
    summary = summary_of_columns(table).data
    log, experiments = None, ()
    try:
        part, log, experiments = _as_log(table, axis or axis_of(table))
        summary |= part
    except InputError as problem:
        summary["problems"] = [_sentence_of(problem, table)]
    if summary["sample_time"]:
        summary["rate"] = 1 / summary["sample_time"]
    return Summary(summary, log, experiments)


def summary_of_columns(table: Table) -> Summary:
    """Return the summary of the columns of a table without recognised channels."""
    data = {
        "file": printable(table.origin.name),
        "format": table.format,
        "checksum": table.origin.checksum,
        "columns": [
            {"name": name, "unit": table.units.get(name), **_range(values)}
            for name, values in table.columns.items()
        ],
        "constants": dict(table.constants),
        "kind": None,
        "channels": [],
        "sample_time": table.sample_time,
        "rate": None,
        "duration": None,
        "segments": None,
        "passages": [],
        "notes": list(table.notes),
        "diagnostics": [],
        "problems": [],
    }
    return Summary(data)


def _as_log(table: Table, axis: Axis) -> Summary:
    gathered = gather(table, axis)
    problems = [*gathered.problems, *problems_of(gathered, str(table.source))]
    part: dict[str, Any] = {
        "kind": axis.kind,
        "notes": gathered.notes,
        "channels": [_entry(name, channel) for name, channel in gathered.named()],
    }
    channels = [gathered.channels.get("time"), gathered.motion]
    fit = all(
        channel is None or (channel.values.size > 1 and np.all(np.isfinite(channel.values)))
        for channel in channels
    )
    clock = None
    try:
        if fit and channels[1]:
            clock = clock_for(table, axis, gathered)
    except InputError as problem:
        problems.append(problem)
    if clock is not None:
        part |= {
            "sample_time": clock.sample_time,
            "segments": len(clock.pieces),
            "duration": clock.time.size * clock.sample_time,
            "notes": [*gathered.notes, *clock.notes],
        }
    log, experiments = None, ()
    if clock is not None and not problems:
        log = log_of(assembled(table, axis, gathered, clock))
        part["notes"] = list(log.notes)
        if "position" not in gathered.channels:
            entry = _entry("position", log.position) | {"step": log.position.step or None}
            part["channels"].insert(
                [of["name"] for of in part["channels"]].index("velocity"), entry
            )
        part["diagnostics"] = [
            diagnostic.as_data()
            for diagnostic in checked(log, axis, CheckThresholds.among(axis.settings))
        ]
        experiments = passages(log, axis)
        part["passages"] = [passage.as_data() for passage in experiments]
    return Summary(
        part | {"problems": [_sentence_of(problem, table) for problem in problems]},
        log,
        experiments,
    )


def _sentence_of(problem: InputError, table: Table) -> str:
    """Return the sentence of a problem, with the name of the file but without its folder."""
    path = problem.path.replace(str(table.source), table.origin.name, 1)
    return str(
        InputError(
            problem.message,
            path=path,
            value=problem.value,
            allowed=problem.allowed,
            mend=problem.mend,
        )
    )


def _entry(name: str, channel: Channel) -> dict[str, Any]:
    return {"name": name, "column": channel.column, "unit": channel.unit, **_range(channel.values)}


def _range(values: np.ndarray) -> dict[str, Any]:
    finite = values[np.isfinite(values)]
    statistics: dict[str, Any] = {"samples": int(values.size)}
    if not finite.size:
        return statistics | dict.fromkeys(("min", "max", "mean", "std", "step"))
    statistics |= {"min": float(finite.min()), "max": float(finite.max())}
    with np.errstate(over="ignore", invalid="ignore"):
        mean, std = float(finite.mean()), float(finite.std())
    extras = {"mean": mean, "std": std, "step": quantisation(finite) or None}
    return statistics | {
        name: value if value is None or np.isfinite(value) else None
        for name, value in extras.items()
    }
