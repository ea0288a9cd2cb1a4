"""Families of hysteresis loops, panel by panel, the model narrow and dark over what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for
from bristle.figures.legends import LINE, line_width, lines
from bristle.figures.lettering import width
from bristle.figures.names import LETTERS, label
from bristle.figures.plain import one_line

__all__ = ["Loops", "loop_family"]

Loops = Sequence[tuple[np.ndarray, np.ndarray]]
MEASURED: style.Look = style.MEASURED | {"linewidth": 1.8}
BETWEEN, APART = 0.3, 0.12  # inches: panels; a title and a legend
LOOKS: tuple[style.Look, ...] = (MEASURED, style.PREDICTED)


@style.styled
def loop_family(panels: Mapping[str, Mapping[str, Loops]], kind: Kind = "translational", effort: Kind | None = None) -> Figure:
    """Return force over position, loops upon loops.

    Parameters
    ----------
    panels : mapping of str to mapping of str to sequence of (x, force)
        By the title of the panel, loops by their name in the legend: measured ones first, modelled ones after them.
        Positions [m or rad], forces [N or N*m].
    kind, effort : {"translational", "rotational"}
        The kind of axis, and that of the forces where it is another one.
    """
    all_loops = [loop for families in panels.values() for loops in families.values() for loop in loops]
    length = scale_for("length", kind, *(x for x, _ in all_loops))
    force, word = effort_scale(effort or kind, *(f for _, f in all_loops))
    low, high = (edge(float(edge(f)) for _, f in all_loops) * force.factor for edge in (min, max))
    more = 0.0 if _fits(panels) else LINE * lines([label(name) for name in next(iter(panels.values()))])
    figure, (row,) = style.panels(3.5 + more, columns=len(panels), between=BETWEEN, top=0.32 + more)
    for column, (axes, (title, families)) in enumerate(zip(row, panels.items(), strict=True)):
        looks = LOOKS[-1:] if len(families) == 1 else LOOKS
        for look, (name, loops) in zip(looks, families.items(), strict=False):
            for index, (x, f) in enumerate(loops):
                axes.plot(x * length.factor, f * force.factor, label=f"_{name}" if index else label(name), **look)
        axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
        axes.set_xlabel(length.label(position_word(kind)))
        if column:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(force.label(f"Friction {word.lower()}"))
        style.title(axes, title)
    if max(map(len, panels.values())) > 1:
        style.legend(row[0], 2, top=more > 0.0)
    return figure


def _fits(panels: Mapping[str, Mapping[str, Loops]]) -> bool:
    """Return whether the title of the first panel has room beside the legend."""
    title, families = next(iter(panels.items()))
    needed = line_width([label(name) for name in families]) + width(one_line(title), LETTERS)
    return needed + APART <= style.panel_width(len(panels), BETWEEN)
