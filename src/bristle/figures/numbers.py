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

__all__ = ["Panel", "as_csv", "names_at", "numbers_of"]

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
    figure_wide = [graphic for _, drawn in panels for graphic in drawn]
    result = []
    for axes, drawn in panels:
        if drawn:
            title = " ".join(filter(None, (axes.get_title(side) for side in ("left", "center", "right"))))
            x, y = _heads(axes, figure.axes, title)
            named = list(zip(series_names(drawn, figure_wide, y), drawn, strict=True))
            value = title if "[" in title else "value"
            result.append(Panel(title, x, y, value, named, (names_at(axes.xaxis), names_at(axes.yaxis))))
    return result


def as_csv(panel: Panel) -> str:
    """Return the numbers of a panel as comma-separated values, a line for each point.

    Columns: the panel, the series, how it is drawn, which stroke of it, x, y; where there are such, what colour or
    height stands for, and names that stand at the axes in place of numbers.
    """
    valued = any(graphic.values for _, graphic in panel.drawn)
    heads = ["panel", "series", "mark", "stroke", panel.x, panel.y] + [panel.value] * valued
    named = [(column, names) for column, names in enumerate(panel.names) if names]
    heads += [f"name at {'xy'[column]}" for column, _ in named]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    strokes: dict[tuple[str, str], int] = {}
    for series, graphic in panel.drawn:
        for index, stroke in enumerate(graphic.strokes):
            number = strokes[series, graphic.mark] = strokes.get((series, graphic.mark), 0) + 1
            values = np.broadcast_to(graphic.values[index], len(stroke)) if graphic.values else [""] * len(stroke)
            for point, value in zip(stroke, values, strict=True):
                cells = [panel.title, series, graphic.mark, str(number), *map(_cell, point)]
                cells += [_cell(value)] * valued
                writer.writerow(cells + [_nearest(float(point[column]), names) for column, names in named])
    return out.getvalue()


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else format(float(value), DIGITS)


def _heads(axes: Axes, neighbours: Sequence[Axes], title: str) -> tuple[str, str]:
    """Return the heads of the columns of x and y: the labels of the axes, with their units."""
    if axes.name == "polar":
        return "angle [rad]", title if "[" in title else "radius"
    x = axes.get_xlabel() or _label_beside(axes, neighbours, "x")
    y = axes.get_ylabel() or _label_beside(axes, neighbours, "y")
    return (f"x: {x}", f"y: {y}") if x and x == y else (x or "x", y or "y")


def _label_beside(axes: Axes, neighbours: Sequence[Axes], axis: str) -> str:
    """Return the label of the panel below or to the left that has the numbers of this one, which shows none."""
    key = "labelbottom" if axis == "x" else "labelleft"
    if getattr(axes, f"{axis}axis").get_tick_params().get(key, True):
        return ""
    own_bounds = axes.get_position()
    along, across = ("y0", "x0") if axis == "x" else ("x0", "y0")
    beside = []
    for neighbour in neighbours:
        bounds, label = neighbour.get_position(), getattr(neighbour, f"get_{axis}label")()
        if label and abs(getattr(bounds, across) - getattr(own_bounds, across)) < 1e-6:
            distance = getattr(own_bounds, along) - getattr(bounds, along)
            beside += [(distance, label)] if distance > 0.0 else []
    return min(beside)[1] if beside else ""


def names_at(axis: Any) -> dict[float, str]:
    """Return the names that stand at an axis in place of numbers, by where they stand."""
    formatter = axis.get_major_formatter()
    named = isinstance(formatter, (FixedFormatter, FuncFormatter))
    if not (named and isinstance(axis.get_major_locator(), FixedLocator)):
        return {}
    ticks = [float(tick) for tick in axis.get_majorticklocs()]
    labels = dict(zip(ticks, formatter.format_ticks(ticks), strict=True))
    return {} if all(_NUMBER.fullmatch(name) for name in labels.values()) else labels


def _nearest(value: float, names: dict[float, str]) -> str:
    """Return the name of the row or column that holds a place."""
    ticks = sorted(names)
    reach = 0.5 * min((b - a for a, b in pairwise(ticks)), default=1.0)
    near = min(ticks, key=lambda tick: abs(tick - value))
    return names[near] if abs(near - value) <= reach else ""
