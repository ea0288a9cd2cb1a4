"""The loop as it is and those proposed for it: following error, effort and phase margin, side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.labels import effort_scale, scale_for
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bristle.core.variable import Kind


@style.styled
def loops_proposed(
    names: Sequence[str],
    errors: Sequence[float | None],
    efforts: Sequence[float | None],
    phases: Sequence[float | None],
    enough: float,
    kind: Kind = "translational",
) -> Figure:
    """Return bars of what each loop errs by, which effort it takes, and how large its least phase margin is."""
    figure, row = style.named_rows(names, style.PAIR, style.NARROW, 3, between=0.2)
    columns = [np.array([np.nan if value is None else value for value in side]) for side in (errors, efforts, phases)]
    length = scale_for("length", kind, columns[0][np.isfinite(columns[0])], np.array([1e-6]))
    force, word = effort_scale(kind, columns[1][np.isfinite(columns[1])])
    places = np.arange(len(names), dtype=float)
    factors = (length.factor, force.factor, 1.0)
    labels = (length.label("Error, p-p"), force.label(f"{word}, rms"), "Phase margin [°]")
    for axes, values, factor, label in zip(row, columns, factors, labels, strict=True):
        for place, value in zip(places, values * factor, strict=True):
            if np.isfinite(value):
                axes.barh(place, value, 0.55, **style.HATCHED_BAR if place else style.BAR)
        axes.set(xlim=(0.0, 1.08 * (np.nanmax(values, initial=0.0) * factor or 1.0)), xlabel=label)
        axes.set_ylabel("Loop", visible=axes is row[0])  # the numbers of each panel have this head
    row[-1].axvline(enough, **style.DASHED)
    row[-1].set_title(f"dashed: usual least, {enough:g}°")
    return figure


FIGURE = ReportFigure(
    name="loops",
    takes=("design", "names", "phases", "enough"),
    draw=lambda design, names, phases, enough: loops_proposed(
        names,
        [None if loop.following_error is None else loop.following_error.peak_to_peak for loop in design.proposals],
        [loop.effort_rms for loop in design.proposals],
        phases,
        enough,
        design.experiment.kind,
    ),
    alternative="Following error, effort and smallest phase margin of the loop as it is and of those proposed",
    caption=lambda design, names, phases, enough: (
        f"Simulated following error and effort, and the smallest phase margin without friction: {design.variant.name} "
        "is the loop as it is, the others are proposed."
    ),
)
