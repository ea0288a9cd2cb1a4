"""Friction over velocity: what was measured, on both branches of speed, and the curve of the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.envelope import spread
from bristle.figures.labels import effort_scale, scale_for
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Fit

__all__ = ["FIGURE", "draw_friction", "friction_over_velocity"]

BRANCHES = (
    ("measured, speeding up", 1.0, {"marker": "o", "color": style.MEASURED["color"], "markersize": 2.6}),
    ("measured, slowing down", -1.0, {"marker": "+", "color": "#5b7f9e", "markersize": style.SMALL}),
)


@style.styled
def friction_over_velocity(fit: Fit, curve: Sequence[tuple[float, float]] = ()) -> Figure:
    """Return the friction over the velocity: effort less inertia, and the steady curve of the model on top.

    Parameters
    ----------
    fit : Fit
        A model and the traces that it was fitted to.
    curve : sequence of (velocity, effort)
        Steady friction of the model [m/s or rad/s, N or N*m], in order of velocity.
    """
    figure, ((axes,),) = style.panels(3.4)
    draw_friction(axes, fit, curve)
    style.legend(axes)
    return figure


def draw_friction(axes: style.Axes, fit: Fit, curve: Sequence[tuple[float, float]]) -> None:
    """Draw the friction over the velocity into a panel."""
    traces, kind = fit.traces, fit.plant.kind
    friction = traces.friction
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


FIGURE = ReportFigure(
    name="velocity",
    takes=("fit", "curve"),
    draw=friction_over_velocity,
    alternative="Friction over velocity, measured and modelled",
    caption="Effort less inertia, over velocity. Points of speeding up and slowing down that lie apart at one velocity "
    "are friction that depends on more than velocity. Near standstill the filter smears the step between the two "
    "directions.",
)
