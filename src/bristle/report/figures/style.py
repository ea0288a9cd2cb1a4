"""A common style for all figures: panels, lines, scales and words at axes, titles, and legends with enough room.

References
----------
.. [1] U. Jugel, Z. Jerzak, G. Hackenbroich, V. Markl, "M4: a visualization-oriented time series data aggregation",
   Proceedings of the VLDB Endowment 7(10), 2014. doi:10.14778/2732951.2732953
"""

from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from bristle.core import Kind, Scale, scale_of, unit_of
from bristle.core.palette import LIGHT
from bristle.report.figures.drawing import (
    AT_TICKS,
    GREY,
    INK,
    LETTERS,
    WIDTH,
    label,
    own_settings,
    shortened,
    shortened_apart,
    width,
)
from bristle.report.figures.files import Drawing


def effort_word(kind: Kind) -> str:
    """Return the word for effort on this kind of axis."""
    return {"rotational": "Torque", "magnetic": "Moment", "piezo": "Displacement"}.get(
        kind, "Force"
    )


def position_word(kind: Kind) -> str:
    """Return the word for position on this kind of axis."""
    return {"rotational": "Angle", "magnetic": "Field", "piezo": "Voltage"}.get(kind, "Position")


def largest(*signals: np.ndarray) -> float:
    """Return the largest finite absolute value among signals; 0 without values."""
    tops = [
        np.max(np.abs(signal[np.isfinite(signal)]), initial=0.0)
        for signal in map(np.asarray, signals)
    ]
    return float(max(tops, default=0.0))


def scale_for(quantity: str, kind: Kind, *signals: np.ndarray) -> Scale:
    """Return the most readable multiple of the unit of a generalised quantity for these signals."""
    return scale_of(unit_of(quantity, kind), largest(*signals))


def effort_scale(kind: Kind, *signals: np.ndarray) -> tuple[Scale, str]:
    """Return the multiple of the unit for these efforts, and the word for effort."""
    return scale_for("force", kind, *signals), effort_word(kind)


def time_scale(time: np.ndarray) -> Scale:
    """Return the unit of a time axis: milliseconds for less than half a second, counted from zero."""
    return scale_of("s", 1.0 if largest(time) >= 0.5 else largest(time))


COLUMNS = 480  # about one per point of a figure as wide as a page


def envelope(y: np.ndarray, columns: int = COLUMNS) -> np.ndarray:
    """Return the samples of a signal to keep: first, smallest, largest and last of each column."""
    if y.size <= 4 * columns:
        return np.arange(y.size)
    width = -(-y.size // columns)
    starts = np.arange(0, y.size, width)
    last = np.minimum(starts + width, y.size) - 1
    # The end is padded with the last sample, which adds neither a smaller nor a larger one.
    blocks = np.pad(y, (0, starts.size * width - y.size), mode="edge").reshape(starts.size, width)
    low, high = starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1)
    return np.unique(np.minimum(np.concatenate([starts, low, high, last]), y.size - 1))


def runs(x: np.ndarray, y: np.ndarray) -> list[slice]:
    """Return the stretches without a gap in `x` (a step of more than 1.5 times the usual) and with finite `y`."""
    good = np.isfinite(y) & np.isfinite(x)
    if not good.any():
        return []
    steps = np.diff(x)
    usual = np.median(steps) if steps.size else 0.0
    joined = good[1:] & good[:-1] & ~(steps > 1.5 * usual)
    begins = np.flatnonzero(good & ~np.concatenate([[False], joined]))
    ends = np.flatnonzero(good & ~np.concatenate([joined, [False]]))
    return [slice(int(begin), int(end) + 1) for begin, end in zip(begins, ends, strict=True)]


