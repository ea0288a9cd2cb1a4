"""One look for all figures, applied by context: nothing outside a figure changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.figures.drawing import WIDTH, Drawing
from bristle.figures.legends import legend, legend_in_corner
from bristle.figures.lettering import width
from bristle.figures.names import LETTERS, shortened
from bristle.figures.settings import GREY, INK, own_settings

__all__ = [
    "GREY",
    "INK",
    "MEASURED",
    "PREDICTED",
    "SERIES",
    "WIDTH",
    "Look",
    "legend",
    "legend_in_corner",
    "mark_window",
    "panel_width",
    "panels",
    "plot_by_side",
    "room_for",
    "styled",
    "title",
]

AT_AXES = 8.0  # points: letters of numbers and names at axes
Look = dict[str, Any]
# A wide light line under a narrow dark one stays legible in grey where two colours would not.
MEASURED: Look = {"color": "#e0a83c", "linewidth": 2.2, "linestyle": "-"}
PREDICTED: Look = {"color": "#0b3c6f", "linewidth": 0.9, "linestyle": "-"}
SERIES: tuple[Look, ...] = (
    MEASURED | {"marker": "o"},
    PREDICTED | {"marker": "s"},
    {"color": "#00836a", "linewidth": 1.1, "linestyle": "--", "marker": "^"},
    {"color": "#a3356f", "linewidth": 1.1, "linestyle": ":", "marker": "D"},
    {"color": "#555e69", "linewidth": 1.1, "linestyle": "-.", "marker": "v"},
)


def styled(draw: Callable[..., Figure]) -> Callable[..., Figure]:
    """Return the function, run under this style."""

    @wraps(draw)
    def drawn(*args: Any, **kwargs: Any) -> Figure:
        with own_settings():
            return draw(*args, **kwargs)

    return drawn


def panels(
    height: float,
    rows: int = 1,
    columns: int = 1,
    *,
    heights: Sequence[float] | None = None,
    widths: Sequence[float] | None = None,
    undivided: Sequence[int] = (),
    left: float = 0.68,
    right: float = 0.12,
    top: float = 0.32,
    bottom: float = 0.46,
    gap: float = 0.66,
    between: float = 0.62,
) -> tuple[Figure, list[list[Axes]]]:
    """Return a figure as wide as a page and its axes by row and column."""
    figure = Drawing(figsize=(WIDTH, height))
    tall = (height - top - bottom - gap * (rows - 1)) / rows
    wide = panel_width(columns, between, left, right)
    grid = figure.add_gridspec(
        rows,
        columns,
        height_ratios=heights,
        width_ratios=widths,
        hspace=gap / tall,
        wspace=between / wide,
        left=left / WIDTH,
        right=1 - right / WIDTH,
        bottom=bottom / height,
        top=1 - top / height,
    )
    shares = [[slice(None)] if row in undivided else range(columns) for row in range(rows)]
    return figure, [[figure.add_subplot(grid[row, share]) for share in shares[row]] for row in range(rows)]


def panel_width(columns: int, between: float, left: float = 0.68, right: float = 0.12) -> float:
    """Return how wide a panel is beside others as wide [inch]."""
    return (WIDTH - left - right - between * (columns - 1)) / columns


def room_for(names: Sequence[str]) -> float:
    """Return how wide the widest of these names is at an axis [inch], letters taken for wide ones."""
    return max((max(0.085 * len(name), width(name, AT_AXES)) for name in names), default=0.0)


def title(axes: Axes, text: str, name: str | None = None, beside: float = 0.0) -> None:
    """Put a title above the panel, shortened to its width."""
    name = text if name is None or not text.startswith(name) else name
    behind = text[len(name) :]
    available = WIDTH * axes.get_position().width - beside - width(behind, LETTERS)
    axes.set_title(shortened(name, available) + behind)


def mark_window(axes: Axes, times: np.ndarray) -> None:
    """Shade the stretch that another panel shows close up, in the numbers of the axis."""
    if times.size:
        axes.axvspan(float(times[0]), float(times[-1]), color="#e9ecf0", linewidth=0, zorder=0)


def plot_by_side(axes: Axes, points: np.ndarray, name: str, look: Look) -> None:
    """Plot (velocity, effort) of each direction on its own, so that no line joins the two sides of rest."""
    back = np.signbit(points[:, 0])
    for side in (back, ~back):
        if side.any():
            axes.plot(*points[side].T, label=name, **look)
            name = "_same"
