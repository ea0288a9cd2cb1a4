"""A fit at a glance: measured and predicted effort, and what is left over, on one axis of time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.envelope import line
from bristle.figures.labels import effort_scale, time_scale

if TYPE_CHECKING:
    from bristle.identification.result import Fit

__all__ = ["fitted"]


@style.styled
def fitted(fit: Fit) -> Figure:
    """Return measured and predicted effort over time, and below it the residual.

    Parameters
    ----------
    fit : Fit
        A model and the traces that it was fitted to.
    """
    traces, kind = fit.traces, fit.plant.kind
    figure, ((effort,), (rest,)) = style.panels(3.9, rows=2, heights=(2.0, 1.0))
    span = time_scale(traces.time)
    scale, word = effort_scale(kind, traces.measured, traces.predicted)
    for signal, look, name in ((traces.measured, style.MEASURED, "measured"), (traces.predicted, style.PREDICTED, "predicted")):
        x, y = line(traces.time, signal)
        effort.plot(x * span.factor, y * scale.factor, label=name, **look)
    small, _ = effort_scale(kind, traces.residual)
    x, y = line(traces.time, traces.residual)
    rest.plot(x * span.factor, y * small.factor, color=style.PREDICTED["color"], linewidth=0.7)
    effort.set_ylabel(scale.label(word))
    rest.set_ylabel(small.label("Residual"))
    for axes in (effort, rest):
        axes.set_xlabel(span.label("Time"))
    style.legend(effort)
    return figure
