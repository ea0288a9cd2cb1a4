"""What the loops ask of the drive, over time and close up, a row for each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.envelope import line
from bristle.figures.labels import effort_scale, time_scale

if TYPE_CHECKING:
    from bristle.simulation.result import VariantResult

__all__ = ["control_effort"]


@style.styled
def control_effort(
    results: Mapping[str, VariantResult],
    settle: float,
    close: tuple[float, float],
    arm: float = 1.0,
    effort: Kind = "translational",
    *,
    friction: bool = False,
) -> Figure:
    """Return the effort of each loop, whole and close up, to one scale.

    Parameters
    ----------
    results : mapping of str to VariantResult
        Loops by the name above their row.
    settle : float
        Time at the start that is left out [s].
    close : tuple of float
        Between which times it is shown close up [s].
    arm : float
        What efforts are multiplied by to be shown: with the travel for a radian, a force becomes a torque.
    effort : {"translational", "rotational"}
        The kind of what is shown then.
    friction : bool
        Whether the part of it that goes into friction is drawn over it.
    """
    scale, word = effort_scale(effort, *(arm * result.effort for result in results.values()))
    peak = (
        1.06
        * scale.factor
        * max(float(np.max(np.abs(arm * result.effort[result.time >= settle]))) for result in results.values())
    )
    top = 0.56 if friction else 0.32
    figure, grid = style.panels(
        top - 0.22 + 2.0 * len(results), rows=len(results), columns=2, widths=(2.0, 1.0), between=0.3, top=top
    )
    for (full, near), (name, result) in zip(grid, results.items(), strict=True):
        inside = (result.time >= close[0]) & (result.time <= close[1])
        for axes, part in ((full, result.time >= settle), (near, inside)):
            span = time_scale(result.time[part])
            x, y = line(result.time[part], arm * result.effort[part])
            axes.plot(x * span.factor, y * scale.factor, label=f"driving {word.lower()}", **style.PREDICTED)
            if friction:
                x, y = line(result.time[part], arm * result.friction[part])
                axes.plot(x * span.factor, y * scale.factor, label="friction", **style.MEASURED)
            axes.set_ylim(-peak, peak)
            axes.set_xlabel(span.label("Time"))
        full.set_ylabel(scale.label(f"Driving {word.lower()}"))
        near.tick_params(labelleft=False)
        style.mark_window(full, np.array(close))
        style.title(full, name)
        near.set_title("close up")
    if friction:
        style.legend_in_corner(figure, grid[0][0])
    return figure
