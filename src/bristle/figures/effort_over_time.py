"""Measured and predicted effort over time, and the stretch in which they differ most, close up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.envelope import envelope, runs
from bristle.figures.labels import effort_scale, time_scale
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.core.variable import Kind
    from bristle.identification.result import Fit


@style.styled
def effort_over_time(fit: Fit) -> Figure:
    """Return measured and predicted effort over time, whole and close up."""
    traces, kind = fit.traces, fit.plant.kind
    figure, ((full,), (close,)) = style.panels(4.3, rows=2)
    draw_pair(full, close, traces.time, traces.measured, traces.predicted, kind)
    style.legend(full)
    return figure


def draw_pair(
    full: style.Axes,
    close: style.Axes,
    time: np.ndarray,
    measured: np.ndarray,
    predicted: np.ndarray,
    kind: Kind,
    half_width: np.ndarray | None = None,
) -> None:
    """Draw measured and predicted effort into two panels, the second one close up where they differ most.

    With a `half_width` [N or N*m] the 95 % band around what is predicted is shaded.
    """
    scale, word = effort_scale(kind, measured, predicted)
    near = window(time, measured - predicted)
    for axes, part in ((full, slice(None)), (close, near)):
        if half_width is not None:
            draw_band(axes, time[part] * time_scale(time[part]).factor, predicted[part] * scale.factor, half_width[part] * scale.factor)
        pair = (measured[part], style.MEASURED, "measured"), (predicted[part], style.PREDICTED, "predicted")
        style.over_time(axes, time[part], *pair, scale=scale, word=word)
    style.mark_window(full, time[near] * time_scale(time).factor)
    close.set_title("close up, around the largest difference")


def draw_band(axes: style.Axes, x: np.ndarray, middle: np.ndarray, half_width: np.ndarray) -> None:
    """Shade a band around a line, in the units of the panel, shape (sample,) each."""
    label = "95 % band"
    for part in runs(x, middle + half_width):
        # The outline of the band turns where what is predicted does.
        samples = envelope((middle + half_width)[part]) + part.start
        low, high = middle[samples] - half_width[samples], middle[samples] + half_width[samples]
        axes.fill_between(x[samples], low, high, color=style.PREDICTED["color"], alpha=0.18, linewidth=0, label=label)
        label = "_"


def window(time: np.ndarray, error: np.ndarray, share: float = 0.03) -> slice:
    """Return the samples around the largest absolute error: `share` of all, at least 40."""
    count = min(max(round(share * time.size), 40), time.size)
    worst = int(np.argmax(np.nan_to_num(np.abs(error), nan=0.0, posinf=0.0)))
    start = min(max(worst - count // 2, 0), time.size - count)
    return slice(start, start + count)


FIGURE = ReportFigure(
    name="time",
    takes="fit",
    draw=effort_over_time,
    alternative="Measured and predicted effort over time",
    caption="Effort over the whole log, and close up where measured and predicted effort differ most (shaded above). "
    "Where the light line looks out from under the dark one, the model misses something.",
)
