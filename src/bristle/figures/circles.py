"""Circles run by two axes: how far from round, magnified, with the glitches where an axis reverses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import number
from bristle.figures import style
from bristle.figures.drawing import AT_TICKS, Drawing
from bristle.figures.envelope import line
from bristle.figures.labels import scale_for
from bristle.figures.lettering import label, shortened_apart
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.core.variable import Kind
    from bristle.loop import Circle

QUARTERS = (0.0, 90.0, 180.0, 270.0, 360.0)  # degrees


@style.styled
def circles(curves: Sequence[Circle], kind: Kind) -> Figure:
    """Return the radial deviation of circles over the angle: around the round circle, and unrolled.

    Parameters
    ----------
    curves : sequence of Circle
        Circles of one radius and feed.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    scale = scale_for("length", kind, np.array([1e-6]), *(circle.deviation for circle in curves))
    low, high = (scale.factor * float(edge([0.0, *(edge(circle.deviation) for circle in curves)])) for edge in (np.min, np.max))
    span = max(high - low, 1e-12)
    figure = Drawing(figsize=(style.WIDTH, 4.6))
    round_: Any = figure.add_axes((0.06, 0.09, 0.44, 0.76), projection="polar")
    unrolled = figure.add_axes((0.63, 0.13, 0.355, 0.7))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    round_.plot(turn, np.zeros_like(turn), **style.AID)
    for look, circle in zip(style.LINES, curves, strict=False):
        angle, deviation = line(circle.angle, circle.deviation)
        round_.plot(angle, deviation * scale.factor, label=label(circle.variant), **look)
        unrolled.plot(np.degrees(angle), deviation * scale.factor, **look)
    round_.set_ylim(low - span, high + 0.05 * span)
    step = float(f"{0.4 * span:.1g}")
    ticks = [-step, 0.0] if -low > high else [0.0, step]
    round_.set_yticks(ticks, [""] * len(ticks))
    for tick in ticks:
        # Above the lines, where the ticks of the axis itself would lie below them.
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.9}
        round_.text(0.25 * np.pi, tick, number(tick, digits=1), ha="center", va="center", fontsize=AT_TICKS, bbox=box, zorder=5)
    round_.set_thetagrids(QUARTERS[:-1])
    round_.spines["polar"].set_visible(False)
    round_.set_title(scale.label("Deviation from the circle"), loc="left", pad=12.0)
    unrolled.set(xticks=QUARTERS, xlabel="Angle [°]; an axis reverses at each tick", ylabel=scale.label("Deviation"))
    handles, labels = round_.get_legend_handles_labels()
    space = style.WIDTH * unrolled.get_position().width - 0.4
    unrolled.legend(
        handles,
        shortened_apart(labels, space),
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=1,
        frameon=False,
        handlelength=2.2,
        borderpad=0.1,
        borderaxespad=0.2,
        labelspacing=0.3,
    )
    return figure


FIGURE = ReportFigure(
    name="circles",
    takes=("circles", "kind"),
    draw=circles,
    alternative="Radial deviation of the circle, around it and unrolled",
    caption="How far from round the two axes run, magnified, around the grey circle on the left. At each of the four "
    "reversals friction changes sides, and the path bulges.",
)
