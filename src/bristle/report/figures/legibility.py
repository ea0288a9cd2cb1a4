"""Tests that a figure is legible: its axes have names and units, and texts do not overlap."""

import itertools
import re
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bristle.report.figures.drawing import own_settings
from bristle.report.figures.numbers import names_at

OVERLAP = 1.0  # pixel


def unlabelled_axes(figure: Figure) -> list[str]:
    """Return the axes without a name or a unit, a sentence each.

    An axis whose numbers another panel shows needs no label, and an axis with names in place of numbers needs no unit.
    """
    faults = []
    panels = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    for word, axis in ((word, getattr(axes, f"{word}axis")) for axes in panels for word in "xy"):
        label = axis.get_label().get_text()
        if not label and any(tick.label1.get_visible() for tick in axis.get_major_ticks()):
            faults.append(f"an axis {word} has no label")
        if label and not re.search(r"\[[^\]]+\]$", label) and not names_at(axis):
            faults.append(f"the axis {word}, {label!r}, has no unit")
    return faults


def texts_of(figure: Figure) -> list[tuple[Any, Any]]:
    """Return all texts that a figure shows, each with its box in pixels."""
    with own_settings():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        texts: list[Any] = [
            *figure.texts,
            *(text for legend in figure.legends for text in legend.get_texts()),
        ]
        for axes in figure.axes:
            texts += [
                *axes.texts,
                *(getattr(axes, name) for name in ("title", "_left_title", "_right_title")),
            ]
            legend = axes.get_legend()
            texts += [] if legend is None else legend.get_texts()
            for axis in (axes.xaxis, axes.yaxis):
                low, high = sorted(axis.get_view_interval())
                ticks = [
                    tick
                    for tick in axis.get_major_ticks()
                    if low - 1e-9 <= tick.get_loc() <= high + 1e-9
                ]
                texts += [axis.label, *(tick.label1 for tick in ticks if tick.label1.get_visible())]
        visible = [text for text in texts if text.get_text() and text.get_visible()]
        return [(text, text.get_window_extent(canvas.get_renderer())) for text in visible]


def illegible_texts(figure: Figure) -> list[str]:
    """Return overlapping texts and texts outside of the figure, a sentence each."""
    texts, page = texts_of(figure), figure.bbox
    faults = []
    for (first, box), (second, beside) in itertools.combinations(texts, 2):
        wide, tall = (
            min(box.x1, beside.x1) - max(box.x0, beside.x0),
            min(box.y1, beside.y1) - max(box.y0, beside.y0),
        )
        # Boxes of parallel slanted texts overlap though their letters do not.
        slanted = first.get_rotation() == second.get_rotation() == 45.0
        if not slanted and wide > OVERLAP and tall > OVERLAP:
            faults.append(f"{first.get_text()!r} and {second.get_text()!r} overlap")
    for text, box in texts:
        if min(box.x0, box.y0) < -OVERLAP or max(box.x1 - page.x1, box.y1 - page.y1) > OVERLAP:
            faults.append(f"{text.get_text()!r} lies outside of the figure")
    return faults
