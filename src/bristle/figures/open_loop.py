"""What a given effort does: position, velocity, friction and effort of each variant over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.core.status import Status
from bristle.figures import style
from bristle.figures.following_error import has_completed
from bristle.figures.labels import effort_word, position_word, scale_for
from bristle.figures.lettering import label
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult

QUANTITIES = {"position": "length", "velocity": "length/time", "friction": "force", "effort": "force"}


@style.styled
def open_loop(result: SimulationResult) -> Figure:
    """Return position, velocity, friction and effort of each variant over time, one panel each."""
    variants = [variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE]
    kind = result.experiment.kind
    force = effort_word(kind)
    words = (position_word(kind), "Velocity", f"Friction {force.lower()}", f"{force} of the drive")
    figure, rows = style.panels(style.ROW * len(QUANTITIES), rows=len(QUANTITIES), names=[variant.name for variant in variants])
    for (axes,), word, (name, quantity) in zip(rows, words, QUANTITIES.items(), strict=True):
        scale = scale_for(quantity, kind, *(getattr(variant, name) for variant in variants))
        for number, variant in enumerate(variants):
            signal = (getattr(variant, name), style.LINES[number % len(style.LINES)], label(variant.name))
            style.over_time(axes, variant.time, signal, scale=scale, word=word)
    if len(variants) > 1:
        style.legend(rows[0][0])
    return figure


FIGURE = ReportFigure(
    name="motion",
    takes="open_loop",
    draw=open_loop,
    applies=has_completed,
    alternative="Position, velocity, friction and effort of each variant over time",
    caption="Where the velocity is zero and friction holds against the effort, the axis sticks.",
)
