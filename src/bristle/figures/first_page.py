"""The figure of a first page: friction over velocity with what a drive is told, and the worst reversal of the loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.envelope import spread
from bristle.figures.following_error import draw_worst_reversal, has_completed
from bristle.figures.labels import effort_scale, scale_for
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Fit
    from bristle.simulation.result import SimulationResult

BRANCHES = (
    ("measured, speeding up", 1.0, {"marker": "o", "color": style.MEASURED["color"], "markersize": 2.6}),
    ("measured, slowing down", -1.0, {"marker": "+", "color": "#5b7f9e", "markersize": style.SMALL}),
)


@style.styled
def first_page(
    fit: Fit, curve: Sequence[tuple[float, float]] = (), simulation: SimulationResult | None = None, measured: np.ndarray | None = None
) -> Figure:
    """Return friction over velocity, and below it the following error at the worst reversal where there is a loop.

    Parameters
    ----------
    fit : Fit
        A model and the traces that it was fitted to: the friction is their effort less inertia.
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
    axes, traces, friction, kind = grid[0][0], fit.traces, fit.traces.friction, fit.plant.kind
    steady = np.array(list(curve), dtype=float).reshape(-1, 2)
    scale, word = effort_scale(kind, friction, steady[:, 1])
    speed = scale_for("length/time", kind, traces.velocity, steady[:, 0])
    rate = traces.acceleration * np.where(np.signbit(traces.velocity), -1.0, 1.0)
    for name, side, look in BRANCHES:
        chosen = np.flatnonzero((rate >= 0.0) == (side > 0.0))
        drawn = chosen[spread(traces.velocity[chosen], friction[chosen])]
        points = traces.velocity[drawn] * speed.factor, friction[drawn] * scale.factor
        axes.plot(*points, linestyle="none", markeredgewidth=0.7, label=name, **look)
    style.plot_by_side(axes, steady * (speed.factor, scale.factor), "model, steady sliding", {"color": style.INK, "linewidth": 2.0})
    axes.axhline(0.0, **style.AID)
    axes.axvline(0.0, **style.AID)
    axes.set(xlabel=speed.label("Velocity"), ylabel=scale.label(f"Friction {word.lower()}"))
    if loop is not None:
        draw_worst_reversal(grid[1][0], loop, measured)
    for (axes,) in grid:
        style.legend(axes)
    return figure


FIGURE = ReportFigure(
    name="first",
    takes=("fit", "curve"),
    may_take=("simulation", "following"),
    draw=lambda fit, curve, simulation, following: first_page(fit, curve, simulation, None if following is None else following.error),
    alternative=lambda fit, curve, simulation, following: (
        f"Friction over velocity{'' if simulation is None else ', and the following error at its worst reversal'}"
    ),
    caption=lambda fit, curve, simulation, following: (
        "Friction over velocity, measured and modelled."
        if simulation is None
        else "Above, friction measured and modelled. Below, the following error around its worst reversal: measured, "
        "simulated as recorded, and compensated."
    ),
)
