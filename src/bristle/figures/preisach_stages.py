"""The Preisach plane at every turn of a history: how the staircase between relays up and down comes about."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from bristle.core.contracts import Model
from bristle.core.variable import Kind
from bristle.engine import response
from bristle.engine.path import after
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for
from bristle.figures.preisach_plane import draw_plane, staircase

__all__ = ["preisach_stages"]

SAMPLES = 100
LETTERS = "abcdefgh"


@style.styled
def preisach_stages(
    operator: Model, saturated: float, turns: Sequence[float], arm: float = 1.0, effort: Kind | None = None
) -> Figure:
    """Return the planes at the turns of a history that begins in saturation, and the force along it.

    Parameters
    ----------
    operator : Model
        An operator with turning points.
    saturated : float
        Input where the history begins, far down [m or rad].
    turns : sequence of float
        Inputs where it turns, the last one where it is now [m or rad].
    arm : float
        What the output is multiplied by to be shown: with the travel for a radian, a force becomes a torque.
    effort : {"translational", "rotational"}, optional
        The kind of what is shown then; that of the operator where not given.
    """
    path = [saturated, *turns]
    length = scale_for("length", operator.kind, np.array(path))
    extent = 1.1 * max(map(abs, path))
    figure, (above, (below,)) = style.panels(
        5.6, rows=2, columns=len(turns), heights=(1.0, 1.35), undivided=(1,), between=0.3, gap=0.8
    )
    for index, axes in enumerate(above):
        state, memory = after(operator, [0.0, *path[: index + 2]])
        draw_plane(axes, staircase(memory[: state.depth].tolist(), state.z), extent, length)
        axes.set_title(f"({LETTERS[index]})", loc="left")
        if index:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
    handles = above[0].get_legend_handles_labels()
    figure.legend(
        *handles, loc="upper right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, handlelength=1.2,
        columnspacing=1.4, borderaxespad=0.1,
    )  # fmt: skip
    _draw_force(below, operator, path, arm, effort or operator.kind)
    return figure


def _draw_force(axes: style.Axes, operator: Model, path: Sequence[float], arm: float, effort: Kind) -> None:
    share = np.linspace(0.0, 1.0, SAMPLES) ** 2
    u = np.concatenate([a + (b - a) * share for a, b in pairwise(path)])
    f = arm * response(operator, u, history=[path[0]])
    length = scale_for("length", operator.kind, u)
    force, word = effort_scale(effort, f)
    x, y = u * length.factor, f * force.factor
    axes.plot(x, y, **style.PREDICTED)
    for i, end in enumerate(range(SAMPLES - 1, x.size, SAMPLES)):
        axes.plot(x[end], y[end], "o", color="#e0a83c", markersize=5.0)
        side = -1 if path[i + 1] < path[i] else 1
        axes.annotate(
            f"({LETTERS[i]})", (x[end], y[end]), xytext=(6 * side, 1), textcoords="offset points", color=style.INK,
            ha="left" if side > 0 else "right",
        )  # fmt: skip
    axes.margins(x=0.05, y=0.1)
    axes.set_xlabel(length.label(position_word(operator.kind)))
    axes.set_ylabel(force.label(f"Friction {word.lower()}"))
