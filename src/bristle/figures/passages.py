"""The experiments that a log contains: where they are, and the loops before sliding among them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for, time_scale
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.logs.log import Log
    from bristle.logs.passages import Passage

# Grey tells them apart too: from dark to light, and hatched.
SHADES = {
    "constant_velocity": ("#b9d3ea", ""),
    "loops": ("#f0cf8e", ""),
    "break_away": ("#b5dcc9", "////"),
    "chirp": ("#dcb6cf", "...."),
    "oscillation": ("#e6d7e1", "...."),
    "moves": ("#e4e7ea", ""),
}


LOOPS = ("loops", "break_away")


@style.styled
def passages(log: Log, segments: Sequence[Passage]) -> Figure:
    """Return position over time with its passages shaded, and the effort over position of the loops."""
    loops = [segment for segment in segments if segment.kind in LOOPS] if log.effort is not None else []
    figure, rows = style.panels(4.9 if loops else 2.4, rows=2 if loops else 1, heights=[1.0, 1.4] if loops else None)
    axes, time, position = rows[0][0], log.time.values, log.position.values
    span, scale, word = time_scale(time), scale_for("length", log.kind, position), position_word(log.kind)
    names = {kind: kind.replace("_", " ") for kind in SHADES}
    for segment in segments:
        if segment.kind in SHADES:
            shade, hatch = SHADES[segment.kind]
            look = {"facecolor": shade, "hatch": hatch, "edgecolor": "white", "linewidth": 0, "zorder": 0}
            axes.axvspan(segment.begin * span.factor, segment.end * span.factor, label=names[segment.kind], **look)
            names[segment.kind] = f"_{names[segment.kind].lstrip('_')}"
    style.over_time(axes, time, (position, style.PREDICTED, ""), scale=scale, word=word)
    style.legend(axes, columns=len(SHADES))
    if loops and log.effort is not None:
        _draw_loops(rows[1][0], log, log.effort.values, loops)
    return figure


def _draw_loops(axes: Axes, log: Log, effort: np.ndarray, loops: Sequence[Passage]) -> None:
    positions = [log.position.values[loop.samples] - log.position.values[loop.samples][0] for loop in loops]
    efforts = [effort[loop.samples] for loop in loops]
    length, (force, word) = scale_for("length", log.kind, *positions), effort_scale(log.kind, *efforts)
    step = max(sum(loop.size for loop in positions) // 20_000, 1)
    for x, u in zip(positions, efforts, strict=True):
        axes.plot(x[::step] * length.factor, u[::step] * force.factor, **style.REST)
    title = "loops before sliding and break-aways, each from where it begins"
    axes.set(title=title, xlabel=length.label(position_word(log.kind)), ylabel=force.label(word))


def _has_loops(log: Log, passages: Sequence[Passage]) -> bool:
    return log.effort is not None and any(passage.kind in LOOPS for passage in passages)


FIGURE = ReportFigure(
    name="passages",
    takes=("log", "passages"),
    draw=passages,
    alternative=lambda log, passages: f"Position over time{', and effort over position of its loops' if _has_loops(log, passages) else ''}",
    caption=lambda log, passages: (
        "Shaded: what kind of experiment each part of the log is."
        + " Below, effort over position where friction turns slowly: loops that lie inside one another tell models of "
        "friction apart; loops of one amplitude do not." * _has_loops(log, passages)
    ),
)
