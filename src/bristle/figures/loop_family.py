"""Families of hysteresis loops, panel by panel, the model narrow and dark over what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for

__all__ = ["Loops", "loop_family"]

Loops = Sequence[tuple[np.ndarray, np.ndarray]]
MEASURED: style.Look = style.MEASURED | {"linewidth": 1.8}
LOOKS: tuple[style.Look, ...] = (MEASURED, style.PREDICTED)


@style.styled
def loop_family(
    panels: Mapping[str, Mapping[str, Loops]], kind: Kind = "translational", effort: Kind | None = None
) -> Figure:
    """Return force over position, loops upon loops.

    Parameters
    ----------
    panels : mapping of str to mapping of str to sequence of (x, force)
        By the title of the panel, loops by their name in the legend: measured ones first, modelled ones after them.
        Positions [m or rad], forces [N or N*m].
    kind, effort : {"translational", "rotational"}
        The kind of axis, and that of the forces where it is another one.
    """
    every = [one for families in panels.values() for loops in families.values() for one in loops]
    length = scale_for("length", kind, *(x for x, _ in every))
    force, word = effort_scale(effort or kind, *(f for _, f in every))
    low, high = (edge(float(edge(f)) for _, f in every) * force.factor for edge in (min, max))
    figure, (row,) = style.panels(3.5, columns=len(panels), between=0.3)
    for place, (axes, (title, families)) in enumerate(zip(row, panels.items(), strict=True)):
        looks = LOOKS[-1:] if len(families) == 1 else LOOKS
        for look, (name, loops) in zip(looks, families.items(), strict=False):
            for index, (x, f) in enumerate(loops):
                axes.plot(x * length.factor, f * force.factor, label=f"_{name}" if index else name, **look)
        axes.set_title(title)
        axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
        axes.set_xlabel(length.label(position_word(kind)))
        if place:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(force.label(f"Friction {word.lower()}"))
    if max(map(len, panels.values())) > 1:
        style.legend(row[0], 2)
    return figure
