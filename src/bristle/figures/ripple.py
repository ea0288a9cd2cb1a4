"""A torque up and down below break-away: the torque over time, and what the contact does under it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core.typography import Scale
from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.drawing import WIDTH
from bristle.figures.labels import effort_scale, position_word, scale_for, time_scale
from bristle.figures.lettering import width
from bristle.figures.names import LETTERS, label
from bristle.figures.small_multiples import FIRST, LAST, Traces

__all__ = ["ripple"]

BETWEEN, APART = 0.45, 0.75  # inches: panels, and those with axes of their own
COLUMNS, ROW = 2, 2.35  # of panels below; height [inch] of one row of them more


@style.styled
def ripple(
    time: np.ndarray,
    driving: np.ndarray,
    traces: Traces,
    cycle: int,
    titles: Mapping[str, str],
    kind: Kind = "translational",
    effort: Kind | None = None,
    close_up: tuple[str, Traces] | None = None,
) -> Figure:
    """Return the driving force over time, and below it friction over position for each contact, from the ripple on.

    Parameters
    ----------
    time, driving : ndarray, shape (sample,)
        Time [s] and driving force [N or N*m], from the start of the experiment.
    traces : mapping of str to (x, force)
        Positions since the ripple began [m or rad] and friction [N or N*m], by the name of the contact.
    cycle : int
        How many samples a cycle takes: the first one is drawn wide and light.
    titles : mapping of str to str
        What stands above each panel.
    kind, effort : {"translational", "rotational"}
        The kind of axis, and that of the forces where it is another one.
    close_up : (str, mapping of str to (x, force)), optional
        One panel more, behind the first one: its title, and up to two traces that are compared in it, each less the
        straight line that fits the first of them best: beside it the orbits are too slim to be told apart.
    """
    scale, word = effort_scale(effort or kind, driving)
    length = scale_for("length", kind, *(x for x, _ in traces.values()))
    figure, above, below = _panels(len(traces), close_up is not None)
    span = time_scale(time)
    above.plot(time * span.factor, driving * scale.factor, color=style.INK, linewidth=1.0)
    above.set_xlabel(span.label("Time"))
    above.set_ylabel(scale.label(f"Driving {word.lower()}"))
    level = [f * scale.factor for _, f in traces.values()]
    low, high = min(float(f.min()) for f in level), max(float(f.max()) for f in level)
    margin = 0.06 * (high - low)
    under = length.label(f"{position_word(kind)}, from the first cycle on")
    if width(under, LETTERS) > WIDTH * below[0].get_position().width:
        under = length.label(position_word(kind))
    if close_up is not None:
        _compare(below.pop(1), *close_up, length, scale, under, word)
    for axes in below:
        axes.set_ylim(low - margin, high + margin)
        axes.set_xlabel(under)
        if axes.get_position().x0 > above.get_position().x0 + 0.1:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(scale.label(f"Friction {word.lower()}"))
    for axes, (name, (x, _)), torque in zip(below, traces.items(), level, strict=True):
        moved = x * length.factor
        axes.plot(moved[: cycle + 1], torque[: cycle + 1], label="first cycle", **FIRST)
        axes.plot(moved[cycle:], torque[cycle:], label="later cycles", **LAST)
        style.title(axes, titles[name], name)
    style.legend_in_corner(figure, below[0])
    return figure


def _panels(count: int, close_up: bool) -> tuple[Figure, Axes, list[Axes]]:
    """Return the figure, the panel over time, and those below it."""
    count += close_up
    columns = min(count, COLUMNS)
    rows = -(-count // columns)
    figure, (above, *below) = style.panels(
        4.7 + ROW * (rows - 1),
        rows=1 + rows,
        columns=columns,
        heights=(0.75, *([1.0] * rows)),
        undivided=(0,),
        between=APART if close_up else BETWEEN,
        top=0.4,
    )
    panels = [axes for row in below for axes in row]
    for unused in panels[count:]:
        unused.remove()
    return figure, above[0], panels[:count]


def _compare(axes: Axes, title: str, traces: Traces, length: Scale, force: Scale, under: str, word: str) -> None:
    """Draw traces over one another, less one straight line, with their names in room above them."""
    line = np.polynomial.Polynomial.fit(*next(iter(traces.values())), 1)
    for look, (name, (x, f)) in zip((FIRST, LAST), traces.items(), strict=False):
        axes.plot(x * length.factor, (f - line(x)) * force.factor, label=label(name), **look)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.45 * (high - low))
    axes.legend(loc="upper left", frameon=False)
    axes.set_xlabel(under)
    axes.set_ylabel(force.label(f"{word} less a line"))
    style.title(axes, title)
