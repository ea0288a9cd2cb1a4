"""Closure side by side: which model comes back to the force that it left a loading curve with."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import number
from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.small_multiples import FIRST, LAST, Traces, force_over_position

__all__ = ["closure"]


@style.styled
def closure(traces: Traces, missing: Mapping[str, float], kind: Kind = "translational") -> Figure:
    """Return force over position along ``0 -> x1 -> x2 -> x1``, with the force at x1 before and after.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    missing : mapping of str to float
        The force that is missing at the return, as a fraction of break-away.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    titles = {name: f"{name}: {_percent(share)}" for name, share in missing.items()}
    figure, panels, _ = force_over_position(traces, titles, kind)
    for _, axes, x, force in panels:
        turn = int(np.argmax(np.abs(x)))
        axes.plot(x[: turn + 1], force[: turn + 1], label="loading", **FIRST)
        axes.plot(x[turn:], force[turn:], label="back and again", **LAST)
        mark = {"linestyle": "none", "markersize": 5.0, "color": style.INK, "fillstyle": "none"}
        axes.plot(x[turn], force[turn], marker="o", label="left", **mark)
        axes.plot(x[-1], force[-1], marker="x", label="returned", **mark)
    return figure


def _percent(share: float) -> str:
    return f"{number(100.0 * share, resolution=1.0)} %" if abs(share) >= 5e-5 else "closes"
