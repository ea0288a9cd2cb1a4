"""Legends that fit: above a panel, where they cover no data, with names as long as there is room for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.figures.drawing import WIDTH
from bristle.figures.lettering import width
from bristle.figures.names import LETTERS, shortened_apart

__all__ = ["LINE", "legend", "legend_in_corner", "line_width", "lines"]

EM = LETTERS / 72.0  # inches
HANDLE, BEHIND_HANDLE, BETWEEN = 2.2, 0.8, 1.4  # [em]
PAD, CORNER = 0.1, 0.9  # around a legend, and around one in the corner [em]
EDGE = 0.1  # inches: left free at the edges of a figure
PIXELS = 1.03  # times as wide are letters that are fitted to pixels
AVAILABLE = (WIDTH - 2.0 * EDGE) / PIXELS
LINE = 0.18  # inches


def legend(axes: Axes, columns: int = 4, *, handle: float = HANDLE, top: bool = False) -> None:
    """Put the legend above the panel, with names shortened to the width of the figure."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    left = WIDTH * axes.get_position().x0
    columns = _columns(labels, columns, handle)
    labels = shortened_apart(labels, _widest(labels, columns, AVAILABLE - _beside_names(columns, handle)))
    wide = sum(_tops(labels, columns)) + _beside_names(columns, handle)
    # A panel far to the right, behind long names at its axis, begins later than its legend may have to.
    begin = left if left + wide <= WIDTH - EDGE else WIDTH - EDGE - PIXELS * wide
    look = {
        "ncols": columns,
        "frameon": False,
        "borderpad": PAD,
        "borderaxespad": 0.2,
        "handlelength": handle,
        "handletextpad": BEHIND_HANDLE,
        "columnspacing": BETWEEN,
    }
    if top:
        axes.figure.legend(handles, labels, loc="upper left", bbox_to_anchor=(begin / WIDTH, 1.0), **look)
    else:
        inside = (begin - left) / (WIDTH * axes.get_position().width)
        axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(inside, 1.0), **look)


def legend_in_corner(figure: Figure, axes: Axes) -> float:
    """Put the legend of a panel, in one line, into the upper left corner; return how far it reaches over it [inch]."""
    handles, labels = axes.get_legend_handles_labels()
    columns = len(labels)
    figure.legend(handles, labels, loc="upper left", ncols=columns, frameon=False, handlelength=HANDLE, columnspacing=BETWEEN)
    end = CORNER * EM + sum(_tops(labels, columns)) + _beside_names(columns, HANDLE)
    return max(end + BETWEEN * EM - WIDTH * axes.get_position().x0, 0.0)


def lines(labels: Sequence[str], columns: int = 4, handle: float = HANDLE) -> int:
    """Return how many lines a legend of these names has."""
    return -(-len(labels) // _columns(labels, columns, handle))


def line_width(labels: Sequence[str]) -> float:
    """Return how wide a legend of these names is in one line [inch]."""
    return sum(_tops(labels, len(labels))) + _beside_names(len(labels), HANDLE)


def _columns(labels: Sequence[str], columns: int, handle: float) -> int:
    """Return how many names stand in a line: as many as fit in full, if that takes three lines at most."""
    for count in range(1, 4):
        in_line = -(-len(labels) // count)
        if sum(_tops(labels, in_line)) + _beside_names(in_line, handle) <= AVAILABLE:
            return in_line
    return min(columns, len(labels))


def _beside_names(columns: int, handle: float) -> float:
    """Return how much of the width of a legend is not names [inch]."""
    return EM * (columns * (handle + BEHIND_HANDLE) + (columns - 1) * BETWEEN + 2.0 * PAD)


def _tops(labels: Sequence[str], columns: int) -> list[float]:
    """Return how wide the widest name of each column is [inch], in order of width."""
    return sorted(max(width(str(label), LETTERS) for label in part) for part in np.array_split(labels, columns))


def _widest(labels: Sequence[str], columns: int, available: float) -> float:
    """Return how wide a name may be so that all columns fit [inch]: short ones leave their room to long ones."""
    tops = _tops(labels, columns)
    for index, top in enumerate(tops):
        share = (available - sum(tops[:index])) / (columns - index)
        if top > share:
            return share
    return available
