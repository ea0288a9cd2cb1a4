"""The error budget of a loop: each cause alone, and the loop without it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.labels import scale_for
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.core.variable import Kind
    from bristle.loop_design import Budget

__all__ = ["FIGURE", "error_budget"]

BAR = 0.36


@style.styled
def error_budget(budget: Budget, kind: Kind) -> Figure:
    """Return the following error of a loop with each cause alone, and without each, peak to peak.

    Parameters
    ----------
    budget : Budget
        What a loop errs by.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    entries = budget.entries
    alone = np.array([entry.alone.peak_to_peak for entry in entries])
    without = np.array([entry.without.peak_to_peak for entry in entries])
    total = budget.all_causes.peak_to_peak
    scale = scale_for("length", kind, alone, without, np.array([total, 1e-6]))
    left = max(0.4 + style.room_for([entry.cause for entry in entries]), 1.0)
    figure, ((axes,),) = style.panels(0.95 + 0.42 * len(entries), left=left)
    rows = np.arange(len(entries))
    axes.barh(rows - 0.5 * BAR, alone * scale.factor, BAR, color=style.PREDICTED["color"], label="this cause alone")
    axes.barh(
        rows + 0.5 * BAR,
        without * scale.factor,
        BAR,
        color=style.MEASURED["color"],
        hatch="////",
        edgecolor="white",
        linewidth=0.0,
        label="all but this cause",
    )
    axes.axvline(total * scale.factor, color=style.INK, linewidth=1.0, linestyle="--", label="all causes")
    axes.set_yticks(rows, [entry.cause for entry in entries])
    axes.set_ylim(len(entries) - 0.4, -0.6)
    axes.set_xlim(0.0, 1.06 * (axes.dataLim.x1 or 1.0))
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(scale.label("Following error, peak to peak"))
    axes.set_ylabel("Cause")
    style.legend(axes)
    return figure


FIGURE = ReportFigure(
    name="budget",
    takes=("budget", "kind"),
    draw=error_budget,
    alternative="Following error with each cause of error alone and without each",
    caption="A cause whose dark bar is long errs by itself; one whose light bar is far below the dashed line is worth "
    "removing first. The bars do not add up: causes go together, and a peak is not a sum.",
)
