"""One look for all figures, applied by context: nothing outside a figure changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

__all__ = [
    "GREY",
    "INK",
    "MEASURED",
    "PREDICTED",
    "SERIES",
    "WIDTH",
    "Look",
    "legend",
    "mark_window",
    "panels",
    "plot_by_side",
    "room_for",
    "styled",
]

WIDTH = 7.2  # inches: the text width of an A4 page
INK, GREY = "#1b2430", "#8d97a3"

RC: Any = {
    "axes.axisbelow": True,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "right",
    "axes.titlesize": 8.5,
    "axes.unicode_minus": True,
    "axes.xmargin": 0.01,
    "figure.facecolor": "none",
    "font.family": "sans-serif",
    # Widest first: where a reader lacks one, the next takes less room, so that nothing begins to overlap.
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial", "sans-serif"],
    "font.size": 8.5,
    "grid.color": "#dfe3e8",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.1,
    "lines.solid_capstyle": "round",
    "svg.fonttype": "none",
    "svg.hashsalt": "bristle",
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
    "ytick.labelsize": 8,
}

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
        with matplotlib.rc_context(RC):
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
    """Return a figure as wide as a page and its axes by row and column.

    Parameters
    ----------
    height : float
        Of the figure [inch].
    rows, columns : int
        How many panels.
    heights, widths : sequence of float, optional
        How the room is shared between rows and between columns.
    undivided : sequence of int
        Rows that are one panel.
    left, right, top, bottom, gap, between : float
        Margins, and the room between rows and between columns [inch]: set, not solved for, because solving takes
        longer than drawing.
    """
    figure = Figure(figsize=(WIDTH, height))
    tall = (height - top - bottom - gap * (rows - 1)) / rows
    wide = (WIDTH - left - right - between * (columns - 1)) / columns
    grid = figure.add_gridspec(
        rows, columns, height_ratios=heights, width_ratios=widths, hspace=gap / tall, wspace=between / wide,
        left=left / WIDTH, right=1 - right / WIDTH, bottom=bottom / height, top=1 - top / height,
    )  # fmt: skip
    shares = [[slice(None)] if row in undivided else range(columns) for row in range(rows)]
    return figure, [[figure.add_subplot(grid[row, share]) for share in shares[row]] for row in range(rows)]


def room_for(names: Sequence[str]) -> float:
    """Return how wide the widest of these names is at an axis [inch], letters taken for wide ones."""
    return 0.085 * max(map(len, names), default=0)


def legend(axes: Axes, columns: int = 4, *, handle: float = 2.2) -> None:
    """Put the legend above the panel, where it covers no data."""
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, borderpad=0.1,
        borderaxespad=0.2, handlelength=handle, columnspacing=1.4,
    )  # fmt: skip


def mark_window(axes: Axes, shown: np.ndarray) -> None:
    """Shade the stretch that another panel shows close up, in the numbers of the axis."""
    if shown.size:
        axes.axvspan(float(shown[0]), float(shown[-1]), color="#e9ecf0", linewidth=0, zorder=0)


def plot_by_side(axes: Axes, points: np.ndarray, name: str, look: Look) -> None:
    """Plot (velocity, effort) of each direction on its own, so that no line joins the two sides of rest."""
    back = np.signbit(points[:, 0])
    for side in (back, ~back):
        if side.any():
            axes.plot(*points[side].T, label=name, **look)
            name = "_same"
