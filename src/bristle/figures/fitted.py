"""A fit at a glance: measured and predicted effort, and what is left over, on one axis of time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.labels import effort_scale

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
    scale, word = effort_scale(kind, traces.measured, traces.predicted)
    pair = (traces.measured, style.MEASURED, "measured"), (traces.predicted, style.PREDICTED, "predicted")
    style.over_time(effort, traces.time, *pair, scale=scale, word=word)
    small, _ = effort_scale(kind, traces.residual)
    style.over_time(rest, traces.time, (traces.residual, style.REST, ""), scale=small, word="Residual")
    style.legend(effort)
    return figure
