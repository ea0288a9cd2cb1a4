"""What the loops ask of the drive, over time and close up, a row for each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import with_unit
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
    mean_over: float = 0.0,
) -> Figure:
    """Return the effort of each loop, whole and close up.

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
    mean_over : float
        Time over which the whole is averaged [s], so that chatter does not hide it; 0 for the effort as it is, whole
        and close up to one scale.
    """
    scale, word = effort_scale(effort, *(arm * result.effort for result in results.values()))
    averaged = {name: _averaged(arm * result.effort, result.time, mean_over) for name, result in results.items()}
    peaks = [
        1.06
        * scale.factor
        * max(float(np.max(np.abs(effort[result.time >= settle]))) for effort, result in zip(efforts, results.values(), strict=True))
        for efforts in (averaged.values(), [arm * result.effort for result in results.values()])
    ]
    top = 0.56 if friction else 0.32
    figure, grid = style.panels(
        top - 0.22 + 2.0 * len(results), rows=len(results), columns=2, widths=(2.0, 1.0), between=0.6 if mean_over else 0.3, top=top
    )
    for (full, near), (name, result) in zip(grid, results.items(), strict=True):
        inside = (result.time >= close[0]) & (result.time <= close[1])
        overview = (full, result.time >= settle, averaged[name], peaks[0])
        for axes, part, effort_shown, peak in (overview, (near, inside, arm * result.effort, peaks[1])):
            span = time_scale(result.time[part])
            x, y = line(result.time[part], effort_shown[part])
            axes.plot(x * span.factor, y * scale.factor, label=f"driving {word.lower()}", **style.PREDICTED)
            if friction:
                taken = _averaged(arm * result.friction, result.time, mean_over if axes is full else 0.0)
                x, y = line(result.time[part], taken[part])
                drawn = axes.plot(x * span.factor, y * scale.factor, label="friction", **style.MEASURED)
                if mean_over and axes is full:
                    drawn[0].set_zorder(1.5)  # beneath the averaged effort, which it nearly equals
            axes.set_ylim(-peak, peak)
            axes.set_xlabel(span.label("Time"))
        for axes in (full, near) if mean_over else (full,):
            axes.set_ylabel(scale.label(f"Driving {word.lower()}"))
        near.tick_params(labelleft=mean_over > 0.0)
        style.mark_window(full, np.array(close))
        style.title(full, f"{name}, mean over {with_unit(mean_over, 's')}" if mean_over else name)
        near.set_title("close up, as it is" if mean_over else "close up")
    if friction:
        style.legend_in_corner(figure, grid[0][0])
    return figure


def _averaged(effort: np.ndarray, time: np.ndarray, duration: float) -> np.ndarray:
    """Return an effort averaged over a time around each sample; as it is for a time of 0."""
    count = round(duration / float(time[1] - time[0])) if duration else 1
    if count < 2:
        return effort
    return np.convolve(effort, np.ones(count), "same") / np.convolve(np.ones(effort.size), np.ones(count), "same")
