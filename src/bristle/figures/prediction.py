"""A prediction beside the log: effort, position, and how far off they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.effort_over_time import draw_band, draw_pair
from bristle.figures.labels import position_word, scale_for, time_scale
from bristle.figures.report_figure import ReportFigure
from bristle.simulation.result import MODES

if TYPE_CHECKING:
    from bristle.core.variable import Kind
    from bristle.simulation.result import Prediction

__all__ = ["FIGURE", "prediction"]


@style.styled
def prediction(predicted: Prediction, kind: Kind = "translational") -> Figure:
    """Return measured and predicted effort and position over time, as far as the mode predicts them.

    Parameters
    ----------
    predicted : Prediction
        What a model says of a log.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    effort, effort_predicted = predicted.effort, predicted.effort_predicted
    with_effort = effort is not None and effort_predicted is not None
    rows = 2 * with_effort + 2 * (predicted.position_predicted is not None)
    figure, grid = style.panels(0.5 + style.ROW * rows, rows=rows)
    axes = [row[0] for row in grid]
    if effort is not None and effort_predicted is not None:
        draw_pair(axes[0], axes[1], predicted.time, effort, effort_predicted, kind, predicted.half_width)
    if predicted.position_predicted is not None:
        _draw_position(axes[-2], axes[-1], predicted, predicted.position_predicted, kind)
    style.legend(axes[0])
    return figure


def _draw_position(course: style.Axes, off: style.Axes, log: Prediction, position_predicted: np.ndarray, kind: Kind) -> None:
    error = log.position - position_predicted
    scale = scale_for("length", kind, log.position, position_predicted)
    error_scale, half_width = scale_for("length", kind, error), log.position_half_width
    if half_width is not None:
        x = log.time * time_scale(log.time).factor
        draw_band(course, x, position_predicted * scale.factor, half_width * scale.factor)
        draw_band(off, x, np.zeros(x.size), half_width * error_scale.factor)
    word, pair = position_word(kind), ((log.position, style.MEASURED, "measured"), (position_predicted, style.PREDICTED, "predicted"))
    style.over_time(course, log.time, *pair, scale=scale, word=word)
    style.over_time(off, log.time, (error, style.REST, ""), scale=error_scale, word=f"{word} error")


FIGURE = ReportFigure(
    name="prediction",
    takes=("prediction", "kind"),
    draw=prediction,
    alternative=lambda predicted, kind: f"Measured and predicted signals, {predicted.mode} mode",
    caption=lambda predicted, kind: (
        f"The model run on the log in {predicted.mode} mode: {MODES.get(predicted.mode, '')}. Where the light line "
        "looks out from under the dark one, what was measured is not predicted."
        + " Shaded: where 95 % of what is measured are expected."
        * (predicted.half_width is not None or predicted.position_half_width is not None)
    ),
    applies=lambda predicted, kind: predicted.effort_predicted is not None or predicted.position_predicted is not None,
)
