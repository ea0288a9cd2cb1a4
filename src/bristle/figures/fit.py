"""Figures of a fit or a prediction and its log: friction over velocity, signals over time, residuals."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core import NORMAL_95
from bristle.figures import style
from bristle.figures.report_figure import ReportFigure
from bristle.palette import LIGHT
from bristle.simulation import MODES

if TYPE_CHECKING:
    from bristle.core import Kind
    from bristle.identification import Fit
    from bristle.simulation import Prediction


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
    """Draw measured and predicted effort into two panels, the second panel close up at the largest difference.

    With a `half_width` [N or N*m] the 95 % band around the prediction is shaded.
    """
    scale, word = style.effort_scale(kind, measured, predicted)
    near = style.window(time, measured - predicted)
    for axes, part in ((full, slice(None)), (close, near)):
        if half_width is not None:
            x = time[part] * style.time_scale(time[part]).factor
            draw_band(axes, x, predicted[part] * scale.factor, half_width[part] * scale.factor)
        pair = (measured[part], style.MEASURED, "measured"), (predicted[part], style.PREDICTED, "predicted")
        style.over_time(axes, time[part], *pair, scale=scale, word=word)
    style.mark_window(full, time[near] * style.time_scale(time).factor)
    close.set_title("close up, around the largest difference")


def draw_band(axes: style.Axes, x: np.ndarray, middle: np.ndarray, half_width: np.ndarray) -> None:
    """Shade a band around a line, in the units of the panel, shape (sample,) each."""
    label = "95 % band"
    for part in style.runs(x, middle + half_width):
        # The outline of the band turns where the prediction does.
        samples = style.envelope((middle + half_width)[part]) + part.start
        low, high = middle[samples] - half_width[samples], middle[samples] + half_width[samples]
        axes.fill_between(x[samples], low, high, color=style.PREDICTED["color"], alpha=0.18, linewidth=0, label=label)
        label = "_95 % band"


TIME = ReportFigure(
    name="time",
    takes="fit",
    draw=effort_over_time,
    alternative="Measured and predicted effort over time",
    caption="Effort over the whole log, and close up where measured and predicted effort differ most (shaded above). "
    "Where the light line of the measurement is visible, the model is wrong.",
)


@style.styled
def residuals(fit: Fit) -> Figure:
    """Return residuals over time, their distribution with a normal distribution, and their autocorrelation."""
    time, residual = fit.traces.time, fit.traces.residual
    scale, _ = style.effort_scale(fit.plant.kind, residual)
    figure, ((over_time, spread), (white,)) = style.panels(4.3, rows=2, columns=2, widths=(3.1, 1.0), undivided=(1,), between=0.2, top=0.26)
    style.over_time(over_time, time, (residual, style.REST, ""), scale=scale, word="Residual")
    scaled = residual * scale.factor
    mean, std = float(scaled.mean()), float(scaled.std())
    reach = 4.0 * std or 1.0
    edges = np.linspace(mean - reach, mean + reach, 41)
    spread.stairs(style.shares(scaled, edges), edges, orientation="horizontal", fill=True, color="#ecd3a0", label="residual")
    if std > 0.0:
        grid = np.linspace(edges[0], edges[-1], 121)
        normal = 100.0 * (edges[1] - edges[0]) * np.exp(-0.5 * ((grid - mean) / std) ** 2) / (std * sqrt(2.0 * pi))
        spread.plot(normal, grid, color=style.PREDICTED["color"], label="normal")
    spread.set_xlabel("Share [%]")
    spread.tick_params(labelleft=False)
    style.legend(spread, columns=2, handle=1.0)
    spread.set_ylim(over_time.get_ylim())
    correlation, count = autocorrelation(time, residual)
    lags = float(np.median(np.diff(time))) * np.arange(correlation.size)
    span, band = style.time_scale(lags), NORMAL_95 / np.sqrt(count)
    white.axhspan(-band, band, color=LIGHT["band"], label="95 % band of white noise")
    white.vlines(lags * span.factor, 0.0, correlation, color=style.PREDICTED["color"], linewidth=style.WIDE)
    white.axhline(0.0, **style.AID)
    white.set(xlabel=span.label("Lag"), ylabel="Autocorrelation [–]", ylim=(min(-0.3, correlation.min() - 0.05), 1.05))
    style.legend(white)
    return figure


def autocorrelation(time: np.ndarray, residual: np.ndarray, lags: int = 60) -> tuple[np.ndarray, int]:
    """Return the autocorrelation of residuals, without products across a gap in time, and the number of samples used."""
    parts = [residual[part] - residual.mean() for part in style.runs(time, residual)]
    longest = max((part.size for part in parts), default=1)
    reach = min(lags, longest - 1)
    products = np.array([sum(float(part[: part.size - lag] @ part[lag:]) for part in parts if part.size > lag) for lag in range(reach + 1)])
    return (products / products[0] if products[0] > 0.0 else products), sum(part.size for part in parts)


RESIDUALS = ReportFigure(
    name="residuals",
    takes="fit",
    draw=residuals,
    alternative="Residuals over time, their distribution and autocorrelation",
    caption="Measured minus predicted effort. Bursts at reversals indicate pre-sliding friction, a drift indicates temperature "
    "or load. Bars of the autocorrelation outside the band mean that neighbouring residuals are correlated. Standard "
    "errors, which assume independence, are then too small.",
)


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
        error, half_width, word = predicted.position - position, predicted.position_half_width, style.position_word(kind)
        scale, error_scale = style.scale_for("length", kind, predicted.position, position), style.scale_for("length", kind, error)
        if half_width is not None:
            x = time * style.time_scale(time).factor
            draw_band(course, x, position * scale.factor, half_width * scale.factor)
            draw_band(off, x, np.zeros(x.size), half_width * error_scale.factor)
        pair = (predicted.position, style.MEASURED, "measured"), (position, style.PREDICTED, "predicted")
        style.over_time(course, time, *pair, scale=scale, word=word)
        style.over_time(off, time, (error, style.REST, ""), scale=error_scale, word=f"{word} error")
    style.legend(axes[0])
    return figure


PREDICTION = ReportFigure(
    name="prediction",
    takes=("prediction", "kind"),
    draw=prediction,
    alternative=lambda predicted, kind: f"Measured and predicted signals, {predicted.mode} mode",
    caption=lambda predicted, kind: (
        f"The model, simulated on the log in {predicted.mode} mode: {MODES.get(predicted.mode, '')}. Where the light line "
        "of the measurement is visible, the prediction is wrong."
        + " The shading is the 95 % band of the measurement."
        * (predicted.half_width is not None or predicted.position_half_width is not None)
    ),
    applies=lambda predicted, kind: predicted.effort_predicted is not None or predicted.position_predicted is not None,
)