def line(x: np.ndarray, y: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """Return a signal over time as a short line that looks the same, broken at gaps."""
    parts = runs(x, y)
    total = sum(part.stop - part.start for part in parts)
    kept_x, kept_y = [], []
    for part in parts:
        # A long stretch takes its share of the width, or a few short stretches would make it coarse.
        # Two columns at least for each stretch.
        samples = (
            envelope(y[part], max(columns * (part.stop - part.start) // total, 2)) + part.start
        )
        kept_x += [x[samples], [np.nan]]
        kept_y += [y[samples], [np.nan]]
    if not parts:
        return np.empty(0), np.empty(0)
    return np.concatenate(kept_x[:-1]), np.concatenate(kept_y[:-1])


def spread(x: np.ndarray, y: np.ndarray, cells: tuple[int, int] = (240, 120)) -> np.ndarray:
    """Return the points of a cloud to draw: one for each occupied cell of a grid, and the extremes."""
    if x.size == 0:
        return np.arange(0)
    across, up = (
        np.minimum(((v - v.min()) / (np.ptp(v) or 1.0) * n).astype(int), n - 1)
        for v, n in zip((x, y), cells, strict=True)
    )
    _, first = np.unique(across * cells[1] + up, return_index=True)
    extremes = [x.argmin(), x.argmax(), y.argmin(), y.argmax()]
    return np.unique(np.concatenate([first, extremes]))


def shares(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the share of values between each two edges [%]."""
    return np.histogram(values, edges)[0] * (100.0 / max(values.size, 1))


Look = dict[str, Any]
# A wide light line under a narrow dark line stays legible in grey where two colours would not.
MEASURED: Look = {"color": LIGHT["measured"], "linewidth": 2.2, "linestyle": "-"}
PREDICTED: Look = {"color": LIGHT["with"], "linewidth": 0.9, "linestyle": "-"}
LINES: tuple[Look, ...] = (
    MEASURED,
    PREDICTED,
    {"color": LIGHT["third"], "linewidth": 1.1, "linestyle": "--"},
    {"color": LIGHT["fourth"], "linewidth": 1.1, "linestyle": ":"},
    {"color": LIGHT["fifth"], "linewidth": 1.1, "linestyle": "-."},
)
SERIES: tuple[Look, ...] = tuple(
    look | {"marker": marker} for look, marker in zip(LINES, "os^Dv", strict=True)
)
REST: Look = PREDICTED | {"linewidth": 0.7}
AID: Look = {"color": GREY, "linewidth": 0.8, "label": "_aid"}
DASHED: Look = {"color": INK, "linewidth": 1.0, "linestyle": "--"}
DOTTED: Look = {"color": GREY, "linewidth": 1.0, "linestyle": (0, (1, 2))}
PALE, BARS, DOUBTFUL = LIGHT["shade"], LIGHT["band"], LIGHT["care"]
SMALL = 4.5  # points: a mark
WIDE, BESIDE = 1.6, 0.2  # points: an interval; rows: distance of marks in one row
TOP, ROW, PANEL = 0.32, 1.6, 2.2  # inches: above panels, a row over time, a row of panels
LONGEST, NARROW = 2.4, 1.6  # inches: a name at an axis, and the same with little room
NAME, PAIR = 0.3, 0.42  # inches: a row with a name, and a row with two bars or marks
LINE = 0.18  # inches: of a legend
HANDLE, BEHIND_HANDLE, BETWEEN = 2.2, 0.8, 1.4  # of a legend [em]
PAD = 0.1  # around a legend [em]
EM = LETTERS / 72.0  # inches
# Inches left free at the edges of a figure; times as wide are letters fitted to pixels.
EDGE, PIXELS = (0.1, 1.03)
AVAILABLE = (WIDTH - 2.0 * EDGE) / PIXELS


def styled(draw: Callable[..., Figure]) -> Callable[..., Figure]:
    """Return the function, run with this style."""

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
    top: float = TOP,
    bottom: float = 0.46,
    gap: float = 0.66,
    between: float = 0.62,
    names: Iterable[str] = (),
    over_titles: bool = False,
    across: float = WIDTH,
) -> tuple[Figure, list[list[Axes]]]:
    """Return a figure `across` inches wide, by default as wide as a page, and its axes by row and column.

    Room is left above them for a legend of these names, if it takes more than a line or is placed over the titles.
    """
    labels = [label(name) for name in names]
    lines = -(-len(labels) // _columns(labels, 4, HANDLE)) if labels else 0
    above = LINE * lines if over_titles or lines > 1 else 0.0
    height, top = height + above, top + above
    figure = Drawing(figsize=(across, height))
    figure.has_room_above = above > 0.0
    tall = (height - top - bottom - gap * (rows - 1)) / rows
    wide = (across - left - right - between * (columns - 1)) / columns
    grid = figure.add_gridspec(
        rows,
        columns,
        height_ratios=heights,
        width_ratios=widths,
        hspace=gap / tall,
        wspace=between / wide,
        left=left / across,
        right=1 - right / across,
        bottom=bottom / height,
        top=1 - top / height,
    )
    shares = [[slice(None)] if row in undivided else range(columns) for row in range(rows)]
    return figure, [
        [figure.add_subplot(grid[row, share]) for share in shares[row]] for row in range(rows)
    ]


def grid_of(count: int, columns: int = 2, **layout: Any) -> tuple[Figure, list[Axes]]:
    """Return a figure with so many panels, row by row."""
    columns = min(count, columns)
    rows = -(-count // columns)
    figure, grid = panels(layout.get("top", TOP) + PANEL * rows, rows, columns, **layout)
    axes = list(chain.from_iterable(grid))
    for unused in axes[count:]:
        unused.remove()
    return figure, axes[:count]


def named_rows(
    names: Sequence[str],
    row_height: float = NAME,
    longest: float = LONGEST,
    columns: int = 1,
    **layout: Any,
) -> tuple[Figure, list[Axes]]:
    """Return a figure with a row for each name, from the top down, in each of its panels."""
    texts = shortened_apart(names, longest, AT_TICKS)
    # Assumes wide letters
    widest = max((max(0.085 * len(text), width(text, AT_TICKS)) for text in texts), default=0.0)
    left = max(0.45 + min(widest, longest), 1.0)
    figure, (row,) = panels(0.9 + row_height * len(texts), columns=columns, left=left, **layout)
    for axes in row:
        axes.set_yticks(range(len(texts)), texts if axes is row[0] else [""] * len(texts))
        axes.set_ylim(len(texts) - 0.5, -0.7)
        axes.tick_params(axis="y", length=0)
    return figure, row


def share_y(row: Sequence[Axes], text: str) -> None:
    """Write the name and the numbers of y at the first panel of a row only."""
    row[0].set_ylabel(text)
    for axes in row[1:]:
        axes.tick_params(labelleft=False)


def one_height(panels: Sequence[Axes]) -> None:
    """Give panels the same range, from the lowest to the highest value of all."""
    limits = [axes.get_ylim() for axes in panels]
    for axes in panels:
        axes.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))


def title(axes: Axes, text: str, name: str | None = None, beside: float = 0.0) -> None:
    """Put a title above the panel, shortened to its width."""
    name = text if name is None or not text.startswith(name) else name
    behind = text[len(name) :]
    available = WIDTH * axes.get_position().width - beside - width(behind, LETTERS)
    axes.set_title(shortened(name, available) + behind)


def over_time(
    axes: Axes, time: np.ndarray, *signals: tuple[np.ndarray, Look, str], scale: Scale, word: str
) -> None:
    """Draw signals over time, each with its look and its name, as short lines that look the same; label both axes."""
    span = time_scale(time)
    for signal, look, name in signals:
        x, y = line(time, signal)
        axes.plot(x * span.factor, y * scale.factor, label=name, **look)
    axes.set(xlabel=span.label("Time"), ylabel=scale.label(word))


def plain_numbers(*sides: Axis) -> None:
    """Write the numbers of logarithmic scales without powers of ten, which a page shows as source text."""
    for side in sides:
        side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def mark_window(axes: Axes, times: np.ndarray) -> None:
    """Shade the stretch that another panel shows close up, in the numbers of the axis."""
    if times.size:
        axes.axvspan(float(times[0]), float(times[-1]), color=PALE, linewidth=0, zorder=0)


def plot_by_side(axes: Axes, points: np.ndarray, name: str, look: Look) -> None:
    """Plot (velocity, effort) of each direction separately, so that no line joins the two sides of rest."""
    forward = ~np.signbit(points[:, 0])
    for side in (forward, ~forward):  # the name belongs at the right end
        if side.any():
            axes.plot(*points[side].T, label=name, **look)
            name = "_same"


def room_for(names: Iterable[str]) -> float:
    """Return the room at the right of a panel for the names of its lines [inch]."""
    return 0.1 + PIXELS * max(width(name, LETTERS) for name in names)


def label_lines(axes: Axes) -> None:
    """Write the name of each line at its right end, in its colour, moved apart where names would overlap."""
    low, high = axes.get_ylim()
    ends = []
    for curve in axes.get_lines():
        x, y = (np.asarray(values, dtype=float) for values in curve.get_data())
        x = np.where(np.isfinite(y) & (x <= axes.get_xlim()[1]), x, -np.inf)
        if x.size and np.isfinite(x.max()) and not str(curve.get_label()).startswith("_"):
            ends.append(
                ((y[x.argmax()] - low) / (high - low), str(curve.get_label()), curve.get_color())
            )
    ends.sort(key=lambda end: end[0])
    tall = 1.3 * EM / axes.get_window_extent().height * axes.figure.dpi
    places = np.array([min(max(end[0], 0.5 * tall), 1.0 - 0.5 * tall) for end in ends])
    for _ in range(len(ends) ** 2):
        for below in range(len(ends) - 1):
            lack = tall - (places[below + 1] - places[below])
            if lack > 1e-9:
                up = min(0.5 * lack, 1.0 - 0.5 * tall - places[below + 1])
                places[below + 1] += up
                places[below] -= lack - up
    for place, (_, name, colour) in zip(places, ends, strict=True):
        # Ochre letters are too pale to read.
        colour = DOUBTFUL if colour == MEASURED["color"] else colour
        axes.text(
            1.01, place, name, color=colour, transform=axes.transAxes, verticalalignment="center"
        )


def legend(axes: Axes, columns: int = 4, *, handle: float = HANDLE) -> None:
    """Put the legend above the panel, or into the room left for it, with names shortened to the width of the figure."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    left = WIDTH * axes.get_position().x0
    columns = _columns(labels, columns, handle)
    room = widest = AVAILABLE - _beside_names(columns, handle)
    tops = _tops(labels, columns)
    for index, top in enumerate(tops):
        # Short names leave their room to long ones.
        share = (room - sum(tops[:index])) / (columns - index)
        if top > share:
            widest = share
            break
    labels = shortened_apart(labels, widest)
    wide = sum(_tops(labels, columns)) + _beside_names(columns, handle)
    # A panel far to the right, after long names at its axis, begins further right than its legend.
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
    if isinstance(axes.figure, Drawing) and axes.figure.has_room_above:
        axes.figure.legend(
            handles, labels, loc="upper left", bbox_to_anchor=(begin / WIDTH, 1.0), **look
        )
    else:
        inside = (begin - left) / (WIDTH * axes.get_position().width)
        axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(inside, 1.0), **look)


def legend_in_corner(figure: Figure, axes: Axes) -> float:
    """Put the legend of a panel, in one line, into the upper left corner; return its height [inch]."""
    handles, labels = axes.get_legend_handles_labels()
    columns = len(labels)
    figure.legend(
        handles,
        labels,
        loc="upper left",
        ncols=columns,
        frameon=False,
        handlelength=HANDLE,
        columnspacing=BETWEEN,
    )
    end = 0.9 * EM + sum(_tops(labels, columns)) + _beside_names(columns, HANDLE)
    return max(end + BETWEEN * EM - WIDTH * axes.get_position().x0, 0.0)


def _columns(labels: Sequence[str], columns: int, handle: float) -> int:
    """Return the number of names in a line: as many as fit in full, if that takes three lines at most."""
    for count in range(1, 4):
        in_line = -(-len(labels) // count)
        if sum(_tops(labels, in_line)) + _beside_names(in_line, handle) <= AVAILABLE:
            return in_line
    return min(columns, len(labels))


def _beside_names(columns: int, handle: float) -> float:
    """Return the width of a legend without its names [inch]."""
    return EM * (columns * (handle + BEHIND_HANDLE) + (columns - 1) * BETWEEN + 2.0 * PAD)


def _tops(labels: Sequence[str], columns: int) -> list[float]:
    """Return the width of the widest name of each column [inch], in order of width."""
    return sorted(
        max(width(str(name), LETTERS) for name in part) for part in np.array_split(labels, columns)
    )


def window(time: np.ndarray, error: np.ndarray, share: float = 0.03) -> slice:
    """Return the samples around the largest absolute error: `share` of all, at least 40."""
    count = min(max(round(share * time.size), 40), time.size)
    worst = int(np.argmax(np.nan_to_num(np.abs(error), nan=0.0, posinf=0.0)))
    start = min(max(worst - count // 2, 0), time.size - count)
    return slice(start, start + count)
