"""Models side by side, by their error on time blocks that they were not fitted to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from bristle.figures import style
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Identification

__all__ = ["FIGURE", "model_comparison"]

APART = 3.0  # times: errors farther apart are shown on a logarithmic scale, or those of good models fall into one
TICKS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)


@style.styled
def model_comparison(identification: Identification) -> Figure:
    """Return the error of each model: on each held-out block, their mean, and on the log it was fitted to.

    Parameters
    ----------
    identification : Identification
        Models fitted to one log, best first.
    """
    fits = identification.fits
    figure, (axes,) = style.named_rows([fit.name for fit in fits])
    fold = "log" if any(fit.held_out is not None and fit.held_out.of == "logs" for fit in fits) else "block"
    names = {"blocks": f"held-out {fold}", "mean": f"mean of the {fold}s", "fitted": "all of it, fitted"}
    for row, fit in enumerate(fits):
        if fit.held_out is not None:
            blocks = fit.held_out.block_errors_percent
            strokes = {"markersize": 11, "markeredgewidth": 1.3, "color": style.MEASURED["color"]}
            axes.plot(blocks, np.full(len(blocks), row), "|", label=names.pop("blocks", "_"), **strokes)
            axes.plot(fit.held_out.mean_percent, row, "o", color=style.PREDICTED["color"], label=names.pop("mean", "_"))
        axes.plot(fit.error_percent, row, "D", fillstyle="none", color=style.INK, label=names.pop("fitted", "_"))
    scale = _scale(axes)
    quantity, of = ("Effort", "effort") if fits[0].position_error_percent is None else ("Position", "position")
    axes.set(xlabel=f"{quantity} error [% of the {of}, root mean square{scale}]", ylabel="Model")
    style.legend(axes)
    return figure


def _scale(axes: Axes) -> str:
    """Set the scale of the errors, with room on the right for the mark of the largest one; return its name."""
    least, most = axes.dataLim.x0, axes.dataLim.x1
    if not most > APART * least > 0.0:
        axes.set_xlim(0.0, 1.05 * max(most, np.finfo(float).tiny))
        return ""
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlim(least / 1.1, 1.1 * most)
    return ", logarithmic"


FIGURE = ReportFigure(
    name="comparison",
    takes="identification",
    draw=model_comparison,
    applies=lambda identification: len(identification.fits) > 1,
    alternative="Error of each model on what was held out",
    caption="Each stroke is one time block, or of several logs one, that the model was not fitted to. Models whose "
    "strokes overlap are about equally good here: then the simpler one is the safer choice.",
)
