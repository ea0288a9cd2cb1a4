"""Drift side by side: which model walks under a force that goes up and down below break-away."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import with_unit
from bristle.core.variable import Kind, unit_of
from bristle.figures import style
from bristle.figures.small_multiples import FIRST, LAST, Traces, force_over_position

__all__ = ["drift"]

NEGLIGIBLE = 1e-6  # of the width of the panel


@style.styled
def drift(traces: Traces, per_cycle: Mapping[str, float], kind: Kind = "translational") -> Figure:
    """Return force over position while the force goes up and down: the first loading wide and light, then the cycles.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    per_cycle : mapping of str to float
        How far it walks in a settled cycle [m or rad].
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    widest = max(float(np.ptp(x)) for x, _ in traces.values())
    titles = {
        name: f"{name}: {with_unit(step, unit_of('length', kind)) if abs(step) > NEGLIGIBLE * widest else 'none'}"
        for name, step in per_cycle.items()
    }
    figure, panels, length = force_over_position(traces, titles, kind)
    for _, axes, x, force in panels:
        top = int(np.argmax(force >= (1.0 - 1e-9) * np.max(force))) + 1
        axes.plot(x[:top], force[:top], label="first loading", **FIRST)
        axes.plot(x[top - 1 :], force[top - 1 :], label="cycles", **LAST)
        axes.set_xlim(-0.03 * widest * length.factor, 1.03 * widest * length.factor)
    return figure
