"""The numbers in a figure, read back from the drawn figure, in the same way for all figures.

Lines, points, bars, steps and areas are read panel by panel, in the units of its axes and with their
labels. A logarithmic axis gives the numbers, not their logarithms. The name of a series is its label; legends omit labels
that begin with an underscore.
"""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, StepPatch
from matplotlib.path import Path
from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter

DIGITS = ".12g"  # enough to draw it again at any size
_NUMBER = re.compile(r"[\d.,eE+−-]*")


class Drawn(NamedTuple):
    """A line, bar, area or set of points in a panel."""

    artist: Any
    mark: str
    strokes: list[np.ndarray]


class Panel(NamedTuple):
    """The numbers of a panel: its title, the heads of two columns, its series, and the names at its axes."""

    title: str
    x: str
    y: str
    drawn: list[tuple[str, Drawn]]
    names: tuple[dict[float, str], dict[float, str]]


def numbers_of(figure: Figure) -> list[Panel]:
    """Return the numbers of each panel of a figure; empty for a diagram, whose positions have no meaning."""
    panels = [
        (axes, list(drawn_in(axes))) for axes in figure.axes if axes.get_visible() and axes.axison
    ]
    result = []
    for axes, drawn in panels:
        if drawn:
            title = " ".join(
                filter(None, (axes.get_title(side) for side in ("left", "center", "right")))
            )
            x, y = _heads(axes, figure.axes, title)
            named = list(zip(series_names(drawn, y), drawn, strict=True))
            result.append(Panel(title, x, y, named, (names_at(axes.xaxis), names_at(axes.yaxis))))
    return result


def as_csv(panel: Panel) -> str:
    """Return the numbers of a panel as comma-separated values, a line for each point.

    Columns: the panel, the series, its mark, its stroke, x, y; if present, names at the axes in place of numbers.
    """
    heads = ["panel", "series", "mark", "stroke", panel.x, panel.y]
    named = [(column, names) for column, names in enumerate(panel.names) if names]
    heads += [f"name at {'xy'[column]}" for column, _ in named]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    strokes: dict[tuple[str, str], int] = {}
    for series, graphic in panel.drawn:
        for stroke in graphic.strokes:
            number = strokes[series, graphic.mark] = strokes.get((series, graphic.mark), 0) + 1
            for point in stroke:
                cells = [
                    panel.title,
                    series,
                    graphic.mark,
                    str(number),
                    *(format(float(number), DIGITS) for number in point),
                ]
                writer.writerow(
                    cells + [_nearest(float(point[column]), names) for column, names in named]
                )
    return out.getvalue()


def _heads(axes: Axes, neighbours: Sequence[Axes], title: str) -> tuple[str, str]:
    """Return the heads of the columns of x and y: the labels of the axes, with their units."""
    if axes.name == "polar":
        return "angle [rad]", title if "[" in title else "radius"
    x = axes.get_xlabel() or _label_beside(axes, neighbours, "x")
    y = axes.get_ylabel() or _label_beside(axes, neighbours, "y")
    return (f"x: {x}", f"y: {y}") if x and x == y else (x or "x", y or "y")


def _label_beside(axes: Axes, neighbours: Sequence[Axes], axis: str) -> str:
    """Return the label of the panel below or to the left whose numbers this panel shares."""
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
    """Return the names at an axis in place of numbers, by their position."""
    formatter = axis.get_major_formatter()
    named = isinstance(formatter, (FixedFormatter, FuncFormatter))
    if not (named and isinstance(axis.get_major_locator(), FixedLocator)):
        return {}
    ticks = [float(tick) for tick in axis.get_majorticklocs()]
    labels = dict(zip(ticks, formatter.format_ticks(ticks), strict=True))
    return {} if all(_NUMBER.fullmatch(name) for name in labels.values()) else labels


def _nearest(value: float, names: dict[float, str]) -> str:
    """Return the name of the row or column of a position."""
    ticks = sorted(names)
    reach = 0.5 * min((b - a for a, b in pairwise(ticks)), default=1.0)
    near = min(ticks, key=lambda tick: abs(tick - value))
    return names[near] if abs(near - value) <= reach else ""


