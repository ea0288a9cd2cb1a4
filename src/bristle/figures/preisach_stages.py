"""The Preisach plane at every turn of a history: how the staircase between relays up and down comes about."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core.contracts import Model
from bristle.core.typography import Scale
from bristle.core.variable import Kind
from bristle.engine import response
from bristle.engine.path import after
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for
from bristle.figures.preisach_plane import draw_plane, staircase

__all__ = ["preisach_stages"]

SAMPLES = 100
LETTERS, INDICES = "abcdefgh", "₁₂₃₄"
HATCHES, HATCH = ("////", "\\\\\\\\", "....", "xxxx"), "#55708f"


@style.styled
def preisach_stages(operator: Model, saturated: float, turns: Sequence[float], arm: float = 1.0, effort: Kind | None = None) -> Figure:
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
    figure, (above, (below,)) = style.panels(5.3, rows=2, columns=len(turns), heights=(1.0, 1.45), undivided=(1,), between=0.22, gap=0.7)
    for index, axes in enumerate(above):
        state, memory = after(operator, [0.0, *path[: index + 2]])
        corners = staircase(memory[: state.depth].tolist(), state.z)
        draw_plane(axes, corners, extent, length, "S⁺: relays up", "----")
        _hatch(axes, path[: index + 2], length)
        axes.set_title(f"({LETTERS[index]})", loc="left")
        if index:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
    handles = above[0].get_legend_handles_labels()
    figure.legend(
        *handles,
        loc="upper right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=4,
        frameon=False,
        handlelength=1.2,
        columnspacing=1.4,
        borderaxespad=0.1,
    )
    _draw_force(below, operator, path, arm, effort or operator.kind)
    return figure


def trapezoids(path: Sequence[float]) -> list[np.ndarray]:
    """Return the corners (beta, alpha) of what the sums over the extremes add up, one part a term.

    Between one minimum and the next relays are up to the maximum before: a trapezoid on the diagonal. While the input
    rises the last one is still a triangle, with the input at its tip.
    """
    minima, maxima = list(path[::2]), list(path[1::2])
    ends = minima[1:] if len(minima) > len(maxima) else [*minima[1:], maxima[-1]]
    return [
        np.array([(left, left), (left, top), (right, top), (right, right)]) for left, right, top in zip(minima, ends, maxima, strict=False)
    ]


def _hatch(axes: Axes, path: Sequence[float], length: Scale) -> None:
    """Hatch the trapezoids Q_k, one unlike the next."""
    for index, corners in enumerate(trapezoids(path)):
        scaled = corners * length.factor
        axes.fill(
            scaled[:, 0],
            scaled[:, 1],
            facecolor="none",
            edgecolor=HATCH,
            hatch=HATCHES[index % len(HATCHES)],
            linewidth=0.8,
            label="trapezoids Qₖ" if index == 0 else "_trapezoid",
        )
        (left, _), (_, top), (right, _), _ = scaled
        # The middle of a trapezoid over a slanted base.
        x = 0.5 * (left + right) - 0.08 * (right - left)
        axes.text(
            x,
            0.5 * (top + x),
            f"Q{INDICES[index]}",
            ha="center",
            va="center",
            fontsize=8.0,
            color=style.INK,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
        )


def _draw_force(axes: Axes, operator: Model, path: Sequence[float], arm: float, effort: Kind) -> None:
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
            f"({LETTERS[i]})",
            (x[end], y[end]),
            xytext=(6 * side, 1),
            textcoords="offset points",
            color=style.INK,
            ha="left" if side > 0 else "right",
        )
    axes.margins(x=0.05, y=0.1)
    axes.set_xlabel(length.label(position_word(operator.kind)))
    axes.set_ylabel(force.label(f"Friction {word.lower()}"))
