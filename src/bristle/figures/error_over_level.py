"""An error over a number that was assumed, with its spread over runs, and levels to compare with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.legends import LINE, lines
from bristle.figures.names import label

__all__ = ["error_over_level"]

COMPUTED = "found"


@style.styled
def error_over_level(
    levels: Sequence[float],
    errors: Sequence[float],
    spreads: Sequence[float],
    compared: Mapping[str, float],
    level_name: str,
    error_name: str,
) -> Figure:
    """Return errors over what was assumed.

    Parameters
    ----------
    levels : sequence of float
        What was assumed, in the unit that the axis names.
    errors, spreads : sequence of float
        Mean over the runs, and standard deviation; drawn as bars of that length to either side.
    compared : mapping of str to float
        Levels of the error to compare with, by name.
    level_name, error_name : str
        What stands at the axes.
    """
    more = LINE * (lines([COMPUTED, *map(label, compared)]) - 1)
    figure, ((axes,),) = style.panels(2.9 + more, top=0.32 + more)
    look = style.SERIES[1]
    axes.plot(levels, errors, label=COMPUTED, markersize=4.0, **look)
    low, high = ([error + side * spread for error, spread in zip(errors, spreads, strict=True)] for side in (-1.0, 1.0))
    axes.vlines(levels, low, high, color=look["color"], linewidth=1.2)
    for name, value in compared.items():
        axes.axhline(value, color=style.GREY, linewidth=1.0, linestyle=(0, (1, 2)), label=label(name))
    axes.set_ylim(0.0, 1.15 * max(*high, *compared.values()))
    axes.margins(x=0.06)
    axes.set_xlabel(level_name)
    axes.set_ylabel(error_name)
    style.legend(axes)
    return figure
