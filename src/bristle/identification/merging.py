"""Several logs of one axis as one regression."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.identification.dataset import Dataset
from bristle.identification.delay import delay_in, shifted
from bristle.identification.preprocessing import treat
from bristle.logs.log import Log

__all__ = ["treat_all"]

ALIKE = 1e-3  # relative difference of sample times that is none


def treat_all(
    logs: Sequence[Log], axes: Sequence[Axis | None], cutoff: float | None = None, decimation: int | None = None,
    delay: float | None = None,
) -> Dataset:  # fmt: skip
    """Return the regression rows of several logs, one after the other.

    Parameters
    ----------
    logs : sequence of Log
        Logs of the same axis.
    axes : sequence of Axis or None
        What is known of the axis as each log records it.
    cutoff, decimation : float, int, optional
        As in `treat`; the same for all logs.
    delay : float, optional
        By how much the effort lags the position [s]. Where it is not given, an axis may ask for it to be found.

    Raises
    ------
    InputError
        If a log does not serve, or they are of different kinds, sample times, or treatments.
    """
    parts = [treat(log, axis, cutoff, decimation) for log, axis in zip(logs, axes, strict=True)]
    first = parts[0]
    for log, part in zip(logs, parts, strict=True):
        _refuse_unlike(log, part, first)
    segments, end = [], first.segments[0].time[0]
    for number, part in enumerate(parts):
        # Rows are told apart by their time: a log begins where the one before it ends.
        later = end - part.segments[0].time[0]
        segments += [replace(segment, log=number, time=segment.time + later) for segment in part.segments]
        end = segments[-1].time[-1] + first.sample_time
    merged = replace(
        first,
        segments=tuple(segments),
        resolution=max(part.resolution for part in parts),
        noise=float(np.sqrt(np.mean([part.noise**2 for part in parts]))),
        effort_noise=float(np.sqrt(np.mean([part.effort_noise**2 for part in parts]))),
    )
    if delay is None and any(axis is not None and axis.seeks_delay for axis in axes):
        delay, _ = delay_in(merged)
    return shifted(merged, delay) if delay else merged


def _refuse_unlike(log: Log, part: Dataset, first: Dataset) -> None:
    path = f"log {log.source.name}"
    if part.kind != first.kind:
        raise InputError(
            "is of another kind of axis than the first log", path=path, value=part.kind, allowed=first.kind
        )
    if abs(part.sample_time / first.sample_time - 1.0) > ALIKE:
        times = (with_unit(time, "s") for time in (part.sample_time, first.sample_time))
        period, first_period = times
        raise InputError(f"was sampled every {period}, the first log every {first_period}", path=path,
                         mend="Resample one of them, or identify them one by one")  # fmt: skip
    for name in ("cutoff", "decimation", "held"):
        if getattr(part, name) != getattr(first, name):
            raise InputError(f"is to be treated with another {name} than the first log", path=path,
                             value=getattr(part, name), mend="Write the same into both axis files")  # fmt: skip
