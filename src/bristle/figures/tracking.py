"""Desired and measured position over time, loop by loop, whole and close up where the reference turns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.envelope import line
from bristle.figures.labels import position_word, scale_for, time_scale

if TYPE_CHECKING:
    from bristle.simulation.result import VariantResult

__all__ = ["tracking"]


@style.styled
def tracking(results: Mapping[str, VariantResult], settle: float, close: tuple[float, float], kind: Kind = "translational") -> Figure:
    """Return reference and encoder reading over time, a row for each loop.

    Parameters
    ----------
    results : mapping of str to VariantResult
        Loops by the name above their row.
    settle : float
        Time at the start that is left out [s].
    close : tuple of float
        Between which times it is shown close up [s].
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    figure, grid = style.panels(0.4 + 2.0 * len(results), rows=len(results), columns=2, widths=(2.0, 1.0), between=0.55, top=0.4)
    for (full, near), result in zip(grid, results.values(), strict=True):
        inside = (result.time >= close[0]) & (result.time <= close[1])
        for axes, part in ((full, result.time >= settle), (near, inside)):
            span = time_scale(result.time[part])
            length = scale_for("length", kind, result.reference[part])
            for signal, look, label in ((result.reference, style.MEASURED, "command"), (result.measured, style.PREDICTED, "encoder")):
                x, y = line(result.time[part], signal[part])
                axes.plot(x * span.factor, y * length.factor, label=label, **look)
            axes.set_xlabel(span.label("Time"))
            axes.set_ylabel(length.label(position_word(kind)))
        style.mark_window(full, np.array(close))
        near.set_title("close up")
    reach = style.legend_in_corner(figure, grid[0][0])
    for (first, *_), name in zip(grid, results, strict=True):
        style.title(first, name, beside=reach if first is grid[0][0] else 0.0)
    return figure
