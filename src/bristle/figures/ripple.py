"""A torque up and down below break-away: the torque over time, and what the contact does under it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for, time_scale
from bristle.figures.lettering import width
from bristle.figures.names import LETTERS
from bristle.figures.small_multiples import FIRST, LAST

__all__ = ["ripple"]

BETWEEN = 0.45  # inches: panels


@style.styled
def ripple(
    time: np.ndarray,
    driving: np.ndarray,
    traces: Mapping[str, tuple[np.ndarray, np.ndarray]],
    cycle: int,
    titles: Mapping[str, str],
    kind: Kind = "translational",
    effort: Kind | None = None,
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
    """
    scale, word = effort_scale(effort or kind, driving)
    length = scale_for("length", kind, *(x for x, _ in traces.values()))
    figure, ((above,), below) = style.panels(
        4.7, rows=2, columns=len(traces), heights=(0.75, 1.0), undivided=(0,), between=BETWEEN, top=0.4
    )
    span = time_scale(time)
    above.plot(time * span.factor, driving * scale.factor, color=style.INK, linewidth=1.0)
    above.set_xlabel(span.label("Time"))
    above.set_ylabel(scale.label(f"Driving {word.lower()}"))
    level = [f * scale.factor for _, f in traces.values()]
    low, high = min(float(f.min()) for f in level), max(float(f.max()) for f in level)
    room = 0.06 * (high - low)
    under = length.label(f"{position_word(kind)}, from the first cycle on")
    if width(under, LETTERS) > style.panel_width(len(traces), BETWEEN):
        under = length.label(position_word(kind))
    for place, (axes, (name, (x, _)), torque) in enumerate(zip(below, traces.items(), level, strict=True)):
        moved = x * length.factor
        axes.plot(moved[: cycle + 1], torque[: cycle + 1], label="first cycle", **FIRST)
        axes.plot(moved[cycle:], torque[cycle:], label="later cycles", **LAST)
        style.title(axes, titles[name], name)
        axes.set_ylim(low - room, high + room)
        axes.set_xlabel(under)
        if place:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(scale.label(f"Friction {word.lower()}"))
    style.legend_in_corner(figure, below[0])
    return figure
