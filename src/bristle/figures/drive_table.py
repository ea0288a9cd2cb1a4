"""The table for the drive over the friction curve that it stands for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, scale_for
from bristle.figures.report_figure import ReportFigure

__all__ = ["FIGURE", "drive_table"]


@style.styled
def drive_table(table: Sequence[tuple[float, float]], curve: Sequence[tuple[float, float]] = (), kind: Kind = "translational") -> Figure:
    """Return the entries of a table, joined as a drive interpolates them, over the steady friction.

    Parameters
    ----------
    table : sequence of (velocity, effort)
        Entries in order of velocity [m/s or rad/s, N or N*m]; a velocity of -0.0 is the backward side of rest.
    curve : sequence of (velocity, effort)
        Steady friction of the model, finer.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    entries, fine = (np.array(list(points), dtype=float).reshape(-1, 2) for points in (table, curve))
    scale, word = effort_scale(kind, entries[:, 1], fine[:, 1])
    speed = scale_for("length/time", kind, entries[:, 0], fine[:, 0])
    figure, ((axes,),) = style.panels(3.4)
    factors = (speed.factor, scale.factor)
    style.plot_by_side(axes, fine * factors, "model, steady sliding", style.MEASURED | {"linewidth": 3.4})
    style.plot_by_side(axes, entries * factors, f"table, {len(entries)} entries", style.PREDICTED | {"marker": "o", "markersize": 3.6})
    axes.axhline(0.0, **style.AID)
    axes.set(xlabel=speed.label("Velocity"), ylabel=scale.label(f"Friction {word.lower()}"))
    style.legend(axes)
    return figure


FIGURE = ReportFigure(
    name="drive",
    takes=("table", "curve", "kind"),
    draw=drive_table,
    applies=lambda table, curve, kind: bool(table),
    alternative="Entries of the drive table over the friction curve",
    caption="The entries of the table, joined by straight lines as a drive joins them, over the steady friction of the "
    "model. Where the two part, the drive would need more entries.",
)
