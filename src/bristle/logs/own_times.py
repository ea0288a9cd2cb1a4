"""Files whose channels bring their own times: how such channels make a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Table

__all__ = ["TIME", "Series", "table_of_series"]

TIME = "time"


@dataclass(frozen=True, eq=False)
class Series:
    """A channel with its times."""

    name: str
    values: np.ndarray | None
    times: np.ndarray | None
    unit: str = ""
    about: str = ""


def table_of_series(
    series: Iterable[Series],
    source: Path,
    kind: str,
    *,
    time_unit: str = "s",
    notes: Sequence[str] = (),
    texts: Mapping[str, InputError] | None = None,
    facts: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    tables: Sequence[str] = (),
) -> Table:
    """Return the table of channels that bring their own times: one column of time for all that share theirs."""
    channels = [channel for channel in series if channel.values is None or channel.values.size]
    if not channels:
        raise InputError("holds no column of numbers", path=str(source), mend="Export the signals with their times")
    names_used = {channel.name for channel in channels}
    clocks: dict[str, np.ndarray] = {}
    stamps: dict[str, str] = {}
    for channel in channels:
        if channel.values is None or channel.times is None:
            continue
        name = next((name for name, clock in clocks.items() if np.array_equal(clock, channel.times)), None)
        if name is None:
            name = TIME if not clocks else f"{TIME} of {channel.name}"
            while name in names_used:
                name = f"{name}_"
            clocks[name] = np.asarray(channel.times, dtype=float)
        stamps[channel.name] = name
    columns = clocks | {channel.name: channel.values for channel in channels if channel.values is not None}
    units = dict.fromkeys(clocks, time_unit) | {channel.name: channel.unit for channel in channels if channel.unit}
    return Table(
        columns,
        units,
        constants or {},
        texts or {},
        notes=tuple(notes),
        format=kind,
        tables=tuple(tables),
        names=(*clocks, *(channel.name for channel in channels)),
        stamps=stamps,
        facts=facts or {},
        about={channel.name: channel.about for channel in channels if channel.about},
        source=source,
    )
