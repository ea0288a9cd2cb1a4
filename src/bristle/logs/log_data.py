"""What was recorded of a motion axis, as it is computed with: what readers make, and what a `Log` holds."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.content import NOWHERE, Origin
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.motion import RECORDED
from bristle.core.tabular import SIGNALS, Signal, Tabular
from bristle.core.typography import with_unit
from bristle.core.variable import Kind
from bristle.logs.channel import CHANNELS, Channel

__all__ = ["LogData"]


_PART = re.compile(r"columns (.*), (\S+) to (\S+) s", re.DOTALL)


@dataclass(frozen=True, eq=False)
class LogData(Tabular):
    """The data of a log, which nobody has handed in from outside; `bristle.logs.log.Log` says what each is."""

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
    findings: tuple[Diagnostic, ...] = ()
    regressors: tuple[Channel, ...] = ()
    further: Mapping[str, Channel] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, signal in self.channels():
            if signal.values.size != len(self):
                raise InputError("has another length than time", path=name, value=signal.values.size, allowed=f"{len(self)} samples")
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
    def part(self) -> str:
        """Which columns of its file it is, and from when to when: two parts of one file are two logs."""
        columns = ", ".join(channel.column for channel in (self.position, self.effort) if channel is not None)
        return f"columns {columns}, {self.time.values[0]:.6g} to {self.time.values[-1]:.6g} s"

    def is_part(self, part: str) -> bool:
        """Return whether another part of its file, as `part` tells it, has columns and a time in common with it."""
        found, own = (_PART.fullmatch(text) for text in (part, self.part))
        if found is None or own is None:
            return True
        (columns, *ends), (own_columns, *own_ends) = found.groups(), own.groups()
        (first, last), (own_first, own_last) = (map(float, pair) for pair in (ends, own_ends))
        return columns == own_columns and first <= own_last and own_first <= last

    @property
    def injected_effort(self) -> np.ndarray:
        """Sum of the known inputs, shape (sample_count,) [N or N*m]."""
        return sum((channel.values for channel in self.injected), np.zeros(len(self)))

    @property
    def surroundings(self) -> dict[str, Channel]:
        """What was recorded of the surroundings of the axis, by name."""
        of_motion = {name: getattr(self, name) for name in RECORDED}
        return {name: channel for name, channel in of_motion.items() if channel is not None} | dict(self.further)

    def channels(self) -> Iterator[tuple[str, Channel]]:
        """Yield the name and the channel of all that was recorded, known inputs last."""
        for name in CHANNELS:
            channel = getattr(self, name)
            if channel is not None:
                yield name, channel
        yield from self.further.items()
        for channel in self.injected:
            yield f"injected.{channel.column}", channel
        for channel in self.regressors:
            yield f"known.{channel.column}", channel

    def _signals(self) -> dict[str, Signal]:
        return {
            name: Signal(channel.values, channel.unit, SIGNALS[name].description if name in SIGNALS else _about(name))
            for name, channel in self.channels()
        }

    def _facts(self) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "sample_time": self.sample_time,
            "source": self.origin.name or self.source.name,
            "checksum": self.origin.checksum,
            "columns": {name: channel.column for name, channel in self.channels()},
            "segments": [[segment.start, segment.stop] for segment in self.segments],
            "notes": list(self.notes),
        }

    def _title(self) -> str:
        source = self.origin.name or self.source.name
        extent = f"{with_unit(self.duration, 's')} at {with_unit(1.0 / self.sample_time, 'Hz')}"
        return f"Log of {len(self)} samples, {extent}, {self.kind}{f', from {source}' if source else ''}"

    def _remarks(self) -> list[str]:
        parts = [f"{len(self.segments)} segments without a gap"] if len(self.segments) > 1 else []
        return [*parts, *self.notes]


def _about(name: str) -> str:
    return "known column" if name.startswith("known.") else "known input"


def _spacing(time: np.ndarray) -> float:
    """Return the time between samples [s] of a grid that nobody told."""
    steps = np.diff(time)
    typical = float(np.median(steps)) if steps.size else 0.0
    if not (typical > 0.0 and np.all(steps > 0.0)):
        raise InputError("must rise from sample to sample", path="time", mend="Sort the samples, or give sample_time")
    return typical
