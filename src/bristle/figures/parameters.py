"""Parameters with their uncertainty, side by side in percent of the value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from bristle.core.normal import NORMAL_95
from bristle.core.typography import number, scale_of
from bristle.figures import style
from bristle.figures.drawing import AT_TICKS
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Estimate, Fit

__all__ = ["FIGURE", "parameters"]

DECADES = (1.0, 10.0, 100.0)  # percent
EDGES = tuple(2.0 * decade for decade in DECADES)  # an interval wider than the last ends in an arrow


@style.styled
def parameters(fit: Fit) -> Figure:
    """Return the 95 % interval of each parameter in percent of its value, linear within 1 %, logarithmic beyond.

    Parameters
    ----------
    fit : Fit
        A model with the estimates of its parameters.
    """
    estimates = fit.estimates
    figure, (axes,) = style.named_rows([estimate.name for estimate in estimates], longest=style.NARROW, right=style.LONGEST)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.8)
    edge = _edge(estimates)
    axes.set_xlim(-edge, edge)
    for row, estimate in enumerate(estimates):
        _draw(axes, row, estimate, edge)
        place = {"xycoords": ("axes fraction", "data"), "xytext": (8, 0), "textcoords": "offset points"}
        axes.annotate(_in_words(estimate), (1.0, row), va="center", fontsize=AT_TICKS, **place)
    axes.set_xticks([0.0, *(side * decade for side in (-1.0, 1.0) for decade in DECADES if decade <= edge)])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:+g}".replace("-", "−") if x else "0"))
    axes.axvline(0.0, **style.AID)
    axes.set(xlabel="95 % interval about the estimate [% of value]", ylabel="Parameter")
    return figure


def _ends(estimate: Estimate) -> tuple[float, float]:
    """Return the ends of the interval about the value, in percent of it."""
    if estimate.interval is not None and estimate.value != 0.0:
        low, high = (100.0 * (end - estimate.value) / abs(estimate.value) for end in estimate.interval)
        return low, high
    percent = estimate.interval_percent
    half = percent if percent is not None and math.isfinite(percent) else math.inf
    return -half, half


def _edge(estimates: Sequence[Estimate]) -> float:
    widest = max((max(map(abs, _ends(estimate))) for estimate in estimates if estimate.status != "held"), default=0.0)
    return next((edge for edge in EDGES if widest <= edge), EDGES[-1])


def _draw(axes: style.Axes, row: int, estimate: Estimate, edge: float) -> None:
    if estimate.status == "held":
        axes.plot(0.0, row, marker="s", color=style.GREY, markersize=style.SMALL, fillstyle="none")
        return
    doubtful = estimate.status != "identified"
    low, high = _ends(estimate)
    look = {"color": style.DOUBTFUL if doubtful else style.PREDICTED["color"], "linestyle": "--" if doubtful else "-"}
    visible = max(low, -edge), min(high, edge)
    axes.plot(visible, [row, row], linewidth=style.WIDE, **look)
    for x, marker in zip(visible, ("|" if low >= -edge else "<", "|" if high <= edge else ">"), strict=True):
        axes.plot(x, row, marker=marker, color=look["color"], markersize=style.SMALL, clip_on=False)
    axes.plot(0.0, row, marker="D" if doubtful else "o", color=look["color"], markersize=style.SMALL)


def _in_words(estimate: Estimate) -> str:
    std = estimate.larger_std if estimate.larger_std is not None and math.isfinite(estimate.larger_std) else None
    if estimate.interval is not None:
        std = (estimate.interval[1] - estimate.interval[0]) / (2.0 * NORMAL_95)
    scale = scale_of(estimate.unit, estimate.value or std or 0.0)
    value = number(estimate.value * scale.factor, None if std is None else std * scale.factor)
    if estimate.status == "held":
        return f"{value} {scale.unit}, held".replace(" ,", ",")
    if estimate.status != "identified":
        return "not identified"
    if std is None:
        return f"{value} {scale.unit}"
    return f"{value} ± {number(std * scale.factor, std * scale.factor)} {scale.unit}"


FIGURE = ReportFigure(
    name="parameters",
    takes="fit",
    draw=parameters,
    alternative="95 % interval of each parameter in percent of its value",
    caption="95 % intervals in percent of each value, on a scale that is linear within ± 1 % and logarithmic beyond. "
    "Dashed: not identified by this log. Hollow square: held.",
)
