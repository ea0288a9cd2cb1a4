"""Figures of a fit or a prediction and its log: friction over velocity, signals over time, residuals."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from bristle.core import NORMAL_95, Kind
from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.first_screen import LOW, SIDE, draw_pair, over_a_strip
from bristle.report.figures.report_figure import shown

if TYPE_CHECKING:
    from bristle.identification import Fit
    from bristle.simulation import Prediction


@shown(
    "time",
    "fit",
    "Measured and predicted effort over time",
    "Effort over the whole log, and close up where measured and predicted effort differ most (shaded above). "
    "Where the light line of the measurement is visible, the model is wrong.",
)
def effort_over_time(fit: Fit) -> Figure:
    """Return measured and predicted effort over time, whole and close up."""
    traces, kind = fit.traces, fit.plant.kind
    figure, ((full,), (close,)) = style.panels(4.3, rows=2)
    scale, word = style.effort_scale(kind, traces.measured, traces.predicted)
    near = style.window(traces.time, traces.measured - traces.predicted)
    for axes, part in ((full, slice(None)), (close, near)):
        pair = (
            (traces.measured[part], style.MEASURED, "measured"),
            (traces.predicted[part], style.PREDICTED, "predicted"),
        )
        style.over_time(axes, traces.time[part], *pair, scale=scale, word=word)
    style.mark_window(full, traces.time[near] * style.time_scale(traces.time).factor)
    close.set_title("close up, around the largest difference")
    style.legend(full)
    return figure


def draw_band(axes: style.Axes, x: np.ndarray, middle: np.ndarray, half_width: np.ndarray) -> None:
    """Shade a band around a line, in the units of the panel, shape (sample,) each."""
    label = "95 % band"
    for part in style.runs(x, middle + half_width):
        # The outline of the band turns where the prediction does.
        samples = style.envelope((middle + half_width)[part]) + part.start
        low, high = middle[samples] - half_width[samples], middle[samples] + half_width[samples]
        axes.fill_between(
            x[samples],
            low,
            high,
            color=style.PREDICTED["color"],
            alpha=0.18,
            linewidth=0,
            label=label,
        )
        label = "_95 % band"


@shown(
    "residuals",
    "fit",
    "Residuals over time, their distribution and autocorrelation",
    "Measured minus predicted effort. Bursts at reversals indicate pre-sliding friction, a drift indicates temperature "
    "or load. Bars of the autocorrelation outside the band mean that neighbouring residuals are correlated. Standard "
    "errors, which assume independence, are then too small.",
)
def residuals(fit: Fit) -> Figure:
    """Return residuals over time, their distribution with a normal distribution, and their autocorrelation."""
    time, residual = fit.traces.time, fit.traces.residual
    scale, _ = style.effort_scale(fit.plant.kind, residual)
    figure, ((over_time, spread), (white,)) = style.panels(
        4.3, rows=2, columns=2, widths=(3.1, 1.0), undivided=(1,), between=0.2, top=0.26
    )
    style.over_time(over_time, time, (residual, style.REST, ""), scale=scale, word="Residual")
    scaled = residual * scale.factor
    mean, std = float(scaled.mean()), float(scaled.std())
    reach = 4.0 * std or 1.0
    edges = np.linspace(mean - reach, mean + reach, 41)
    spread.stairs(
        style.shares(scaled, edges),
        edges,
        orientation="horizontal",
        fill=True,
        color=style.MEASURED["color"],
        alpha=0.5,
        label="residual",
    )
    if std > 0.0:
        grid = np.linspace(edges[0], edges[-1], 121)
        normal = (
            100.0
            * (edges[1] - edges[0])
            * np.exp(-0.5 * ((grid - mean) / std) ** 2)
            / (std * sqrt(2.0 * pi))
        )
        spread.plot(normal, grid, color=style.PREDICTED["color"], label="normal")
    spread.set_xlabel("Share [%]")
    spread.tick_params(labelleft=False)
    style.legend(spread, columns=2, handle=1.0)
    spread.set_ylim(over_time.get_ylim())
    correlation, count = autocorrelation(time, residual)
    lags = float(np.median(np.diff(time))) * np.arange(correlation.size)
    span, band = style.time_scale(lags), NORMAL_95 / np.sqrt(count)
    white.axhspan(-band, band, color=LIGHT["band"], label="95 % band of white noise")
    white.vlines(
        lags * span.factor, 0.0, correlation, color=style.PREDICTED["color"], linewidth=style.WIDE
    )
    white.axhline(0.0, **style.AID)
    white.set(
        xlabel=span.label("Lag"),
        ylabel="Autocorrelation [–]",
        ylim=(min(-0.3, correlation.min() - 0.05), 1.05),
    )
    style.legend(white)
    return figure


def autocorrelation(
    time: np.ndarray, residual: np.ndarray, lags: int = 60
) -> tuple[np.ndarray, int]:
    """Return the autocorrelation of residuals, without products across a gap in time, and the number of samples used."""
    parts = [residual[part] - residual.mean() for part in style.runs(time, residual)]
    longest = max((part.size for part in parts), default=1)
    reach = min(lags, longest - 1)
    products = np.array(
        [
            sum(float(part[: part.size - lag] @ part[lag:]) for part in parts if part.size > lag)
            for lag in range(reach + 1)
        ]
    )
    return (products / products[0] if products[0] > 0.0 else products), sum(
        part.size for part in parts
    )


class _Signal(NamedTuple):
    """A measured signal, its prediction, the half-width of its 95 % band, and its quantity and name."""

    measured: np.ndarray
    predicted: np.ndarray
    half_width: np.ndarray | None
    quantity: str
    word: str


def _signals(predicted: Prediction, kind: Kind) -> list[_Signal]:
    """Return the signals that a mode predicts, effort first."""
    signals = []
    if predicted.effort is not None and predicted.effort_predicted is not None:
        signals.append(
            _Signal(
                predicted.effort,
                predicted.effort_predicted,
                predicted.half_width,
                "force",
                style.effort_word(kind),
            )
        )
    if (position := predicted.position_predicted) is not None:
        signals.append(
            _Signal(
                predicted.position,
                position,
                predicted.position_half_width,
                "length",
                style.position_word(kind),
            )
        )
    return signals


@shown(
    "prediction",
    ("prediction", "kind"),
    lambda predicted, kind: f"Measured and predicted signals, {predicted.mode} mode",
    lambda predicted, kind: (
        "Shaded: the 95 % band of the measurement."
        * any(signal.half_width is not None for signal in _signals(predicted, kind)[:1])
    ),
    applies=lambda predicted, kind: bool(_signals(predicted, kind)),
)
def prediction(predicted: Prediction, kind: Kind = "translational") -> Figure:
    """Return measured and predicted effort, or else position, around the largest difference, and below over the whole log."""
    signal, time = _signals(predicted, kind)[0], predicted.time
    figure, near, strip = over_a_strip(["measured"])
    scale, part = (
        style.scale_for(signal.quantity, kind, signal.measured, signal.predicted),
        style.window(time, signal[0] - signal[1], 0.1),
    )
    for axes, chosen in ((near, part), (strip, slice(None))):
        x, middle = (
            time[chosen] * style.time_scale(time[chosen]).factor,
            signal.predicted[chosen] * scale.factor,
        )
        if signal.half_width is not None:
            draw_band(axes, x, middle, signal.half_width[chosen] * scale.factor)
    draw_pair(
        near, strip, time, (signal.measured, signal.predicted), part, scale=scale, word=signal.word
    )
    return figure


@shown(
    "error",
    ("prediction", "kind"),
    "Measured minus predicted signals over time",
    "Measured minus predicted.",
    applies=lambda predicted, kind: bool(_signals(predicted, kind)),
)
def prediction_error(predicted: Prediction, kind: Kind = "translational") -> Figure:
    """Return measured minus predicted effort and position over time, as far as the mode predicts them."""
    signals, x = _signals(predicted, kind), predicted.time * style.time_scale(predicted.time).factor
    figure, grid = style.panels(LOW * len(signals) - 0.3, rows=len(signals), across=SIDE, top=0.12)
    for (axes,), signal in zip(grid, signals, strict=True):
        error = signal.measured - signal.predicted
        scale = style.scale_for(signal.quantity, kind, error)
        if signal.half_width is not None:
            draw_band(axes, x, np.zeros(x.size), signal.half_width * scale.factor)
        style.over_time(
            axes, predicted.time, (error, style.REST, ""), scale=scale, word=f"{signal.word} error"
        )
    return figure
