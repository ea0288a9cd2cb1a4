"""Errors of several loops on several truths: the mean of each, and how far it goes under all that may change."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from bristle.figures import style
from bristle.figures.names import shortened_apart

__all__ = ["Spread", "errors_by_truth"]

LONGEST = 1.6  # inch, of a name
APART = 0.19  # rows between the loops of one truth
ROW, HEAD = 0.62, 0.55  # inch
MARKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
LOOKS = (style.SERIES[4], style.SERIES[0], style.SERIES[2], style.SERIES[1])


class Spread(NamedTuple):
    """An error, the ends of its interval, and its smallest and largest mean under all conditions."""

    error: float
    low: float
    high: float
    least: float
    most: float


@style.styled
def errors_by_truth(errors: Mapping[str, Mapping[str, Mapping[str, Spread]]], limit: float, error_name: str, limit_name: str) -> Figure:
    """Return a panel for each set: a row for each truth, in it a mark for each loop.

    Parameters
    ----------
    errors : mapping of str to mapping of str to mapping of str to Spread
        By what stands above the panel, by truth, by loop, in the unit that the axis names.
    limit : float
        An error to compare with.
    error_name, limit_name : str
        What stands at the axis, and what the limit is.
    """
    truths = list(next(iter(errors.values())))
    names = shortened_apart(truths, LONGEST, style.AT_AXES)
    left = max(0.45 + min(style.room_for(names), LONGEST), 1.0)
    top = 0.62
    figure, (row,) = style.panels(top + HEAD + ROW * len(truths), columns=len(errors), left=left, top=top, between=0.25)
    for place, (axes, (head, rows)) in enumerate(zip(row, errors.items(), strict=True)):
        _panel(axes, rows)
        axes.set_xlim(*_reach(errors, limit))
        axes.axvline(limit, color=style.GREY, linewidth=1.0, linestyle=(0, (1, 2)), label=limit_name)
        style.title(axes, head)
        axes.set_yticks(range(len(truths)), names if place == 0 else [""] * len(truths))
        axes.set_xlabel(error_name)
    for axes in row:
        axes.set_ylabel("Friction of the rig")
        axes.yaxis.label.set_visible(axes is row[0])
    style.legend_in_corner(figure, row[0])
    return figure


def _panel(axes: Axes, rows: Mapping[str, Mapping[str, Spread]]) -> None:
    for place, (_, loops) in enumerate(rows.items()):
        for number, ((name, spread), look) in enumerate(zip(loops.items(), LOOKS, strict=False)):
            at, color = place + APART * (number - 0.5 * (len(loops) - 1)), look["color"]
            axes.hlines(at, spread.least, spread.most, color=color, linewidth=0.8, label="_conditions")
            axes.hlines(at, spread.low, spread.high, color=color, linewidth=3.0, label="_interval")
            axes.plot(
                spread.error,
                at,
                linestyle="none",
                marker=look["marker"],
                color=color,
                markersize=4.5,
                label=name if place == 0 else "_loop",
            )
    axes.set_xscale("log")
    axes.set_xticks(MARKS, [f"{mark:g}" for mark in MARKS])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)


def _reach(errors: Mapping[str, Mapping[str, Mapping[str, Spread]]], limit: float) -> tuple[float, float]:
    """Return from where to where all panels go."""
    ends = [end for rows in errors.values() for loops in rows.values() for spread in loops.values() for end in spread]
    finite = [end for end in ends if isfinite(end) and end > 0.0]
    return 0.8 * min(limit, *finite), 1.25 * max(limit, *finite)
