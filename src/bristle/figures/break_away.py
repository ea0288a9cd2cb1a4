"""Force over position while a contact is led one way until it breaks away, model beside model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for
from bristle.figures.legends import LINE, lines
from bristle.figures.names import label

__all__ = ["break_away"]

COLUMNS, HANDLE = 3, 1.8  # of the legend


@style.styled
def break_away(
    traces: Mapping[str, tuple[np.ndarray, np.ndarray]],
    reached: Mapping[str, float],
    published: float,
    kind: Kind = "translational",
    effort: Kind | None = None,
) -> Figure:
    """Return force over position with the place marked where each contact has nearly reached its largest force.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the contact.
    reached : mapping of str to float
        Where it is [m or rad], by name; NaN where it is not reached.
    published : float
        Where the paper puts it [m or rad].
    kind, effort : {"translational", "rotational"}
        The kind of axis, and that of the forces where it is another one.
    """
    length = scale_for("length", kind, *(x for x, _ in traces.values()))
    force, word = effort_scale(effort or kind, *(f for _, f in traces.values()))
    more = LINE * (lines(["the paper", *map(label, traces)], COLUMNS, HANDLE) - 1)
    figure, ((axes,),) = style.panels(3.4 + more, top=0.32 + more)
    axes.axvline(published * length.factor, color=style.GREY, linewidth=1.0, linestyle=(0, (1, 2)), label="the paper")
    for (name, (x, f)), look in zip(traces.items(), style.SERIES, strict=False):
        line = {key: value for key, value in look.items() if key != "marker"}
        axes.plot(x * length.factor, f * force.factor, label=label(name), **line)
        at = reached[name]
        if np.isnan(at):
            continue
        axes.plot(
            at * length.factor,
            float(np.interp(at, x, f)) * force.factor,
            look["marker"],
            color=look["color"],
            markersize=5.0,
            label="_reached",
        )
    axes.set_ylim(0.0, None)
    axes.set_xlabel(length.label(position_word(kind)))
    axes.set_ylabel(force.label(f"Friction {word.lower()}"))
    style.legend(axes, COLUMNS, handle=HANDLE)
    return figure
