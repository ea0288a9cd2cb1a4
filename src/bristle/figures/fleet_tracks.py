"""Quantities of axes over time, with the temperature taken off, beside the evidence of a change and its threshold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core.typography import Scale, scale_of
from bristle.figures import style
from bristle.figures.labels import largest
from bristle.figures.lettering import shortened

if TYPE_CHECKING:
    from bristle.fleet.watched import Verdict

__all__ = ["fleet_tracks"]

ROW = 1.3  # inches
WIDEST = 1.25
ALARM: style.Look = {"color": "#a3356f", "linewidth": 1.4, "linestyle": "-"}
ONSET = "#f0dbe6"
LEVEL: style.Look = style.PREDICTED | {"linewidth": 1.4}


@style.styled
def fleet_tracks(verdicts: Sequence[Verdict], names: Sequence[str], first: str) -> Figure:
    """Return the tracks, a row for each: what was found of it over time, and how likely a change is.

    Parameters
    ----------
    verdicts : sequence of Verdict
        What is drawn.
    names : sequence of str
        What stands above each row.
    first : str
        Name of the first day; empty where logs are numbered only.
    """
    rows = len(verdicts)
    figure, grid = style.panels(0.95 + (ROW + 0.42) * rows, rows, 2, widths=(2.2, 1.0), top=0.52, gap=0.42, between=0.75)
    start = min(float(verdict.track.time[0]) for verdict in verdicts)
    begin = np.floor(start) if verdicts[0].track.is_dated else 0.0
    end = max(float(verdict.track.time[-1]) for verdict in verdicts) - begin
    for (left, right), verdict, name in zip(grid, verdicts, names, strict=True):
        days = verdict.track.time - begin
        _draw_level(left, verdict, days, begin)
        _draw_ratio(right, verdict, days, begin)
        style.title(left, name)
        for axes in (left, right):
            axes.set_xlim(-0.02 * end, 1.02 * end)
            axes.tick_params(labelbottom=axes in grid[-1])
    for axes in grid[-1]:
        axes.set_xlabel(f"Days since {first}" if first else "Log")
    marked = next((row[0] for row, verdict in zip(grid, verdicts, strict=True) if verdict.alarm), grid[0][0])
    style.legend_in_corner(figure, marked)
    return figure


def _draw_level(axes: Axes, verdict: Verdict, days: np.ndarray, begin: float) -> None:
    track = verdict.track
    level, fitted = (np.exp(values) if track.is_logarithmic else values for values in (verdict.level, verdict.fitted))
    scale = Scale(100.0, "%") if track.is_logarithmic else scale_of(track.unit, largest(level))
    if (alarm := verdict.alarm) is not None:
        low, high = (end - begin for end in alarm.onset_interval)
        axes.axvspan(low, high, color=ONSET, linewidth=0, zorder=0, label="onset, 95 % interval")
        axes.axvline(alarm.at - begin, label="alarm", **ALARM)
    axes.plot(days, level * scale.factor, "o", markersize=2.0, color=style.GREY, label="a day's logs")
    axes.plot(days, fitted * scale.factor, label="level", **LEVEL)
    name = track.quantity.removeprefix("friction.")
    axes.set_ylabel(scale.label(shortened(name, WIDEST, 8.0)))


def _draw_ratio(axes: Axes, verdict: Verdict, days: np.ndarray, begin: float) -> None:
    axes.plot(days, verdict.ratio, label="evidence", **LEVEL)
    axes.axhline(verdict.threshold, color=style.INK, linewidth=0.9, linestyle="--", label="threshold")
    if verdict.alarm is not None:
        axes.axvline(verdict.alarm.at - begin, label="_alarm", **ALARM)
    axes.set(ylim=(0.0, 1.1 * max(float(np.max(verdict.ratio)), verdict.threshold)), ylabel="Evidence [σ]")
