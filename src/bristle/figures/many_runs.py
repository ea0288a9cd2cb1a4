"""Figures of the runs of a study as distributions, and of the logs of a fleet with their intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle.core import scale_of
from bristle.figures import style
from bristle.figures.drawing import AT_TICKS, shortened
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.study.store import Runs


@style.styled
def study_spread(numbers: Mapping[str, Mapping[str, np.ndarray]], units: Sequence[str]) -> Figure:
    """Return the distribution of each number, with its median and its quantiles at 5 and 95 %."""
    grouped = any(len(groups) > 1 for groups in numbers.values())
    figure, panels = style.grid_of(len(numbers), top=0.5 if grouped else 0.25)
    for axes, (word, groups), unit in zip(panels, numbers.items(), units, strict=True):
        finite = {name: values[np.isfinite(values)] for name, values in groups.items()}
        pooled = np.concatenate(list(finite.values()))
        scale = scale_of(unit, style.largest(pooled))
        bars = int(np.clip(np.sqrt(pooled.size / len(finite)), 8, 60))
        for place, (name, values) in enumerate(finite.items()):
            edges = np.histogram_bin_edges(values * scale.factor, bars)
            share = style.shares(values * scale.factor, edges)
            if not grouped:
                axes.stairs(share, edges, fill=True, color=style.BARS, label="_bars")
            look = style.LINES[place % len(style.LINES)]
            axes.stairs(share, edges, color=look["color"], linestyle=look["linestyle"], linewidth=1.1, label=name)
        if not grouped and pooled.size:
            low, median, high = np.quantile(pooled, (0.05, 0.5, 0.95)) * scale.factor
            axes.axvline(median, label="median", **style.DASHED)
            axes.axvspan(low, high, color=style.PALE, linewidth=0, zorder=0, label="90 % of the runs")
        axes.set(ylim=(0.0, None), xlabel=scale.label(shortened(word, style.LONGEST, AT_TICKS)), ylabel="Share of the runs [%]")
    style.legend_in_corner(figure, panels[0])
    return figure


SPREAD = ReportFigure(
    name="spread",
    takes=("study", "spread"),
    draw=lambda study, spread: study_spread(
        {words: groups for words, _, groups in spread.values()}, [unit for _, unit, _ in spread.values()]
    ),
    alternative=lambda study, spread: f"Distribution of {', '.join(spread)} over the runs",
    caption=lambda study, spread: (
        "Distribution of each number over the runs. "
        + ("A line for each point of the grid." if study.described["grid"] else "Shaded: the middle 90 % of the runs.")
    ),
)


@style.styled
def fleet_parameters(runs: Runs, names: Sequence[str], apart: Mapping[str, np.ndarray]) -> Figure:
    """Return the parameters of a fleet, log by log."""
    figure, panels = style.grid_of(len(names), between=0.8)
    for axes, name in zip(panels, names, strict=True):
        _draw(axes, runs, name, apart[name])
        axes.set_xlabel("Number of the log")
    richest = max(panels, key=lambda axes: len(axes.get_legend_handles_labels()[1]))
    style.legend_in_corner(figure, richest)
    return figure


def _draw(axes: Axes, runs: Runs, name: str, apart: np.ndarray) -> None:
    columns, number = runs.columns, runs.columns["run"]
    tells = np.isfinite(columns[name]) & (columns[f"{name}.status"] == "identified")
    scale = scale_of(runs.described["columns"][name]["unit"], style.largest(np.median(np.abs(columns[name][tells]))))
    value, low, high = (columns[key] * scale.factor for key in (name, f"{name}.lower", f"{name}.upper"))
    # Beyond the range of most logs, and up to all of them if they are near.
    usual = np.quantile(value[tells], (0.05, 0.95))
    margin = 0.6 * float(np.ptp(usual)) or 0.1 * abs(float(usual[1])) or 1.0  # logs beyond end in an arrow
    bottom = max(float(usual[0]) - margin, float(value[tells].min()) - 0.3 * margin)
    top = min(float(usual[1]) + margin, float(value[tells].max()) + 0.3 * margin)
    strange = np.zeros(runs.count, dtype=bool)
    strange[apart] = True
    size = 3.4 if runs.count <= 60 else 2.0  # smaller markers for many logs
    axes.axhline(float(np.median(value[tells])), color=style.GREY, linewidth=0.8, linestyle="--", label="median")
    inside = (value >= bottom) & (value <= top)
    for chosen, fill, word in ((~strange, "full", "log, 95 % interval"), (strange, "none", "outlier")):
        chosen = chosen & tells & inside
        if chosen.any():
            ends = np.nan_to_num(np.abs([value - low, high - value]))[:, chosen]
            color = style.PREDICTED["color"] if fill == "full" else style.DOUBTFUL
            look = {"fmt": "o", "markersize": size, "fillstyle": fill, "linewidth": 0.8, "color": color}
            axes.errorbar(number[chosen], value[chosen], ends, label=word, **look)
    above, below = tells & (value > top), tells & (value < bottom)
    ends = np.concatenate([end[tells & inside & np.isfinite(end)] for end in (low, high)])
    bottom, top = min([bottom, *ends]), max([top, *ends])  # every interval lies inside
    beyond: style.Look = {"facecolors": "none", "edgecolors": style.DOUBTFUL, "s": 16, "label": "_beyond"}
    for chosen, marker, height, look in (
        (above, "^", 0.97, beyond),
        (below, "v", 0.03, beyond),
        (~tells, "|", 0.0, {"color": style.INK, "s": 49, "label": "no value", "clip_on": False}),
    ):
        axes.scatter(number[chosen], np.full(chosen.sum(), height), marker=marker, transform=axes.get_xaxis_transform(), **look)
    edge = 0.02 * (top - bottom)
    axes.set(ylim=(bottom - edge, top + edge), xlim=(float(number.min()) - 1.0, float(number.max()) + 1.0))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(scale.label(shortened(name, style.NARROW, AT_TICKS)))


FLEET = ReportFigure(
    name="fleet",
    takes=("fleet", "names", "apart"),
    draw=fleet_parameters,
    alternative=lambda runs, names, apart: f"{', '.join(names)} of each log with 95 % intervals",
    caption="Each log with its 95 % interval. The line is the median. A hollow point is an outlier. A tick at the bottom is a log that "
    "failed, or that does not identify this parameter. An arrow marks a value outside the panel.",
)
