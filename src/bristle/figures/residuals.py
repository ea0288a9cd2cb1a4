"""What the model leaves over: residuals in time, their distribution, and whether they are white."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.normal import NORMAL_95
from bristle.figures import style
from bristle.figures.envelope import runs
from bristle.figures.labels import effort_scale, time_scale
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Fit


@style.styled
def residuals(fit: Fit) -> Figure:
    """Return residuals over time, their distribution beside a normal one, and their autocorrelation."""
    time, residual = fit.traces.time, fit.traces.residual
    scale, _ = effort_scale(fit.plant.kind, residual)
    figure, ((over_time, spread), (white,)) = style.panels(4.3, rows=2, columns=2, widths=(3.1, 1.0), undivided=(1,), between=0.2, top=0.26)
    style.over_time(over_time, time, (residual, style.REST, ""), scale=scale, word="Residual")
    scaled = residual * scale.factor
    mean, std = float(scaled.mean()), float(scaled.std())
    reach = 4.0 * std or 1.0
    edges = np.linspace(mean - reach, mean + reach, 41)
    counts, _ = np.histogram(scaled, edges)
    spread.stairs(100.0 * counts / scaled.size, edges, orientation="horizontal", fill=True, color="#ecd3a0", label="residual")
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
    span, band = time_scale(lags), NORMAL_95 / np.sqrt(count)
    white.axhspan(-band, band, color="#dbe6f2", label="95 % band of white noise")
    white.vlines(lags * span.factor, 0.0, correlation, color=style.PREDICTED["color"], linewidth=style.WIDE)
    white.axhline(0.0, **style.AID)
    white.set(xlabel=span.label("Lag"), ylabel="Autocorrelation [–]", ylim=(min(-0.3, correlation.min() - 0.05), 1.05))
    style.legend(white)
    return figure


def autocorrelation(time: np.ndarray, residual: np.ndarray, lags: int = 60) -> tuple[np.ndarray, int]:
    """Return the autocorrelation of residuals, no product taken across a gap in time, and the samples used."""
    parts = [residual[part] - residual.mean() for part in runs(time, residual)]
    longest = max((part.size for part in parts), default=1)
    reach = min(lags, longest - 1)
    products = np.array([sum(float(part[: part.size - lag] @ part[lag:]) for part in parts if part.size > lag) for lag in range(reach + 1)])
    return (products / products[0] if products[0] > 0.0 else products), sum(part.size for part in parts)


FIGURE = ReportFigure(
    name="residuals",
    takes="fit",
    draw=residuals,
    alternative="Residuals over time, their distribution and autocorrelation",
    caption="What the model leaves over. Bursts at reversals point to friction before sliding, a drift to temperature "
    "or load. Bars of the autocorrelation outside the band mean that neighbouring residuals are alike: then standard "
    "errors, which take them for independent, are too small.",
)
