"""Which cause matters: how strongly each goes with a number of the runs, with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.drawing import AT_TICKS
from bristle.figures.lettering import shortened
from bristle.figures.report_figure import ReportFigure

__all__ = ["FIGURE", "study_influence"]

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


def _draw(influence: Influence) -> Figure:
    causes, bars, word = influence
    return study_influence(causes, bars, word, signed=_is_signed(influence))


def _is_signed(influence: Influence) -> bool:
    """Return whether these are rank correlations, and no shares of a variance."""
    return len(influence[1]) == 1


def _caption(influence: Influence) -> str:
    numbers = "Rank correlations" if _is_signed(influence) else "Sobol indices"
    return f"{numbers} with their 95 % intervals. The further from zero, the more the cause matters."


FIGURE = ReportFigure(
    name="influence", takes="influence", draw=_draw, alternative=lambda influence: f"{influence[2]} of each cause", caption=_caption
)
