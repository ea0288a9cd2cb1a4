"""What is drawn in a panel of a figure, read back in the units of its axes, whatever draws it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.contour import ContourSet
from matplotlib.image import AxesImage
from matplotlib.patches import FancyArrowPatch, StepPatch
from matplotlib.path import Path

__all__ = ["Drawn", "drawn_in"]


class Drawn(NamedTuple):
    """Something drawn in a panel."""

    artist: Any
    mark: str
    strokes: list[np.ndarray]
    values: Sequence[Any] = ()


def drawn_in(axes: Axes) -> Iterator[Drawn]:
    """Yield what is drawn in a panel in its units; not what stands at a place of the panel itself."""
    bars = [container for container in axes.containers if isinstance(container, BarContainer)]
    in_bars = {id(bar) for container in bars for bar in container}
    artists = [artist for artist in (*axes.lines, *axes.collections, *axes.patches, *axes.images) if id(artist) not in in_bars]
    for artist in (*artists, *bars):
        if isinstance(artist, BarContainer) or artist.get_visible():
            drawn = _read(artist, axes)
            if drawn is not None and any(map(len, drawn.strokes)):
                yield drawn


def _read(artist: Any, axes: Axes) -> Drawn | None:
    """Return what an artist draws."""
    if artist in axes.lines:
        return _line(artist, axes)
    if isinstance(artist, BarContainer):
        return Drawn(artist, "bars", [_ends_of_bars(artist)])
    if isinstance(artist, AxesImage):
        return _image(artist)
    if isinstance(artist, QuadMesh):
        corners, values = np.asarray(artist.get_coordinates(), dtype=float), _floats(artist.get_array())
        middles = 0.25 * (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1])
        points = (middles if values.size == middles[..., 0].size else corners).reshape(-1, 2)
        return Drawn(artist, "cells", [points], [values.ravel()])
    if isinstance(artist, ContourSet):
        return _contours(artist, axes)
    if artist in axes.collections:
        return _collection(artist, axes)
    return None if isinstance(artist, FancyArrowPatch) else _patch(artist, axes)


def _line(line: Any, axes: Axes) -> Drawn | None:
    points = np.column_stack([_floats(line.get_xdata(orig=False)), _floats(line.get_ydata(orig=False))])
    joined, style = line.get_linestyle() not in ("None", "", " ") and len(points) > 1, line.get_drawstyle()
    mark = "points" if not joined else "line" if style == "default" else style
    placed = _in_units(points, line.get_transform(), axes)
    if placed is None:
        return None
    return Drawn(line, mark, _without_gaps(placed) if joined else [placed[np.isfinite(placed).all(axis=1)]])


def _ends_of_bars(bars: BarContainer) -> np.ndarray:
    """Return where bars end, in the middle of their width."""
    level = bars.orientation == "horizontal"
    x, y = (1.0, 0.5) if level else (0.5, 1.0)
    return np.array([(bar.get_x() + x * bar.get_width(), bar.get_y() + y * bar.get_height()) for bar in bars])


def _image(image: AxesImage) -> Drawn | None:
    values = _floats(image.get_array())
    if values.ndim != 2:  # colours, and no numbers
        return None
    left, right, bottom, top = image.get_extent()
    rows, columns = values.shape
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    y = y if image.origin == "lower" else y[::-1]
    return Drawn(image, "cells", [np.column_stack([np.tile(x, rows), np.repeat(y, columns)])], [values.ravel()])


def _contours(contours: Any, axes: Axes) -> Drawn | None:
    levels = contours.layers if contours.filled else contours.levels
    strokes, values = [], []
    for path, level in zip(contours.get_paths(), levels, strict=False):
        placed = [_in_units(stroke, contours.get_transform(), axes) for stroke in _strokes(path)]
        visible = [stroke for stroke in placed if stroke is not None and len(stroke)]
        strokes += visible
        values += [float(level)] * len(visible)
    return Drawn(contours, "filled contour" if contours.filled else "contour", strokes, values)


def _collection(collection: Any, axes: Axes) -> Drawn | None:
    """Return points, lines or areas of a collection."""
    if isinstance(collection, PathCollection):
        placed = _in_units(_floats(collection.get_offsets()), collection.get_offset_transform(), axes)
        values = collection.get_array()
        return None if placed is None else Drawn(collection, "points", [placed], [] if values is None else [values])
    transform, strokes = collection.get_transform(), []
    for path in collection.get_paths():
        strokes += [_in_units(stroke, transform, axes) for stroke in _strokes(path)]
    mark = "line" if isinstance(collection, LineCollection) else "area"
    return Drawn(collection, mark, [stroke for stroke in strokes if stroke is not None])


def _patch(patch: Any, axes: Axes) -> Drawn | None:
    path = patch.get_patch_transform().transform_path(patch.get_path())
    strokes = [_in_units(stroke, Artist.get_transform(patch), axes) for stroke in _strokes(path)]
    mark = "steps" if isinstance(patch, StepPatch) else "area"
    return Drawn(patch, mark, [stroke for stroke in strokes if stroke is not None])


def _strokes(path: Path) -> list[np.ndarray]:
    """Return the corners of each stroke of a path; a closed one ends where it begins."""
    if path.codes is None:
        return _without_gaps(np.asarray(path.vertices, dtype=float))
    if {*np.asarray(path.codes).tolist()} & {Path.CURVE3, Path.CURVE4}:
        path = path.cleaned(curves=False, simplify=False)
    polylines: list[list[np.ndarray]] = []
    for corner, code in zip(path.vertices, path.codes, strict=True):  # type: ignore[arg-type]
        if code == Path.MOVETO:
            polylines.append([corner])
        elif code == Path.CLOSEPOLY and polylines:
            polylines[-1].append(polylines[-1][0])
        elif code == Path.LINETO:
            polylines[-1].append(corner)
    return [part for polyline in polylines for part in _without_gaps(np.array(polyline, dtype=float))]


def _without_gaps(points: np.ndarray) -> list[np.ndarray]:
    """Return the stretches of a line between points that are no numbers."""
    good = np.isfinite(points).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [points[begin:end] for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def _in_units(points: np.ndarray, transform: Any, axes: Axes) -> np.ndarray | None:
    """Return points in the units of the axes; None for what stands at a place of the panel, whatever its units."""
    own = transform.contains_branch_seperately(axes.transData)
    if all(own):
        return points
    if not any(own):
        return None
    placed = axes.transData.inverted().transform(transform.transform(points))
    return np.where(own, points, placed)


def _floats(values: Any) -> np.ndarray:
    return np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
