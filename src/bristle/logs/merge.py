"""Channels that were recorded each at its own times, on the times of one of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bristle.core import units
from bristle.core.diagnostic import Diagnostic, Number
from bristle.logs.channel import Channel
from bristle.logs.order import median_step
from bristle.logs.table import Table

if TYPE_CHECKING:
    from bristle.logs.gather import Gathered

__all__ = ["onto_one_time"]

COINCIDES = 1e-6  # of the sample time: stamps this close are one


def onto_one_time(table: Table, gathered: Gathered) -> None:
    """Bring all channels to the times at which the position was recorded, or without one the velocity.

    Where a channel has a sample at such a time it is taken as it is, else it is interpolated; what lies before the
    first sample or after the last one of any channel is left out.
    """
    motion = gathered.motion
    if motion is None:
        return
    own = table.stamps[motion.column]
    clocks = {name: _seconds(table, name) for name in set(table.stamps.values())}
    base = clocks[own]
    elsewhere = [
        (key, channel) for key, channel in gathered.named() if channel.column in table.stamps and table.stamps[channel.column] != own
    ]
    inside = np.ones(base.size, dtype=bool)
    step = median_step(base) if base.size > 1 else 0.0
    for _, channel in elsewhere:
        clock = clocks[table.stamps[channel.column]]
        inside &= (base >= clock[0] - COINCIDES * step) & (base <= clock[-1] + COINCIDES * step)
    times_kept = base[inside]
    on_time = {id(channel): _on(times_kept, clocks[table.stamps[channel.column]], channel, gathered, step) for _, channel in elsewhere}

    def brought(channel: Channel) -> Channel:
        if id(channel) in on_time:
            return on_time[id(channel)]
        return channel if channel.values.size != base.size else replace(channel, values=channel.values[inside])

    gathered.channels = {"time": Channel(times_kept, "s", own), **{name: brought(channel) for name, channel in gathered.channels.items()}}
    gathered.injected = [brought(channel) for channel in gathered.injected]
    left = base.size - times_kept.size
    if left:
        gathered.notes.append(f"{left} samples were left out, at which not all channels were recorded")


def _seconds(table: Table, name: str) -> np.ndarray:
    return table.columns[name] * units.factor(table.units.get(name, "s"), "s", path=str(table.source))


def _on(times: np.ndarray, stamps: np.ndarray, channel: Channel, gathered: Gathered, step: float) -> Channel:
    """Return a channel at other times than its own."""
    stamps, first = np.unique(stamps, return_index=True)
    values = channel.values[first]
    near = np.clip(np.searchsorted(stamps, times - COINCIDES * step), 0, stamps.size - 1)
    coincides = np.abs(stamps[near] - times) <= COINCIDES * step
    if coincides.all() or stamps.size < 4:
        return replace(channel, values=values[near])
    from scipy.interpolate import CubicSpline

    between = np.where(coincides, values[near], CubicSpline(stamps, values)(times))
    half = CubicSpline(stamps[::2], values[::2])(stamps[1:-1:2]) if stamps.size > 8 else values[1:-1:2]
    error = float(np.sqrt(np.mean((half - values[1:-1:2]) ** 2)))
    numbers: dict[str, Number] = {
        "column": channel.column,
        "sample_time": step,
        "own_sample_time": median_step(stamps),
        "percent": 100.0 * float(np.mean(~coincides)),
        "error_percent": 100.0 * error / max(float(np.std(values)), 1e-300),
    }
    gathered.findings.append(Diagnostic("rates_differ", "", "warning", numbers))
    return replace(channel, values=between)
