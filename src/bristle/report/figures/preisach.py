"""The Preisach plane of an operator: the Everett function, the staircase between relays up and down, reversal curves."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core import InputError, Kind, Model, Scale, array, guarded
from bristle.core.palette import LIGHT
from bristle.engine import after, response
from bristle.report.figures import style
from bristle.report.figures.small_multiples import loop_units

SAMPLES = 120  # between two turns
LETTERS, INDICES = "abcdefgh", "₁₂₃₄"
HATCHES = ("////", "\\\\\\\\", "....", "xxxx")
NOW = style.MEASURED["color"]


@style.styled
@guarded(history=array())
def preisach_plane(operator: Model, history: Sequence[float]) -> Figure:
    """Return the Preisach plane of an operator after a history, and the loops of that history.

    Parameters
    ----------
    operator : Model
        An operator with turning points: `preisach` or `everett_table`.
    history : sequence of float
        Inputs at the turns of a demagnetised operator, the present input last [m or rad].

    Raises
    ------
    InputError
        If the operator has no turning points, or the history is empty.
    """
    if getattr(operator.component, "measure", None) is None:
        raise InputError("has no turning points", path="operator", value=operator.name)
    if not len(history):
        raise InputError("is empty", path="history", mend="Give the inputs at the turning points")
    turns = [0.0, *map(float, history)]
    path = _way(turns)
    output = response(operator, path)
    units = loop_units([(path, output)], operator.kind)
    figure, ((plane, loops),) = style.panels(3.7, columns=2, between=0.75)
    _draw_memory(plane, operator, turns, 1.15 * max(map(abs, turns)), units.length)
    style.legend(plane, 3, handle=1.2)
    units.plot(loops, path, output, label="_path", **style.PREDICTED)
    units.plot(loops, path[-1], output[-1], "o", color=NOW, markersize=style.SMALL, label="_now")
    loops.set(xlabel=units.x, ylabel=units.y)
    return figure


@style.styled
def preisach_stages(
    operator: Model,
    saturated: float,
    turns: Sequence[float],
    arm: float = 1.0,
    effort: Kind | None = None,
) -> Figure:
    """Return the planes at the turns of a history that begins in saturation, and the force along it."""
    path = [saturated, *turns]
    u = _way(path)
    f = arm * response(operator, u, history=[saturated])
    units = loop_units([(u, f)], operator.kind, effort)
    figure, (above, (below,)) = style.panels(
        5.3, rows=2, columns=len(turns), heights=(1.0, 1.45), undivided=(1,), between=0.22, gap=0.7
    )
    for index, axes in enumerate(above):
        past = path[: index + 2]
        _draw_memory(
            axes,
            operator,
            [0.0, *past],
            1.1 * max(map(abs, path)),
            units.length,
            "S⁺: relays up",
            "----",
        )
        _hatch(axes, past, units.length)
        axes.set_title(f"({LETTERS[index]})", loc="left")
    style.share_y(above, above[0].get_ylabel())
    for axes in above[1:]:
        axes.set_ylabel("")
    handles = above[0].get_legend_handles_labels()
    figure.legend(
        *handles,
        loc="upper right",
        ncols=4,
        frameon=False,
        handlelength=1.2,
        columnspacing=1.4,
        borderaxespad=0.1,
    )
    units.plot(below, u, f, **style.PREDICTED)
    for index, (start, turn) in enumerate(pairwise(path)):
        at = (
            u[(index + 1) * SAMPLES - 1] * units.length.factor,
            f[(index + 1) * SAMPLES - 1] * units.force.factor,
        )
        below.plot(*at, "o", color=NOW, markersize=style.SMALL)
        side, align = (1, "left") if turn >= start else (-1, "right")
        below.annotate(
            f"({LETTERS[index]})",
            at,
            xytext=(6 * side, 1),
            textcoords="offset points",
            color=style.INK,
            ha=align,
        )
    below.margins(x=0.05, y=0.1)
    below.set(xlabel=units.x, ylabel=units.y)
    return figure


def _way(turns: Sequence[float]) -> np.ndarray:
    """Return inputs from turn to turn, denser after each turn."""
    share = np.linspace(0.0, 1.0, SAMPLES) ** 2
    return np.concatenate([a + (b - a) * share for a, b in pairwise(turns)])


def staircase(turning_points: Sequence[float], u: float) -> np.ndarray:
    """Return the corners (beta, alpha) of the line below which relays are up, from the demagnetised state on."""
    first, *later = [*turning_points, u]
    beta, alpha = -abs(first), abs(first)
    corners, rising = [(beta, alpha)], first > 0.0
    for point in later:
        rising = not rising
        beta, alpha = (beta, point) if rising else (point, alpha)
        corners.append((beta, alpha))
    return np.array([*corners, (u, u)])


def _draw_memory(
    axes: Axes,
    operator: Model,
    turns: Sequence[float],
    extent: float,
    length: Scale,
    name: str = "relays up",
    hatch: str | None = None,
) -> None:
    """Draw the plane up to a threshold of `extent` [m or rad], with the staircase of a history."""
    state, memory = after(operator, turns)
    edge = extent * length.factor
    line = np.vstack(
        ([-edge, edge], staircase(memory[: state.depth].tolist(), state.z) * length.factor)
    )
    up = np.vstack((line, [-edge, -edge]))
    axes.fill(
        up[:, 0],
        up[:, 1],
        facecolor=LIGHT["shade"],
        edgecolor=LIGHT["ghost"],
        hatch=hatch,
        linewidth=0,
        label=name,
    )
    axes.plot([-edge, edge], [-edge, edge], **style.AID)
    axes.plot(
        line[:, 0], line[:, 1], color=style.PREDICTED["color"], linewidth=style.WIDE, label="memory"
    )
    axes.plot(*line[-1], "o", color=NOW, markersize=style.SMALL, label="input now")
    axes.set(xlim=(-edge, edge), ylim=(-edge, edge))
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel=length.label("Threshold β, down"), ylabel=length.label("Threshold α, up"))


def trapezoids(path: Sequence[float]) -> list[np.ndarray]:
    """Return the corners (beta, alpha) of the terms in the sum over the extremes.

    Between two minima relays are up to the maximum before: a trapezoid on the diagonal. While the input
    rises the last term is still a triangle, with the input at its tip.
    """
    minima, maxima = list(path[::2]), list(path[1::2])
    ends = minima[1:] if len(minima) > len(maxima) else [*minima[1:], maxima[-1]]
    return [
        np.array([(left, left), (left, top), (right, top), (right, right)])
        for left, right, top in zip(minima, ends, maxima, strict=False)
    ]


def _hatch(axes: Axes, path: Sequence[float], length: Scale) -> None:
    """Hatch the trapezoids Q_k, each unlike the next."""
    box = {"facecolor": LIGHT["ground"], "edgecolor": "none", "pad": 0.8}
    for index, corners in enumerate(trapezoids(path)):
        scaled, hatch = corners * length.factor, HATCHES[index % len(HATCHES)]
        name = "_trapezoid" if index else "trapezoids Qₖ"
        axes.fill(
            scaled[:, 0],
            scaled[:, 1],
            facecolor="none",
            edgecolor=LIGHT["fifth"],
            hatch=hatch,
            linewidth=0.8,
            label=name,
        )
        (left, _), (_, top), (right, _), _ = scaled
        x = left + 0.42 * (right - left)  # the middle of a trapezoid over a slanted base
        axes.text(
            x,
            0.5 * (top + x),
            f"Q{INDICES[index]}",
            ha="center",
            va="center",
            fontsize=8.0,
            color=style.INK,
            bbox=box,
        )
