"""What a given effort does: position, velocity, friction and effort of each variant over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.core.status import Status
from bristle.figures import style
from bristle.figures.envelope import line
from bristle.figures.following_error import has_completed
from bristle.figures.labels import effort_word, position_word, scale_for, time_scale
from bristle.figures.legends import LINE, lines
from bristle.figures.names import label
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult

__all__ = ["FIGURE", "open_loop"]

ROW = 1.5  # inches
QUANTITIES = {"position": "length", "velocity": "length/time", "friction": "force", "effort": "force"}


@style.styled
def open_loop(result: SimulationResult) -> Figure:
    """Return position, velocity, friction and effort of each variant over time, one panel each.

    Parameters
    ----------
    result : SimulationResult
        The simulated variants, at least one of them completed: one that diverged is left out.
    """
    variants = [variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE]
    kind = result.experiment.kind
    force = effort_word(kind)
    words = (position_word(kind), "Velocity", f"Friction {force.lower()}", f"{force} of the drive")
    name_rows = lines([label(variant.name) for variant in variants])
    above = LINE * name_rows if name_rows > 1 else 0.0
    figure, rows = style.panels(ROW * len(QUANTITIES) + above, rows=len(QUANTITIES), between=0.2, top=0.32 + above)
    for (axes,), word, (name, quantity) in zip(rows, words, QUANTITIES.items(), strict=True):
        scale = scale_for(quantity, kind, *(getattr(variant, name) for variant in variants))
        for number, variant in enumerate(variants):
            look = {key: value for key, value in style.SERIES[number % len(style.SERIES)].items() if key != "marker"}
            x, y = line(variant.time, getattr(variant, name))
            span = time_scale(variant.time)
            axes.plot(x * span.factor, y * scale.factor, label=label(variant.name), **look)
            axes.set_xlabel(span.label("Time"))
        axes.set_ylabel(scale.label(word))
    if len(variants) > 1:
        style.legend(rows[0][0], top=name_rows > 1)
    return figure


FIGURE = ReportFigure(
    name="motion",
    takes="open_loop",
    draw=open_loop,
    applies=has_completed,
    alternative="Position, velocity, friction and effort of each variant over time",
    caption="Where the velocity is zero and friction holds against the effort, the axis sticks.",
)
