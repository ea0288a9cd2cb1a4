"""A study: how the numbers of many runs are distributed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import scale_of
from bristle.figures import style
from bristle.figures.drawing import AT_TICKS
from bristle.figures.labels import largest
from bristle.figures.lettering import shortened
from bristle.figures.report_figure import ReportFigure


@style.styled
def study_spread(numbers: Mapping[str, Mapping[str, np.ndarray]], units: Sequence[str]) -> Figure:
    """Return the distribution of each number, with its median and its quantiles at 5 and 95 %."""
    grouped = any(len(groups) > 1 for groups in numbers.values())
    figure, panels = style.grid_of(len(numbers), top=0.5 if grouped else 0.25)
    for axes, (word, groups), unit in zip(panels, numbers.items(), units, strict=True):
        finite = {name: values[np.isfinite(values)] for name, values in groups.items()}
        pooled = np.concatenate(list(finite.values()))
        scale = scale_of(unit, largest(pooled))
        bars = int(np.clip(np.sqrt(pooled.size / len(finite)), 8, 60))
        for place, (name, values) in enumerate(finite.items()):
            edges = np.histogram_bin_edges(values * scale.factor, bars)
            share = np.histogram(values * scale.factor, edges)[0] * (100.0 / max(values.size, 1))
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


FIGURE = ReportFigure(
    name="spread",
    takes=("study", "spread"),
    draw=lambda study, spread: study_spread(
        {words: groups for words, _, groups in spread.values()}, [unit for _, unit, _ in spread.values()]
    ),
    alternative=lambda study, spread: f"Distribution of {', '.join(spread)} over the runs",
    caption=lambda study, spread: (
        "How often the runs come out at which value. "
        + ("A line for each point of the grid." if study.described["grid"] else "Shaded are the 90 % in the middle.")
    ),
)
