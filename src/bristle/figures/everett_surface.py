"""The Everett function over the Preisach plane: what a measure adds between two turning points."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from bristle.core.contracts import Model
from bristle.core.dispatch import everett
from bristle.core.errors import InputError
from bristle.figures import style
from bristle.figures.labels import effort_scale, scale_for

__all__ = ["everett_surface"]

NODES, LEVELS = 61, 9
SHADES = LinearSegmentedColormap.from_list("shades", ["#ffffff", "#9db6d0", "#0b3c6f"])
SHARES = (-0.5, 0.0, 0.5)


@style.styled
def everett_surface(operator: Model, extent: float) -> Figure:
    """Return the Everett function as heights over the thresholds, and along the way from the diagonal.

    Parameters
    ----------
    operator : Model
        An operator with an Everett function: `preisach` or `everett_table`.
    extent : float
        Largest threshold that is shown [m or rad].

    Raises
    ------
    InputError
        If the operator has no Everett function.
    """
    if operator.component.measure is None:
        raise InputError("has no Everett function", path="operator", value=operator.name)
    q = operator.component.measure(operator.parameters)
    inputs = np.linspace(-extent, extent, NODES)
    E = np.array([[everett(a, b, q) if a >= b else np.nan for b in inputs.tolist()] for a in inputs.tolist()])
    length = scale_for("length", operator.kind, inputs)
    scale, _ = effort_scale(operator.kind, E)
    figure, ((plane, section),) = style.panels(3.6, columns=2, between=0.75)
    edge = inputs * length.factor
    plane.contourf(edge, edge, E * scale.factor, levels=LEVELS, cmap=SHADES)
    lines = plane.contour(edge, edge, E * scale.factor, levels=LEVELS, colors=style.INK, linewidths=0.6)
    plane.clabel(lines, np.asarray(lines.levels)[1:-1:2], fontsize=7, fmt="%g")
    plane.plot(edge, edge, color=style.GREY, linewidth=0.9)
    plane.set_aspect("equal", adjustable="box")
    plane.set_title(scale.label("E(α, β)"))
    plane.set_xlabel(length.label("Threshold β, down"))
    plane.set_ylabel(length.label("Threshold α, up"))
    for share, look in zip(SHARES, style.SERIES[1:], strict=False):
        # Towards one corner of the triangle a section is shorter.
        d = np.linspace(0.0, 2.0 * extent * (1.0 - abs(share)), NODES)
        heights = [everett(share * extent + 0.5 * width, share * extent - 0.5 * width, q) for width in d.tolist()]
        name = f"{share * extent * length.factor:g}".replace("-", "−")
        section.plot(d * length.factor, np.array(heights) * scale.factor, label=name, markevery=10, markersize=3.5, **look)
    section.set_xlabel(length.label("α − β"))
    section.set_ylabel(scale.label("E"))
    section.set_title(length.label("(α + β)/2"))
    style.legend(section, len(SHARES), handle=1.2)
    return figure
