"""Following error over time, loop by loop to one scale, forward and backward motion of the reference apart."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.envelope import line
from bristle.figures.labels import scale_for, time_scale

if TYPE_CHECKING:
    from bristle.simulation.result import VariantResult

__all__ = ["tracking_error"]

FORWARD: style.Look = style.MEASURED | {"linewidth": 1.5}


@style.styled
def tracking_error(results: Mapping[str, VariantResult], settle: float, kind: Kind = "translational") -> Figure:
    """Return the following error over time, a row for each loop.

    Parameters
    ----------
    results : mapping of str to VariantResult
        Loops by the name above their row.
    settle : float
        Time at the start that is left out [s].
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    figure, grid = style.panels(0.4 + 1.75 * len(results), rows=len(results), top=0.4)
    errors = {name: result.reference - result.measured for name, result in results.items()}
    judged = {name: result.time >= settle for name, result in results.items()}
    # In the unit of the motion: a thousandth of it is easily seen as such.
    length = scale_for("length", kind, *(result.reference for result in results.values()))
    low = min(float(errors[name][judged[name]].min()) for name in results) * length.factor
    high = max(float(errors[name][judged[name]].max()) for name in results) * length.factor
    for (axes,), (name, result) in zip(grid, results.items(), strict=True):
        forward = np.gradient(result.reference) > 0.0
        span = time_scale(result.time)
        for moving, look, label in ((forward, FORWARD, "moving forward"), (~forward, style.PREDICTED, "moving backward")):
            x, y = line(result.time[judged[name]], np.where(moving, errors[name], np.nan)[judged[name]], columns=960)
            axes.plot(x * span.factor, y * length.factor, label=label, **look)
        axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
        axes.set_xlabel(span.label("Time"))
        axes.set_ylabel(length.label("Following error"))
    reach = style.legend_in_corner(figure, grid[0][0])
    for (first, *_), name in zip(grid, results, strict=True):
        style.title(first, name, beside=reach if first is grid[0][0] else 0.0)
    return figure
