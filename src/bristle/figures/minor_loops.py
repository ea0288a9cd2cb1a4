"""Loops of friction models side by side: a large one with smaller ones inside."""

from __future__ import annotations

from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.small_multiples import LAST, Traces, force_over_position

__all__ = ["minor_loops"]


@style.styled
def minor_loops(traces: Traces, kind: Kind = "translational") -> Figure:
    """Return force over position, one panel for each model.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    figure, panels, _ = force_over_position(traces, {name: name for name in traces}, kind)
    for name, axes, x, force in panels:
        axes.plot(x, force, label=name, **LAST)
    return figure
