"""Error against what was measured for it: one line for each way to a model, its spread over repetitions, the floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from bristle.figures import style
from bristle.figures.legends import LINE, lines
from bristle.figures.names import label

__all__ = ["error_over_count"]

FLOOR = "scatter of the rig"
ASIDE = (0.96, 1.0, 1.04, 0.92, 1.08)  # factors on the counts, so that ranges stand beside each other


@style.styled
def error_over_count(counts: Sequence[int], errors: Mapping[str, np.ndarray], floor: float, count_name: str, error_name: str) -> Figure:
    """Return errors over the number of loops that were measured.

    Parameters
    ----------
    counts : sequence of int
        How many were measured.
    errors : mapping of str to ndarray, shape (count, repetition)
        Errors [%] by the way to the model; NaN where it cannot be made from so few.
    floor : float
        What a model of the mean would leave, because the contact does not repeat itself any better [%].
    count_name, error_name : str
        What stands at the axes.
    """
    more = LINE * (lines([*map(label, errors), FLOOR]) - 1)
    figure, ((axes,),) = style.panels(3.3 + more, top=0.32 + more)
    for (name, values), look, aside in zip(errors.items(), style.SERIES, ASIDE, strict=False):
        finite = np.isfinite(values).any(axis=1)
        at, rows = aside * np.asarray(counts)[finite], values[finite]
        axes.plot(at, rows.mean(axis=1), label=label(name), markersize=4.0, **look)
        axes.vlines(at, rows.min(axis=1), rows.max(axis=1), color=look["color"], linewidth=0.8)
    axes.axhline(floor, color=style.GREY, linewidth=1.0, linestyle=(0, (1, 2)), label=FLOOR)
    axes.set_xscale("log")
    axes.set_xticks(list(counts), [str(count) for count in counts])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(0.0, None)
    axes.margins(x=0.06)
    axes.set_xlabel(count_name)
    axes.set_ylabel(error_name)
    style.legend(axes)
    return figure
