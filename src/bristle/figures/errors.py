"""Errors of ways to a model, loops and truths, with their spread, beside what they are compared with."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from bristle.figures import style
from bristle.figures.lettering import label

MARKS = [share * decade for decade in (0.1, 1.0, 10.0) for share in (1.0, 2.0, 5.0)]
LOOKS = tuple(style.SERIES[place] for place in (4, 0, 2, 1))
OWN_ERROR, PUBLISHED = "here, mean ± standard deviation", "as published"


class Spread(NamedTuple):
    """An error, the ends of its interval, and its smallest and largest mean under all conditions."""

    error: float
    low: float
    high: float
    least: float
    most: float


@style.styled
def error_over(
    places: Sequence[float],
    errors: Mapping[str, np.ndarray],
    levels: Mapping[str, float],
    place_name: str,
    error_name: str,
    *,
    counted: bool = False,
) -> Figure:
    """Return errors over a number that was assumed or counted: a line for each name, with bars to low and high."""
    figure, ((axes,),) = style.panels(3.1, names=[*errors, *levels])
    looks = style.SERIES if len(errors) > 1 else style.SERIES[1:]
    for number, ((name, values), look) in enumerate(zip(errors.items(), looks, strict=False)):
        finite = np.isfinite(values).any(axis=1)
        aside = 1.0 + 0.04 * (number - 0.5 * (len(errors) - 1)) * counted
        at, (error, low, high) = aside * np.asarray(places)[finite], values[finite].T
        axes.plot(at, error, label=label(name), markersize=style.SMALL, **look)
        axes.vlines(at, low, high, color=look["color"], linewidth=1.0, label=f"_{label(name)}")
    for name, level in levels.items():
        axes.axhline(level, label=label(name), **style.DOTTED)
    if counted:
        axes.set_xscale("log")
        axes.set_xticks(list(places), [f"{place:g}" for place in places])
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.06, y=0.1)
    axes.set(ylim=(0.0, None), xlabel=place_name, ylabel=error_name)
    style.legend(axes)
    return figure


@style.styled
def errors_by_loop(errors: Mapping[str, float], spreads: Mapping[str, float], published: Mapping[str, float], error_name: str) -> Figure:
    """Return the error of each loop, and what others published, one a row."""
    figure, (axes,) = style.named_rows([*errors, *published])
    color = style.PREDICTED["color"]
    for row, (name, error) in enumerate(errors.items()):
        spread = spreads.get(name, 0.0)
        axes.hlines(row, error - spread, error + spread, color=color, linewidth=style.WIDE, label="_spread")
        axes.plot(error, row, "o", color=color, label=f"_{OWN_ERROR}" if row else OWN_ERROR)
    for row, value in enumerate(published.values(), len(errors)):
        axes.plot(value, row, "D", fillstyle="none", color=style.INK, label=f"_{PUBLISHED}" if row > len(errors) else PUBLISHED)
    # Numbers stand above the marks, whatever the size of the page.
    for row, value in enumerate([*errors.values(), *published.values()]):
        axes.annotate(f"{value:.2f}", (value, row), (0, 5), textcoords="offset points", ha="center", fontsize=7.5)
    axes.set(xlim=(0.0, 1.1 * max(*errors.values(), *published.values())), xlabel=error_name, ylabel="Loop")
    style.legend(axes)
    return figure


@style.styled
def errors_by_truth(errors: Mapping[str, Mapping[str, Mapping[str, Spread]]], limit: float, error_name: str, limit_name: str) -> Figure:
    """Return a panel for each set: a row for each truth, in it a mark for each loop."""
    truths = list(next(iter(errors.values())))
    figure, row = style.named_rows(truths, 2.0 * style.NAME, style.NARROW, len(errors), top=0.62, between=0.25)
    ends = [end for rows in errors.values() for loops in rows.values() for spread in loops.values() for end in spread]
    finite = [limit, *(end for end in ends if isfinite(end) and end > 0.0)]
    for axes, (head, rows) in zip(row, errors.items(), strict=True):
        for place, loops in enumerate(rows.values()):
            # Beside one another: mean, interval, and range under all conditions.
            for number, ((name, spread), look) in enumerate(zip(loops.items(), LOOKS, strict=False)):
                at, color = place + style.BESIDE * (number - 0.5 * (len(loops) - 1)), look["color"]
                axes.hlines(at, spread.least, spread.most, color=color, linewidth=1.0, label="_conditions")
                axes.hlines(at, spread.low, spread.high, color=color, linewidth=2.0 * style.WIDE, label="_interval")
                axes.plot(spread.error, at, look["marker"], color=color, markersize=style.SMALL, label="_loop" if place else name)
        axes.set_xscale("log")
        axes.set_xticks(MARKS, [f"{mark:g}" for mark in MARKS])
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlim(0.8 * min(finite), 1.25 * max(finite))
        axes.axvline(limit, label=limit_name, **style.DOTTED)
        style.title(axes, head)
        axes.set_xlabel(error_name)
        axes.set_ylabel("Friction of the rig", visible=axes is row[0])  # the numbers of each panel have this head
    style.legend_in_corner(figure, row[0])
    return figure
