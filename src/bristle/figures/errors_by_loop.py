"""Errors of several loops, with their spread over runs, above those that others published."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.names import shortened_apart

__all__ = ["errors_by_loop"]

LONGEST = 2.4  # inch, of a name
HERE, PUBLISHED = "here, mean ± standard deviation", "as published"


@style.styled
def errors_by_loop(errors: Mapping[str, float], spreads: Mapping[str, float], published: Mapping[str, float], error_name: str) -> Figure:
    """Return the error of each loop, and what others published, one a row.

    Parameters
    ----------
    errors, spreads : mapping of str to float
        Mean over the runs by the name of the loop, and standard deviation, in the unit that the axis names.
    published : mapping of str to float
        What others published, by the name of its row.
    error_name : str
        What stands at the axis.
    """
    names = shortened_apart([*errors, *published], LONGEST, style.AT_AXES)
    left = max(0.4 + min(style.room_for(names), LONGEST), 1.0)
    figure, ((axes,),) = style.panels(0.85 + 0.24 * len(names), left=left)
    look = style.SERIES[1]
    for row, (name, error) in enumerate(errors.items()):
        spread = spreads.get(name, 0.0)
        axes.hlines(row, error - spread, error + spread, color=look["color"], linewidth=2.5, label="_spread")
        axes.plot(error, row, "o", color=look["color"], label=f"_{HERE}" if row else HERE)
        # Numbers stand behind the marks, whatever the size of the page.
        axes.annotate(f"{error:.2f}", (error, row), (0, 4), textcoords="offset points", ha="center", fontsize=7.5)
    for row, value in enumerate(published.values(), len(errors)):
        label = PUBLISHED if row == len(errors) else f"_{PUBLISHED}"
        axes.plot(value, row, "D", fillstyle="none", color=style.INK, label=label)
        axes.annotate(f"{value:.2f}", (value, row), (0, 6), textcoords="offset points", ha="center", fontsize=7.5)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.8)
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(0.0, 1.1 * max(*errors.values(), *published.values()))
    axes.set_xlabel(error_name)
    axes.set_ylabel("Loop")
    style.legend(axes)
    return figure
