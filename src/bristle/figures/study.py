"""A study: how the numbers of many runs are distributed, and which cause matters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import scale_of
from bristle.figures import style
from bristle.figures.drawing import AT_TICKS
from bristle.figures.labels import largest
from bristle.figures.lettering import shortened
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.study.dataset import Runs

__all__ = ["FIGURE", "INFLUENCE", "study_influence", "study_spread"]


@style.styled
def study_spread(numbers: Mapping[str, Mapping[str, np.ndarray]], units: Sequence[str]) -> Figure:
    """Return the distribution of each number, with its median and its quantiles at 5 and 95 %.

    Parameters
    ----------
    numbers : mapping of str to (mapping of str to ndarray, shape (run,))
        By what stands at the axis, and there by the name of a group of runs: at most five of them, or a single one.
    units : sequence of str
        The unit in SI of each.
    """
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


Spread = Mapping[str, tuple[str, str, Mapping[str, np.ndarray]]]
"""By metric, what stands at the axis, the unit, and the groups of runs."""


def _draw(study: Runs, spread: Spread) -> Figure:
    return study_spread({words: groups for words, _, groups in spread.values()}, [unit for _, unit, _ in spread.values()])


def _caption(study: Runs, spread: Spread) -> str:
    lines = "A line for each point of the grid." if study.described["grid"] else "Shaded are the 90 % in the middle."
    return f"How often the runs come out at which value. {lines}"


FIGURE = ReportFigure(
    name="spread",
    takes=("study", "spread"),
    draw=_draw,
    alternative=lambda study, spread: f"Distribution of {', '.join(spread)} over the runs",
    caption=_caption,
)


Bar = tuple[float, tuple[float, float]]


@style.styled
def study_influence(causes: Sequence[str], bars: Mapping[str, Sequence[Bar]], word: str, *, signed: bool) -> Figure:
    """Return a row for each cause, with a mark and its 95 % interval for each kind of number.

    Parameters
    ----------
    causes : sequence of str
        The causes, the strongest first.
    bars : mapping of str to sequence of (value, (low, high))
        By what the numbers are, one for each cause.
    word : str
        What stands at the axis.
    signed : bool
        Whether they range from -1 to 1, else from 0 to 1.
    """
    figure, (axes,) = style.named_rows(causes, style.PAIR, top=0.45 if len(bars) > 1 else 0.15)
    for place, (name, numbers) in enumerate(bars.items()):
        look, shift = style.SERIES[1 - place % 2], style.BESIDE * (place - 0.5 * (len(bars) - 1))
        for row, (value, (low, high)) in enumerate(numbers):
            at, color = row + shift, look["color"]
            axes.plot([low, high], [at, at], color=color, linewidth=style.WIDE, label="_interval")
            axes.plot([low, high], [at, at], "|", color=color, markersize=style.SMALL, label="_ends")
            axes.plot(value, at, look["marker"], color=color, markersize=style.SMALL, label="_value" if row else name)
    axes.axvline(0.0, **style.AID)
    axes.set(
        xlim=(-1.05 if signed else min(-0.1, axes.dataLim.x0 - 0.02), max(1.05, axes.dataLim.x1 + 0.02)),
        xlabel=shortened(word, style.LONGEST, AT_TICKS),
        ylabel="Cause",
    )
    if len(bars) > 1:
        style.legend_in_corner(figure, axes)
    return figure


Influence = tuple[Sequence[str], Mapping[str, Sequence[Bar]], str]
"""The causes, their numbers by what these are, and what stands at the axis."""


def _draw_influence(influence: Influence) -> Figure:
    causes, bars, word = influence
    return study_influence(causes, bars, word, signed=_is_signed(influence))


def _is_signed(influence: Influence) -> bool:
    """Return whether these are rank correlations, and no shares of a variance."""
    return len(influence[1]) == 1


def _caption_of_influence(influence: Influence) -> str:
    numbers = "Rank correlations" if _is_signed(influence) else "Sobol indices"
    return f"{numbers} with their 95 % intervals. The further from zero, the more the cause matters."


INFLUENCE = ReportFigure(
    name="influence",
    takes="influence",
    draw=_draw_influence,
    alternative=lambda influence: f"{influence[2]} of each cause",
    caption=_caption_of_influence,
)
