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
    from bristle.loop import Budget

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
    figure, (axes,) = style.named_rows([entry.cause for entry in entries], style.PAIR)
    rows = np.arange(len(entries))
    axes.barh(rows - 0.5 * BAR, alone * scale.factor, BAR, label="this cause alone", **style.BAR)
    axes.barh(rows + 0.5 * BAR, without * scale.factor, BAR, label="all but this cause", **style.HATCHED_BAR)
    axes.axvline(total * scale.factor, label="all causes", **style.DASHED)
    axes.set(xlim=(0.0, 1.06 * (axes.dataLim.x1 or 1.0)), xlabel=scale.label("Following error, peak to peak"), ylabel="Cause")
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
