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
    operator: Model, saturated: float, turns: Sequence[float], arm: float = 1.0, kind: Kind | None = None
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
        What a unit of the input is on the axes: with a travel for each radian, inputs are shown as travels.
    kind : {"translational", "rotational"}, optional
        The kind that the inputs are shown in; that of the operator where not given.
    """
    shown = kind or operator.kind
    path = [saturated, *turns]
    length = scale_for("length", shown, np.array(path) * arm)
    extent = 1.1 * max(map(abs, path)) * arm
    figure, grid = style.panels(5.6, rows=2, columns=len(turns), heights=(1.0, 1.35), between=0.3, gap=0.8)
    for index, axes in enumerate(grid[0]):
        state, memory = after(operator, [0.0, *path[: index + 2]])
        draw_plane(axes, staircase(memory[: state.depth].tolist(), state.z) * arm, extent, length)
        axes.set_title(f"({LETTERS[index]})", loc="left")
        if index:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
    handles = grid[0][0].get_legend_handles_labels()
    figure.legend(
        *handles, loc="upper right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, handlelength=1.2,
        columnspacing=1.4, borderaxespad=0.1,
    )  # fmt: skip
    below, *others = grid[1]
    style.widen(below, until=others[-1] if others else below)
    _draw_force(below, operator, path, arm, shown)
    return figure


def _draw_force(axes: style.Axes, operator: Model, path: Sequence[float], arm: float, kind: Kind) -> None:
    share = np.linspace(0.0, 1.0, SAMPLES) ** 2
    u = np.concatenate([a + (b - a) * share for a, b in pairwise(path)])
    f = response(operator, u, history=[path[0]])
    length = scale_for("length", kind, u * arm)
    force, word = effort_scale(operator.kind, f)
    axes.plot(u * arm * length.factor, f * force.factor, **style.PREDICTED)
    ends = np.arange(1, len(path)) * SAMPLES - 1
    axes.plot(u[ends] * arm * length.factor, f[ends] * force.factor, "o", color="#e0a83c", markersize=5.0)
    for i, (x, y) in enumerate(zip(u[ends] * arm * length.factor, f[ends] * force.factor, strict=True)):
        side = -1 if path[i + 1] < path[i] else 1
        axes.annotate(
            f"({LETTERS[i]})", (x, y), xytext=(6 * side, 1), textcoords="offset points", color=style.INK,
            ha="left" if side > 0 else "right",
        )  # fmt: skip
    axes.margins(x=0.05, y=0.1)
    axes.set_xlabel(length.label(position_word(kind)))
    axes.set_ylabel(force.label(f"Friction {word.lower()}"))
