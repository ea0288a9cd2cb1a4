"""The Preisach plane: the staircase between relays that are up and relays that are down, which is all the memory."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.typography import Scale
from bristle.engine import response
from bristle.engine.path import after
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for

__all__ = ["draw_plane", "preisach_plane", "staircase"]

SAMPLES = 120


@style.styled
def preisach_plane(operator: Model, history: Sequence[float]) -> Figure:
    """Return what an operator remembers of a history, and the loops that the history drew.

    Parameters
    ----------
    operator : Model
        An operator with turning points: `preisach` or `everett_table`.
    history : sequence of float
        Inputs where a demagnetised operator turned, the present one last [m or rad].

    Raises
    ------
    InputError
        If the operator keeps no turning points, or the history is empty.
    """
    if operator.component.measure is None:
        raise InputError("keeps no turning points", path="operator", value=operator.name)
    if not len(history):
        raise InputError("is empty", path="history", mend="Give the inputs where it turned")
    turns = np.array([0.0, *history], dtype=float)
    share = np.linspace(0.0, 1.0, SAMPLES) ** 2
    path = np.concatenate([a + (b - a) * share for a, b in pairwise(turns)])
    output = response(operator, path)
    state, memory = after(operator, turns)
    length = scale_for("length", operator.kind, turns)
    force, word = effort_scale(operator.kind, output)
    figure, ((plane, loops),) = style.panels(3.7, columns=2, between=0.75)
    draw_plane(plane, staircase(memory[: state.depth].tolist(), state.z), 1.15 * float(np.max(np.abs(turns))), length)
    style.legend(plane, 3, handle=1.2)
    loops.plot(path * length.factor, output * force.factor, color=style.PREDICTED["color"], label="_path")
    loops.plot(state.z * length.factor, state.f * force.factor, "o", color="#e0a83c", markersize=5.0, label="_now")
    loops.set_xlabel(length.label(position_word(operator.kind)))
    loops.set_ylabel(force.label(f"Friction {word.lower()}"))
    return figure


def staircase(turning_points: Sequence[float], u: float) -> np.ndarray:
    """Return the corners (beta, alpha) of the line below which relays are up, from that of the demagnetised state on."""
    first, *later = [*turning_points, u]
    beta, alpha = -abs(first), abs(first)
    corners, rising = [(beta, alpha)], first > 0.0
    for point in later:
        rising = not rising
        beta, alpha = (beta, point) if rising else (point, alpha)
        corners.append((beta, alpha))
    return np.array([*corners, (u, u)])


def draw_plane(axes: Axes, corners: np.ndarray, extent: float, length: Scale, name: str = "relays up", hatch: str | None = None) -> None:
    """Draw the plane up to a threshold of `extent` [m or rad], with the corners of the staircase in it."""
    edge = extent * length.factor
    line = np.vstack(([-edge, edge], corners * length.factor))
    up = np.vstack((line, [-edge, -edge]))
    axes.fill(up[:, 0], up[:, 1], facecolor="#d7dee6", edgecolor="#a9b6c5", hatch=hatch, linewidth=0, label=name)
    axes.plot([-edge, edge], [-edge, edge], color=style.GREY, linewidth=0.9, label="_diagonal")
    axes.plot(line[:, 0], line[:, 1], color="#0b3c6f", linewidth=1.6, label="memory")
    axes.plot(*line[-1], "o", color="#e0a83c", markersize=5.0, label="input now")
    axes.set_xlim(-edge, edge)
    axes.set_ylim(-edge, edge)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel(length.label("Threshold β, down"))
    axes.set_ylabel(length.label("Threshold α, up"))
