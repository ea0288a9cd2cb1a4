"""`Channel`: one recorded signal, with its unit and the column it came from."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from bristle.core import Diagnostic, InputError, with_unit
from bristle.core.axis import CHANNELS
from bristle.core.content import NOWHERE, Origin
from bristle.core.edge import (
    KIND,
    TEXT,
    Converter,
    amount,
    array,
    guarded,
    instance,
    many,
    mapping,
    optional,
    taken,
)
from bristle.core.motion import RECORDED
from bristle.core.tabular import SIGNALS, Signal, Tabular, ranged
from bristle.core.variable import KINDS, Kind, Variable, unit_of

ROUNDING = 1e-12  # of the largest value: smaller differences are rounding
OFF_STEP = 0.01  # of a step: tolerance of a multiple


def quantisation(values: np.ndarray) -> float:
    """Return the smallest difference between two different values, zero if all are equal."""
    steps = np.diff(np.unique(values))
    steps = steps[steps > ROUNDING * np.max(np.abs(values), initial=0.0)]
    return float(steps.min()) if steps.size else 0.0


def clear_step(values: np.ndarray, *, most: float = 20) -> float:
    """Return the step of which all values are multiples, if samples differ by few steps; else 0."""
    finite = np.asarray(values, dtype=float)[np.isfinite(values)]
    step = quantisation(finite)
    if not step:
        return 0.0
    multiples = (finite - finite.min()) / step
    moves = np.abs(np.diff(multiples))
    # At most `most` steps between different samples: the median difference is no larger if the steps are clear.
    is_clear = np.median(moves[moves > OFF_STEP]) <= most
    return step if is_clear and np.max(np.abs(multiples - np.round(multiples))) < OFF_STEP else 0.0


COLUMN = array(finite=False)  # readers check the samples first and report the place of bad values


@guarded(
    values=COLUMN, recorded_step=optional(amount(Variable("1", "step of the recording", min=0.0)))
)
@dataclass(frozen=True, eq=False)
class Channel(NDArrayOperatorsMixin):
    """One recorded signal. NumPy, plots and calculations use it as the array of its samples.

    Parameters
    ----------
    values : ndarray, shape (sample_count,)
        The samples, read-only, in `unit`.
    unit : str
        SI unit for the kind of axis.
    column : str
        Name of the column in the file.
    recorded_step : float, optional
        Smallest difference between two different samples of the recording. State this step if `values` were resampled
        or filtered, because they no longer show it.
    """

    values: np.ndarray
    unit: str
    column: str
    recorded_step: float | None = None

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=float)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    @property
    def step(self) -> float:
        """Smallest difference between two different samples, the step of an encoder; 0 if all are equal."""
        return quantisation(self.values) if self.recorded_step is None else self.recorded_step

    # Channels compare by identity; compare samples through `values`.
    def __eq__(self, channel: object) -> bool:
        return self is channel

    def __ne__(self, channel: object) -> bool:
        return self is not channel

    def __hash__(self) -> int:
        return id(self)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype) if copy else np.asarray(self.values, dtype=dtype)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **arguments: Any) -> Any:
        plain = (operand.values if isinstance(operand, Channel) else operand for operand in inputs)
        return getattr(ufunc, method)(*plain, **arguments)

    def __len__(self) -> int:
        return self.values.size

    def __getitem__(self, place: Any) -> Any:
        return self.values[place]

    def __iter__(self) -> Iterator[float]:
        return iter(self.values)

    def __repr__(self) -> str:
        return f"Channel({len(self)} samples, {ranged(self.values, self.unit)}, column {self.column!r})"


def channel(name: str) -> Converter:
    """Return a converter for a `Channel`, or for its numbers in SI units of the axis."""

    def convert(value: Any, path: str, kind: Kind | None) -> Channel:
        unit = unit_of(CHANNELS[name], kind or KINDS[0])
        candidate = (
            value if isinstance(value, Channel) else Channel(COLUMN(value, path, kind), unit, name)
        )
        array()(candidate.values, path, kind)
        return candidate

    return convert


@dataclass(frozen=True, eq=False)
class LogData(Tabular):
    """Data of a log made by this package; `bristle.logs.log.Log` describes each field."""

    time: Channel = taken(channel("time"))
    position: Channel = taken(channel("position"))
    velocity: Channel | None = taken(optional(channel("velocity")), None)
    effort: Channel | None = taken(optional(channel("effort")), None)
    reference: Channel | None = taken(optional(channel("reference")), None)
    load: Channel | None = taken(optional(channel("load")), None)
    temperature: Channel | None = taken(optional(channel("temperature")), None)
    injected: tuple[Channel, ...] = taken(many(channel("effort"), single=True), ())
    sample_time: float = taken(amount(Variable("time", "time between samples", min=0.0)), 0.0)
    segments: tuple[slice, ...] = taken(many(instance(slice, "an object of class slice")), ())
    source: Path = taken(instance(Path, "a path", read=Path), Path())
    origin: Origin = taken(instance(Origin, "an Origin"), NOWHERE)
    notes: tuple[str, ...] = taken(many(TEXT), ())
    kind: Kind = taken(KIND, "translational")
    findings: tuple[Diagnostic, ...] = taken(
        many(instance(Diagnostic, "an object of class Diagnostic")), ()
    )
    regressors: tuple[Channel, ...] = taken(many(channel("load"), single=True), ())
    further: Mapping[str, Channel] = taken(
        mapping(instance(Channel, "an object of class Channel")), default_factory=dict
    )

    def __post_init__(self) -> None:
        for name, signal in self.channels():
            if signal.values.size != len(self):
                raise InputError(
                    "has more or fewer samples than time",
                    path=name,
                    value=signal.values.size,
                    allowed=f"{len(self)} samples",
                )
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
        """Duration of the recording without its gaps [s]."""
        return len(self) * self.sample_time

    @property
    def part(self) -> str:
        """Columns and time span of this log in its file: a file with two such parts gives two logs."""
        columns = ", ".join(
            channel.column for channel in (self.position, self.effort) if channel is not None
        )
        return f"columns {columns}, {self.time.values[0]:.6g} to {self.time.values[-1]:.6g} s"

    def is_part(self, part: str) -> bool:
        """Return whether another part of the same file, described as by `part`, shares columns and time with this log."""
        found, own = (
            re.fullmatch(r"columns (.*), (\S+) to (\S+) s", text, re.DOTALL)
            for text in (part, self.part)
        )
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
        """Recorded channels of the surroundings of the axis, by name."""
        of_motion = {name: getattr(self, name) for name in RECORDED}
        return {name: channel for name, channel in of_motion.items() if channel is not None} | dict(
            self.further
        )

    def channels(self) -> Iterator[tuple[str, Channel]]:
        """Yield name and channel of all recorded signals, known inputs last."""
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
            name: Signal(
                channel.values,
                channel.unit,
                SIGNALS[name].description
                if name in SIGNALS
                else "known column"
                if name.startswith("known.")
                else "known input",
            )
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


def _spacing(time: np.ndarray) -> float:
    """Return the time between samples [s] of a uniform grid."""
    steps = np.diff(time)
    typical = float(np.median(steps)) if steps.size else 0.0
    if not (typical > 0.0 and np.all(steps > 0.0)):
        raise InputError(
            "must increase from sample to sample",
            path="time",
            mend="Sort the samples, or give sample_time",
        )
    return typical