def drawn_in(axes: Axes) -> Iterator[Drawn]:
    """Yield the series of a panel in its units, without those placed relative to the panel."""
    bars = [container for container in axes.containers if isinstance(container, BarContainer)]
    in_bars = {id(bar) for container in bars for bar in container}
    for artist in (*axes.lines, *axes.collections, *axes.patches):
        if (
            id(artist) not in in_bars
            and artist.get_visible()
            and (drawn := _read(artist, axes))
            and any(map(len, drawn.strokes))
        ):
            yield drawn
    for container in bars:
        # The end of each bar, in the middle of its width.
        x, y = (1.0, 0.5) if container.orientation == "horizontal" else (0.5, 1.0)
        ends = [
            (bar.get_x() + x * bar.get_width(), bar.get_y() + y * bar.get_height())
            for bar in container
        ]
        if ends:
            yield Drawn(container, "bars", [np.array(ends)])


def _read(artist: Any, axes: Axes) -> Drawn | None:
    """Return the series of an artist."""
    if artist in axes.lines:
        return _line(artist, axes)
    if isinstance(artist, PathCollection):
        placed = _in_units(_floats(artist.get_offsets()), artist.get_offset_transform(), axes)
        return None if placed is None else Drawn(artist, "points", [placed])
    # The heights of contours and cells would be missing.
    if isinstance(artist, (FancyArrowPatch, ContourSet, QuadMesh)):
        return None
    if artist in axes.collections:
        paths, transform = artist.get_paths(), artist.get_transform()
        mark = "line" if isinstance(artist, LineCollection) else "area"
    else:
        paths, transform = (
            [artist.get_patch_transform().transform_path(artist.get_path())],
            Artist.get_transform(artist),
        )
        mark = "steps" if isinstance(artist, StepPatch) else "area"
    strokes = [_in_units(stroke, transform, axes) for path in paths for stroke in _strokes(path)]
    return Drawn(artist, mark, [stroke for stroke in strokes if stroke is not None])


def _line(line: Any, axes: Axes) -> Drawn | None:
    points = np.column_stack(
        [_floats(line.get_xdata(orig=False)), _floats(line.get_ydata(orig=False))]
    )
    joined, style = (
        line.get_linestyle() not in ("None", "", " ") and len(points) > 1,
        line.get_drawstyle(),
    )
    mark = "points" if not joined else "line" if style == "default" else style
    placed = _in_units(points, line.get_transform(), axes)
    if placed is None:
        return None
    return Drawn(
        line, mark, _without_gaps(placed) if joined else [placed[np.isfinite(placed).all(axis=1)]]
    )


def _strokes(path: Path) -> list[np.ndarray]:
    """Return the corners of each stroke of a path; a closed stroke ends where it begins."""
    polyline_path = Path(path.vertices, path.codes)
    polyline_path.should_simplify = False
    return [
        part
        for polyline in polyline_path.to_polygons(closed_only=False)
        for part in _without_gaps(np.asarray(polyline))
    ]


def _without_gaps(points: np.ndarray) -> list[np.ndarray]:
    """Return the stretches of a line between points that are not numbers."""
    gaps = ~np.isfinite(points).all(axis=1)
    return [points[stretch] for stretch in np.ma.clump_unmasked(np.ma.array(gaps, mask=gaps))]


def _in_units(points: np.ndarray, transform: Any, axes: Axes) -> np.ndarray | None:
    """Return points in the units of the axes; None for points placed relative to the panel."""
    own = transform.contains_branch_seperately(axes.transData)
    if all(own):
        return points
    if not any(own):
        return None
    placed = axes.transData.inverted().transform(transform.transform(points))
    return np.where(own, points, placed)


def _floats(values: Any) -> np.ndarray:
    return np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)


def series_names(drawn: Sequence[Drawn], y: str) -> list[str]:
    """Return the name of each series of a panel: its label, else the axis of the only line or points, else its mark."""
    # Legends omit a label that begins with an underscore.
    labels = [
        re.sub(r"^_(child\d+$|nolegend_$)?", "", str(graphic.artist.get_label()))
        for graphic in drawn
    ]
    unnamed = [graphic.mark for graphic, label in zip(drawn, labels, strict=True) if not label]
    counts: dict[str, int] = {}
    for index, graphic in enumerate(drawn):
        if labels[index]:
            continue
        if unnamed.count(graphic.mark) > 1:
            counts[graphic.mark] = counts.get(graphic.mark, 0) + 1
            labels[index] = f"{graphic.mark} {counts[graphic.mark]}"
        else:
            labels[index] = (
                y.partition(" [")[0] if graphic.mark in ("line", "points") else graphic.mark
            )
    return labels
