"""A figure of your own: the residual over the position. It shows friction that depends on the position.

``bristle identify log.csv --axis axis.toml --figure own_figure.py --out results`` adds it to the report.
"""

import numpy as np

from bristle.report.figures import ReportFigure, style
from bristle.report.figures.style import effort_scale, position_word, scale_for

BINS, FEWEST = 60, 5  # along the position; fewest samples of a bin in the figure


def draw(identification, log):
    kind, traces = identification.best.plant.kind, identification.best.traces
    position = np.interp(traces.time, np.asarray(log.time), np.asarray(log.position))
    length, (effort, _) = scale_for("length", kind, position), effort_scale(kind, traces.residual)
    edges = np.linspace(position.min(), position.max(), BINS + 1)
    figure, ((axes,),) = style.panels(2.8)
    for name, look, way in (("forward", style.MEASURED, 1.0), ("backward", style.PREDICTED, -1.0)):
        moving = way * traces.velocity > 0.0
        place = np.clip(np.digitize(position[moving], edges) - 1, 0, BINS - 1)
        count = np.bincount(place, minlength=BINS)
        mean = np.bincount(place, traces.residual[moving], BINS) / np.maximum(count, 1)
        shown = np.where(count >= FEWEST, mean, np.nan)
        axes.plot(
            length.factor * 0.5 * (edges[1:] + edges[:-1]),
            effort.factor * shown,
            label=name,
            **look,
        )
    axes.set_xlabel(length.label(position_word(kind)))
    axes.set_ylabel(effort.label("Residual, mean"))
    style.legend(axes)
    return figure


FIGURE = ReportFigure(
    name="residual_over_position",
    title="Residual over the position",
    caption="Mean of the residual at each position, by direction. If both lines rise and fall together over the position, "
    "friction or another force depends on it: add +position or +periodic to the model, or cogging to the axis file.",
    alternative="Mean residual over the position, forward and backward",
    takes=("identification", "log"),
    draw=draw,
)
