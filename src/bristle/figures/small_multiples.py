"""Force over position for several models, each in a panel of its own, all to one scale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core.typography import Scale
from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for

__all__ = ["FIRST", "LAST", "Traces", "force_over_position"]

Traces = Mapping[str, tuple[np.ndarray, np.ndarray]]
COLUMNS = 3
ROW, WIDE_ROW = 2.05, 2.9  # inches
# A wide light line under a narrow dark one: what came first, and what came after.
FIRST: style.Look = {"color": "#e0a83c", "linewidth": 2.4, "linestyle": "-"}
LAST: style.Look = {"color": "#0b3c6f", "linewidth": 0.9, "linestyle": "-"}


def force_over_position(
    traces: Traces,
    titles: Mapping[str, str],
    kind: Kind,
    effort: Kind | None = None,
    columns: int = COLUMNS,
    top: float = 0.32,
    beneath: tuple[str, Traces] | None = None,
) -> tuple[Figure, Iterator[tuple[str, Axes, np.ndarray, np.ndarray]], Scale]:
    """Return a figure with one panel for each trace, the panels with what to draw in them, and the scale of positions."""
    under, first = beneath or ("", {})
    loops = [*traces.values(), *first.values()]
    length = scale_for("length", kind, *(x for x, _ in loops))
    force, word = effort_scale(effort or kind, *(f for _, f in loops))
    rows = -(-len(traces) // columns)
    figure, grid = style.panels(0.03 + top + (ROW if columns > 1 else WIDE_ROW) * rows, rows, columns, between=0.2, gap=0.72, top=top)
    panels = [axes for row in grid for axes in row]
    low = min(float(np.min(f)) for _, f in loops) * force.factor
    high = max(float(np.max(f)) for _, f in loops) * force.factor
    margin = 0.05 * (high - low)
    for unused in panels[len(traces) :]:
        unused.remove()
    for axes, name in zip(panels, traces, strict=False):
        if name in first:
            x, f = first[name]
            axes.plot(x * length.factor, f * force.factor, label=under, **FIRST)
    for index, (axes, name) in enumerate(zip(panels, traces, strict=False)):
        style.title(axes, titles[name], name)
        axes.set_ylim(low - margin, high + margin)
        axes.set_xlabel(length.label(position_word(kind)))
        if index % columns:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(force.label(f"Friction {word.lower()}"))
    drawn = ((name, axes, x * length.factor, f * force.factor) for axes, (name, (x, f)) in zip(panels, traces.items(), strict=False))
    return figure, drawn, length
