"""The figure of a first page: friction over velocity with what a drive is told, and the worst reversal of the loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.following_error import draw_worst_reversal, has_completed
from bristle.figures.friction_over_velocity import draw_friction
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Fit
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult

__all__ = ["FIGURE", "first_page"]


@style.styled
def first_page(
    fit: Fit, curve: Sequence[tuple[float, float]] = (), simulation: SimulationResult | None = None, measured: np.ndarray | None = None
) -> Figure:
    """Return friction over velocity, and below it the following error at the worst reversal where there is a loop.

    Parameters
    ----------
    fit : Fit
        A model and the traces that it was fitted to.
    curve : sequence of (velocity, effort)
        Steady friction of the model [m/s or rad/s, N or N*m], in order of velocity.
    simulation : SimulationResult, optional
        The loop as it is and compensated.
    measured : ndarray, shape (sample,), optional
        Following error of the axis itself along the same reference [m or rad].
    """
    loop = simulation if simulation is not None and has_completed(simulation) else None
    rows = 1 if loop is None else 2
    figure, grid = style.panels(3.4 if loop is None else style.PANEL * rows, rows=rows, gap=0.95)
    draw_friction(grid[0][0], fit, curve)
    if loop is not None:
        draw_worst_reversal(grid[1][0], loop, measured)
    for (axes,) in grid:
        style.legend(axes)
    return figure


def _draw(fit: Fit, curve: Sequence[tuple[float, float]], simulation: SimulationResult | None, following: Following | None) -> Figure:
    return first_page(fit, curve, simulation, None if following is None else following.error)


def _alternative(fit: Fit, curve: Sequence[tuple[float, float]], simulation: SimulationResult | None, following: Following | None) -> str:
    behind = "" if simulation is None else ", and the following error at its worst reversal"
    return f"Friction over velocity{behind}"


def _caption(fit: Fit, curve: Sequence[tuple[float, float]], simulation: SimulationResult | None, following: Following | None) -> str:
    if simulation is None:
        return "Friction over velocity, measured and modelled."
    return (
        "Above, friction measured and modelled. Below, the following error around its worst reversal: measured, "
        "simulated as recorded, and compensated."
    )


FIGURE = ReportFigure(
    name="first", takes=("fit", "curve"), may_take=("simulation", "following"), draw=_draw, alternative=_alternative, caption=_caption
)
