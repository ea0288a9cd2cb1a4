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


@style.styled
def prediction(predicted: Prediction, kind: Kind = "translational") -> Figure:
    """Return measured and predicted effort and position over time, as far as the mode predicts them."""
    effort, effort_predicted = predicted.effort, predicted.effort_predicted
    with_effort = effort is not None and effort_predicted is not None
    rows = 2 * with_effort + 2 * (predicted.position_predicted is not None)
    figure, grid = style.panels(0.5 + style.ROW * rows, rows=rows)
    axes = [row[0] for row in grid]
    if effort is not None and effort_predicted is not None:
        draw_pair(axes[0], axes[1], predicted.time, effort, effort_predicted, kind, predicted.half_width)
    if predicted.position_predicted is not None:
        course, off, time, position = axes[-2], axes[-1], predicted.time, predicted.position_predicted
        error, half_width, word = predicted.position - position, predicted.position_half_width, position_word(kind)
        scale, error_scale = scale_for("length", kind, predicted.position, position), scale_for("length", kind, error)
        if half_width is not None:
            x = time * time_scale(time).factor
            draw_band(course, x, position * scale.factor, half_width * scale.factor)
            draw_band(off, x, np.zeros(x.size), half_width * error_scale.factor)
        pair = (predicted.position, style.MEASURED, "measured"), (position, style.PREDICTED, "predicted")
        style.over_time(course, time, *pair, scale=scale, word=word)
        style.over_time(off, time, (error, style.REST, ""), scale=error_scale, word=f"{word} error")
    style.legend(axes[0])
    return figure


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
