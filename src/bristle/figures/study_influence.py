"""Which cause matters: how strongly each goes with a number of the runs, with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.names import shortened, shortened_apart
from bristle.figures.report_figure import ReportFigure

__all__ = ["FIGURE", "study_influence"]

LONGEST, WIDEST = 2.4, 3.0  # inches, of the name of a cause, and of what stands at the axis
Bar = tuple[float, tuple[float, float]]
APART = 0.26


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
    names = shortened_apart(list(causes), LONGEST, style.AT_AXES)
    left = max(0.45 + min(style.room_for(names), LONGEST), 1.0)
    top = 0.45 if len(bars) > 1 else 0.15
    figure, ((axes,),) = style.panels(top + 0.6 + 0.36 * len(causes), left=left, top=top)
    for place, (name, numbers) in enumerate(bars.items()):
        look, shift = style.SERIES[1 - place % 2], APART * (place - 0.5 * (len(bars) - 1))
        for row, (value, (low, high)) in enumerate(numbers):
            at, color = row + shift, look["color"]
            axes.plot([low, high], [at, at], color=color, linewidth=1.6, label="_interval")
            axes.plot([low, high], [at, at], linestyle="none", marker="|", color=color, markersize=6, label="_ends")
            label = name if row == 0 else "_value"
            axes.plot([value], [at], linestyle="none", marker=look["marker"], color=color, markersize=4.5, label=label)
    axes.axvline(0.0, color=style.GREY, linewidth=0.8)
    axes.set_yticks(range(len(causes)), names)
    axes.set_ylim(len(causes) - 0.5, -0.5)
    axes.set_xlim(-1.05 if signed else min(-0.1, axes.dataLim.x0 - 0.02), max(1.05, axes.dataLim.x1 + 0.02))
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(shortened(word, WIDEST, style.AT_AXES))
    axes.set_ylabel("Cause")
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
