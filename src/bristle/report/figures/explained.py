"""Figure of the forces that explain the effort of a log."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from bristle.core import number
from bristle.core.palette import LIGHT
from bristle.identification import Explanation
from bristle.report.figures import style
from bristle.report.figures.drawing import label
from bristle.report.figures.report_figure import shown

MOST = 8  # bars
LEAST = 0.005  # smallest share with a bar


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
        2.9 + 0.22 * len(parts),
        rows=2,
        columns=2,
        heights=(0.22 * len(parts), 1.6),
        undivided=(0,),
        left=1.5,
        top=0.12,
    )
    bars = grid[0][0]
    bars.set_yticks(range(len(parts)), [label(part.label(explanation.kind)) for part in parts])
    for place, part in enumerate(parts):
        colour = LIGHT["without"]
        if part.evidence is not None:
            colour = LIGHT["with"]
        share = 100.0 * part.share
        bars.barh(place, share, 0.6, color=colour)
        bars.text(
            share,
            place,
            f" {number(share, digits=2)} %",
            color=style.INK,
            verticalalignment="center",
        )
    bars.set_ylim(len(parts) - 0.5, -0.5)
    bars.tick_params(axis="y", length=0)
    bars.set(xlim=(0.0, 118.0 * parts[0].share), xlabel="Share of the forces [%]")
    draw_curve(grid[1][0], explanation, left_curve(explanation))
    draw_curve(grid[1][1], explanation, "speed")
    return figure


def left_curve(explanation: Explanation) -> str:
    """Return the curve beside friction over the velocity: over the position if the log shows it, else over the travel."""
    for name in ("position", "level"):
        if np.ptp(explanation.curves[name].values) > 0.0:
            return name
    return "travel"


def draw_curve(axes: style.Axes, explanation: Explanation, name: str) -> None:
    """Draw a curve of the explanation."""
    curve = explanation.curves[name]
    kind = explanation.kind
    at = style.scale_for(curve.over, kind, curve.at)
    scale = style.scale_for(curve.of, kind, curve.values)
    words = {
        "position": (style.position_word(kind), style.effort_word(kind)),
        "level": (style.position_word(kind), "Level of friction"),
        "speed": ("Velocity", "Friction"),
        "travel": ("Travel after a reversal", "Friction"),
    }
    sides = [np.ones(curve.at.size, dtype=bool)]
    if name == "speed":
        sides = [curve.at < 0.0, curve.at > 0.0]
    for side in sides:
        axes.plot(curve.at[side] * at.factor, curve.values[side] * scale.factor, **style.PREDICTED)
    if name == "travel":
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(numticks=4))
        axes.xaxis.set_minor_locator(NullLocator())
        style.plain_numbers(axes.xaxis)
    across, up = words[name]
    axes.set(xlabel=at.label(across), ylabel=scale.label(up))
