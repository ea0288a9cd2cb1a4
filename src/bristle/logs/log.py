"""`Log`: what was recorded of a motion axis, each channel with its unit and the column it came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bristle.core.content import NOWHERE, Origin
from bristle.core.variable import Kind

__all__ = ["CHANNELS", "Channel", "Log"]

# Channel -> generalised quantity.
CHANNELS = {
    "time": "time",
    "position": "length",
    "velocity": "length/time",
    "effort": "force",
    "reference": "length",
    "load": "1",
    "temperature": "temperature",
}


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


@dataclass(frozen=True, eq=False)
class Log:
    """What was recorded of a motion axis, in SI of its kind, on a uniform grid of time.

    Parameters
    ----------
    time : Channel
        Time [s]. Uniform within a segment.
    position : Channel
        Position [m or rad].
    velocity, effort, reference : Channel or None
        Velocity [m/s or rad/s], effort [N or N*m], reference of position [m or rad]; None where not recorded.
    load, temperature : Channel or None
        Normal load over its nominal value, temperature [K]; None where not recorded.
    injected : tuple of Channel
        Known inputs added to the controller's output [N or N*m]; `effort` contains them.
    sample_time : float
        Time between samples [s].
    segments : tuple of slice
        Stretches without a gap; a derivative or a filter must not reach over their ends.
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
    sample_time: float = 1.0
    segments: tuple[slice, ...] = ()
    source: Path = Path()
    origin: Origin = NOWHERE
    notes: tuple[str, ...] = ()
    kind: Kind = "translational"

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
