"""A look at a log before anything is fitted to it: what it contradicts, and what it cannot tell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.core.edge import guarded, instance, optional
from bristle.logs.channel import LogData
from bristle.logs.check.channels import about_effort, about_rows, about_velocity, lost_in
from bristle.logs.check.line import about_line
from bristle.logs.check.motion import about_motion, about_sliding
from bristle.logs.check.rows import rows_of
from bristle.logs.check.sign import work_share
from bristle.logs.check.thresholds import DEFAULT, CheckThresholds
from bristle.logs.check.units import about_units

__all__ = ["RECORDED", "CheckThresholds", "checked", "parted"]

RECORDED = (
    "rows_lost",
    "sign_reversed",
    "clock_suspect",
    "unit_suspect",
    "velocity_contradicts",
    "gear_suspect",
    "clipped",
    "saturates",
    "effort_unsigned",
    "stamps_jitter",
    "rates_differ",
    "unit_contradicts",
    "beyond_limit",
    "beyond_stroke",
    "resolution_contradicts",
)
"""Codes of what is wrong with a recording, whatever it is used for."""

AnyLog = TypeVar("AnyLog", bound=LogData)

SHORTEST = 10  # samples of a stretch between lost rows


@guarded(
    log=instance(LogData, "a log", "Write read_log(...)"),
    axis=optional(instance(Axis, "an axis")),
    settings=instance(CheckThresholds, "thresholds"),
)
def checked(log: LogData, axis: Axis | None = None, settings: CheckThresholds = DEFAULT) -> tuple[Diagnostic, ...]:
    """Return what a log says against itself and against what is told of its axis, before anything is fitted.

    Parameters
    ----------
    log : Log
        Its channels, in SI.
    axis : Axis, optional
        Mass, resolution, limits and units, as far as they are known.
    settings : CheckThresholds
        From where on something is said.

    Returns
    -------
    tuple of Diagnostic
        Gravest first. Each has a code, numbers, and a sentence that says how to mend it.
    """
    return tuple(_checked(log, axis or Axis(kind=log.kind), settings))


def _checked(log: LogData, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    yield from log.findings
    resolution = _resolution(log, axis)
    starts = lost_in(log, resolution, settings.lost_step)
    yield from about_rows(log, starts)
    log = _parted(log, starts)
    share = work_share(log)
    reversed_sign = share < -settings.reversed_work
    if reversed_sign:
        yield Diagnostic("sign_reversed", "", "error", {"percent": -100.0 * share}, log.kind)
    rows = rows_of(log, resolution)
    yield from about_units(log, rows, axis, settings)
    yield from about_velocity(log, rows, axis, resolution, settings)
    if log.effort is not None:
        cut = tuple(about_effort(log, rows, axis, resolution, settings))
        yield from cut
        yield from about_sliding(log, rows, axis, share, resolution, settings)
        if not reversed_sign:
            yield from about_line(rows, axis, settings, clipped=bool(cut))
    yield from about_motion(log, resolution, settings)


def parted(log: AnyLog, axis: Axis | None = None, settings: CheckThresholds = DEFAULT) -> AnyLog:
    """Return a log with the places where rows are missing between its segments, so that nothing goes across them."""
    return _parted(log, lost_in(log, _resolution(log, axis), settings.lost_step))


def _resolution(log: LogData, axis: Axis | None) -> float:
    return (axis and axis.resolution) or log.position.step


def _parted(log: AnyLog, starts: np.ndarray) -> AnyLog:
    """Return a log whose segments end at the samples `starts`, before missing rows."""
    if not starts.size:
        return log
    segments = []
    for segment in log.segments:
        first, last, _ = segment.indices(len(log))
        inside = starts[(starts >= first) & (starts < last - 1)] + 1
        ends = [first, *inside.tolist(), last]
        segments += [slice(a, b) for a, b in pairwise(ends) if b - a >= SHORTEST]
    return replace(log, segments=tuple(segments)) if segments else log
