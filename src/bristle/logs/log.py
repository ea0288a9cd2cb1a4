"""`Log`: what was recorded of a motion axis, each channel with its unit and the column it came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.axis import CHANNELS
from bristle.core.content import NOWHERE, Origin
from bristle.core.edge import KIND, TEXT, Converter, amount, array, guarded, instance, many, optional
from bristle.core.errors import InputError
from bristle.core.variable import KINDS, Kind, Variable, unit_of

__all__ = ["CHANNELS", "Channel", "Log"]


COLUMN = array(finite=False)  # what a file holds is looked at, and its place told, before it becomes a log


@guarded(values=COLUMN, unit=TEXT, column=TEXT)
@dataclass(frozen=True, eq=False)
class Channel:
    """One recorded signal.

    Parameters
    ----------
    values : ndarray, shape (sample_count,)
        The samples, read-only, in `unit`.
    unit : str
        SI of the kind of axis.
    column : str
        Name of the column in the file.
    """

    values: np.ndarray
    unit: str
    column: str

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=float)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)


def channel(name: str) -> Converter:
    """Return what takes a `Channel`, or the numbers of one in SI of the kind of axis."""

    def taken(given: Any, path: str, kind: Kind | None) -> Channel:
        unit = unit_of(CHANNELS[name], kind or KINDS[0])
        found = given if isinstance(given, Channel) else Channel(COLUMN(given, path, kind), unit, name)
        array()(found.values, path, kind)
        return found

    return taken


@guarded(
    **{name: optional(channel(name)) for name in CHANNELS} | {name: channel(name) for name in ("time", "position")},
    injected=many(channel("effort"), single=True),
    sample_time=amount(Variable("time", "time between samples", min=0.0)), segments=many(instance(slice, "a slice")),
    source=instance(Path, "a path", read=Path),    origin=instance(Origin, "an Origin"), notes=many(TEXT), kind=KIND,
)  # fmt: skip
@dataclass(frozen=True, eq=False)
class Log:
    """What was recorded of a motion axis, in SI of its kind, on a uniform grid of time.

    Parameters
    ----------
    time : Channel or array_like, shape (sample_count,)
        Time [s]. Uniform within a segment. Here and below numbers without a channel are in SI.
    position : Channel or array_like
        Position [m or rad].
    velocity, effort, reference : Channel or None
        Velocity [m/s or rad/s], effort [N or N*m], reference of position [m or rad]; None where not recorded.
    load, temperature : Channel or None
        Normal load over its nominal value, temperature [K]; None where not recorded.
    injected : tuple of Channel
        Known inputs added to the controller's output [N or N*m]; `effort` contains them.
    sample_time : float
        Time between samples [s]; 0 stands for that of `time`.
    segments : tuple of slice
        Stretches without a gap; a derivative or a filter must not reach over their ends. All in one where not given.
    source : Path
        The file.
    origin : Origin
        Name and SHA-256 of the file, and the table in it.
    notes : tuple of str
        What was resampled, left out or assumed.
    kind : {"translational", "rotational"}
        Kind of axis.
    """

    time: Channel
    position: Channel
    velocity: Channel | None = None
    effort: Channel | None = None
    reference: Channel | None = None
    load: Channel | None = None
    temperature: Channel | None = None
    injected: tuple[Channel, ...] = ()
    sample_time: float = 0.0
    segments: tuple[slice, ...] = ()
    source: Path = Path()
    origin: Origin = NOWHERE
    notes: tuple[str, ...] = ()
    kind: Kind = "translational"

    def __post_init__(self) -> None:
        for name, one in self.channels():
            if one.values.size != len(self):
                raise InputError("has another length than time", path=name, value=one.values.size,
                                 allowed=f"{len(self)} samples")  # fmt: skip
        if len(self) == 0:
            raise InputError("has no samples", path="time")
        if not self.sample_time:
            object.__setattr__(self, "sample_time", _spacing(self.time.values))
        if not self.segments:
            object.__setattr__(self, "segments", (slice(0, len(self)),))

    def __len__(self) -> int:
        return self.time.values.size

    @property
    def duration(self) -> float:
        """Time covered by samples, gaps left out [s]."""
        return len(self) * self.sample_time

    @property
    def injected_effort(self) -> np.ndarray:
        """Sum of the known inputs, shape (sample_count,) [N or N*m]."""
        return sum((channel.values for channel in self.injected), np.zeros(len(self)))

    def channels(self) -> Iterator[tuple[str, Channel]]:
        """Yield the name and the channel of all that was recorded, known inputs last."""
        for name in CHANNELS:
            channel = getattr(self, name)
            if channel is not None:
                yield name, channel
        for channel in self.injected:
            yield f"injected.{channel.column}", channel


def _spacing(time: np.ndarray) -> float:
    """Return the time between samples [s] of a grid that nobody told."""
    steps = np.diff(time)
    typical = float(np.median(steps)) if steps.size else 0.0
    if not (typical > 0.0 and np.all(steps > 0.0)):
        raise InputError("must rise from sample to sample", path="time", mend="Sort the samples, or give sample_time")
    return typical
