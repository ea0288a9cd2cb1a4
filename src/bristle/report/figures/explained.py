"""Figure of the forces that explain the effort of a log."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bristle.core import number
from bristle.core.palette import LIGHT
from bristle.identification import Curve, Explanation
from bristle.report.figures import style
from bristle.report.figures.drawing import label
from bristle.report.figures.report_figure import shown

MOST = 8  # bars
LEAST = 0.001  # smallest share with a bar


@shown(
    "forces",
    "explanation",
    "Share of each force, force over the position, and friction over the velocity",
    "Blue: terms that the log shows beside friction and a constant force. Shares are those of the rms forces without inertia.",
)
def forces(explanation: Explanation) -> Figure:
    """Return the shares of the forces, ranked, the force over the position and friction over the velocity."""
    parts = [part for part in explanation.parts if part.share >= LEAST][:MOST]
    figure, grid = style.panels(
        2.9 + 0.22 * len(parts), rows=2, columns=2, heights=(0.3 * len(parts), 1.6), undivided=(0,)
    )
    bars = grid[0][0]
    bars.set_yticks(range(len(parts)), [label(part.label(explanation.kind)) for part in parts])
    for place, part in enumerate(parts):
        colour = LIGHT["without"]
        if part.evidence is not None:
            colour = LIGHT["with"]
        share = 100.0 * part.share
        bars.barh(place, share, 0.6, color=colour)
        text = f" {number(share, digits=2)} %"
        bars.text(share, place, text, color=style.INK, verticalalignment="center")
    bars.set_ylim(len(parts) - 0.5, -0.5)
    bars.tick_params(axis="y", length=0)
    bars.set(xlim=(0.0, 118.0 * parts[0].share), xlabel="Share of the forces [%]")
    kind = explanation.kind
    draw_curve(grid[1][0], explanation.curves["position"], style.position_word(kind), explanation)
    draw_curve(grid[1][1], explanation.curves["speed"], "Velocity", explanation)
    return figure


def draw_curve(axes: style.Axes, curve: Curve, word: str, explanation: Explanation) -> None:
    """Draw a force over the position or the velocity."""
    at = style.scale_for(curve.over, explanation.kind, curve.at)
    force, name = style.effort_scale(explanation.kind, curve.values)
    values = np.where(curve.at == 0.0, np.nan, curve.values)
    if curve.over == "length":
        values = curve.values
    axes.plot(curve.at * at.factor, values * force.factor, **style.PREDICTED)
    axes.set(xlabel=at.label(word), ylabel=force.label(name))
