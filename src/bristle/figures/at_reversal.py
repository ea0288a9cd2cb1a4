"""The loop as it stands and the best one, around the worst reversal, on the first page of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.figures.following_error import has_completed, loops_at_reversal
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult

__all__ = ["FIGURE"]

Loops = tuple[Sequence[str], Sequence[str]]
"""The variants to show over the whole run, and those close up."""


def _draw(simulation: SimulationResult, at_reversal: Loops) -> Figure:
    return loops_at_reversal(simulation, *at_reversal)


def _alternative(simulation: SimulationResult, at_reversal: Loops) -> str:
    return f"Following error of {', '.join(at_reversal[0])} over time and at the worst reversal, and the effort there"


def _caption(simulation: SimulationResult, at_reversal: Loops) -> str:
    names, close = at_reversal
    return (
        "Following error over the whole run, close up at the worst reversal (shaded above), and the effort there"
        f"{'' if names == close else ', both of ' + ' and '.join(close)}."
    )


FIGURE = ReportFigure(
    name="reversal",
    takes=("simulation", "at_reversal"),
    draw=_draw,
    alternative=_alternative,
    caption=_caption,
    applies=lambda simulation, at_reversal: has_completed(simulation),
)
