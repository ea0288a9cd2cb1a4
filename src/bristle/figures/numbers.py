"""The numbers that a figure shows, read back from what is drawn, in one way for all figures: none says it of itself.

Lines, points, bars, steps, areas, cells and contours are found panel by panel, with the labels of its axes. A
logarithmic axis has the numbers themselves, not their logarithms.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter

from bristle.figures.drawn import Drawn, drawn_in
from bristle.figures.series import series_names

__all__ = ["Panel", "as_csv", "numbers_of"]

DIGITS = ".12g"  # enough to draw it again at any size
_NUMBER = re.compile(r"[\d.,eE+−-]*")


class Panel(NamedTuple):
    """The numbers of a panel: its title, the heads of three columns, what is drawn, and the names at its axes."""

    title: str
    x: str
    y: str
    value: str
    drawn: list[tuple[str, Drawn]]
    names: tuple[dict[float, str], dict[float, str]]


def numbers_of(figure: Figure) -> list[Panel]:
    """Return the numbers of each panel of a figure; none for a diagram, whose places mean nothing."""
    panels = [(axes, list(drawn_in(axes))) for axes in figure.axes if axes.get_visible() and axes.axison]
    everything = [one for _, drawn in panels for one in drawn]
    found = []
    for axes, drawn in panels:
        if drawn:
            title = " ".join(filter(None, (axes.get_title(place) for place in ("left", "center", "right"))))
            x, y = _heads(axes, figure.axes, title)
            named = list(zip(series_names(drawn, everything, y), drawn, strict=True))
            value = title if "[" in title else "value"
            found.append(Panel(title, x, y, value, named, (_names_at(axes.xaxis), _names_at(axes.yaxis))))
    return found


def as_csv(panel: Panel) -> str:
    """Return the numbers of a panel as comma-separated values, a line for each point.

    Columns: the panel, the series, how it is drawn, which stroke of it, x, y; where there are such, what colour or
    height stands for, and names that stand at the axes in place of numbers.
    """
    valued = any(one.values for _, one in panel.drawn)
    heads = ["panel", "series", "mark", "stroke", panel.x, panel.y] + [panel.value] * valued
    named = [(column, names) for column, names in enumerate(panel.names) if names]
    heads += [f"name at {'xy'[column]}" for column, _ in named]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    strokes: dict[tuple[str, str], int] = {}
    for series, one in panel.drawn:
        for index, stroke in enumerate(one.strokes):
            number = strokes[series, one.mark] = strokes.get((series, one.mark), 0) + 1
            values = np.broadcast_to(one.values[index], len(stroke)) if one.values else [""] * len(stroke)
            for point, value in zip(stroke, values, strict=True):
                cells = [panel.title, series, one.mark, str(number), *map(_cell, point)]
                cells += [_cell(value)] * valued
                writer.writerow(cells + [_nearest(float(point[column]), names) for column, names in named])
    return out.getvalue()


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else format(float(value), DIGITS)


def _heads(axes: Axes, others: Sequence[Axes], title: str) -> tuple[str, str]:
    """Return the heads of the columns of x and y: the labels of the axes, with their units."""
    if axes.name == "polar":
        return "angle [rad]", title if "[" in title else "radius"
    x = axes.get_xlabel() or _label_beside(axes, others, "x")
    y = axes.get_ylabel() or _label_beside(axes, others, "y")
    return (f"x: {x}", f"y: {y}") if x and x == y else (x or "x", y or "y")


def _label_beside(axes: Axes, others: Sequence[Axes], which: str) -> str:
    """Return the label of the panel below or to the left that has the numbers of this one, which shows none."""
    shown = "labelbottom" if which == "x" else "labelleft"
    if getattr(axes, f"{which}axis").get_tick_params().get(shown, True):
        return ""
    place = axes.get_position()
    along, across = ("y0", "x0") if which == "x" else ("x0", "y0")
    beside = []
    for one in others:
        there, label = one.get_position(), getattr(one, f"get_{which}label")()
        if label and abs(getattr(there, across) - getattr(place, across)) < 1e-6:
            distance = getattr(place, along) - getattr(there, along)
            beside += [(distance, label)] if distance > 0.0 else []
    return min(beside)[1] if beside else ""


def _names_at(axis: Any) -> dict[float, str]:
    """Return the names that stand at an axis in place of numbers, by where they stand."""
    formatter = axis.get_major_formatter()
    named = isinstance(formatter, (FixedFormatter, FuncFormatter))
    if not (named and isinstance(axis.get_major_locator(), FixedLocator)):
        return {}
    places = [float(one) for one in axis.get_majorticklocs()]
    found = dict(zip(places, formatter.format_ticks(places), strict=True))
    return {} if all(_NUMBER.fullmatch(name) for name in found.values()) else found


def _nearest(place: float, names: dict[float, str]) -> str:
    """Return the name of the row or column that holds a place."""
    places = sorted(names)
    reach = 0.5 * min((b - a for a, b in pairwise(places)), default=1.0)
    near = min(places, key=lambda one: abs(one - place))
    return names[near] if abs(near - place) <= reach else ""
