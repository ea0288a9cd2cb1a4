"""Force over position along one path, for several models, with letters where it turned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.small_multiples import FIRST, LAST, Traces, force_over_position

__all__ = ["marked_path"]

BELOW, ABOVE = 0.08, 0.03  # room for letters, over the height
LETTER, SAME = 0.09, 0.03  # height of a letter, and within which two points are one


@style.styled
def marked_path(
    traces: Traces,
    turns: Mapping[str, Sequence[int]],
    letters: str,
    titles: Mapping[str, str],
    kind: Kind = "translational",
    effort: Kind | None = None,
    beneath: Traces | None = None,
    names: tuple[str, str] = ("there", "back and on"),
) -> Figure:
    """Return force over position with the turning points marked, one panel for each model.

    The way to the first turning point is wide and light, and what follows it narrow and dark; or, where something is
    compared, that is wide and light and all of the trace narrow and dark.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    turns : mapping of str to sequence of int
        Which points of a trace are turning points, the start included.
    letters : str
        What stands at them, one each; a blank for none.
    titles : mapping of str to str
        What stands above each panel.
    kind, effort : {"translational", "rotational"}
        The kind of axis, and that of the forces where it is another one.
    beneath : mapping of str to (x, force), optional
        What a trace is compared with, by the same names.
    names : (str, str)
        What the wide line is called, and the narrow one.
    """
    columns, under = min(2, len(traces)), (names[0], beneath) if beneath else None
    figure, panels, _ = force_over_position(traces, titles, kind, effort, columns, top=0.56, beneath=under)
    for name, axes, x, force in panels:
        samples = np.asarray(turns[name])
        first = 0 if beneath else int(samples[1])
        if not beneath:
            axes.plot(x[: first + 1], force[: first + 1], label=names[0], **FIRST)
        axes.plot(x[first:], force[first:], label=names[1], **LAST)
        axes.plot(x[samples], force[samples], "o", color=style.INK, fillstyle="none", markersize=4.5, label="_turns")
        low, high = axes.get_ylim()
        axes.set_ylim(low - BELOW * (high - low), high + ABOVE * (high - low))
        _write_letters(axes, x[samples], force[samples], letters)
        axes.margins(x=0.08)
    style.legend_in_corner(figure, figure.axes[0])
    return figure


def _write_letters(axes: style.Axes, x: np.ndarray, force: np.ndarray, letters: str) -> None:
    """Write a letter beside each point, away from the middle; the same letter twice only where the points part."""
    middle = 0.5 * (float(x.min()) + float(x.max()))
    low, high = axes.get_ylim()
    written: list[tuple[str, float, float]] = []
    for position, height, letter in zip(x, force, letters, strict=True):
        apart = [abs(mark[2] - height) / (high - low) for mark in written if mark[0] == letter]
        if letter.strip() and min(apart, default=1.0) > SAME:
            left, below = position < middle, min(apart, default=1.0) < LETTER
            shift = (-5 if left else 5, -9 if left or below else 2)
            axes.annotate(
                letter,
                (position, height),
                xytext=shift,
                textcoords="offset points",
                ha="right" if left else "left",
                fontsize=8.5,
                color=style.INK,
            )
            written.append((letter, position, height))
