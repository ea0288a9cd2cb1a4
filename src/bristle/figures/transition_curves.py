"""Transition curves: the ascending branch, and the branches that leave it, which determine a Preisach operator."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.contracts import Model
from bristle.engine import response
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for

__all__ = ["transition_curves"]

SAMPLES = 161


@style.styled
def transition_curves(operators: Mapping[str, Model], extent: float, count: int = 10) -> Figure:
    """Return the first-order reversal curves of operators, one panel for each.

    Parameters
    ----------
    operators : mapping of str to Model
        Hysteresis operators of one kind of axis, by the name above their panel.
    extent : float
        Input at both ends of the ascending branch [m or rad].
    count : int
        Number of branches that leave it.
    """
    families = {name: _family(operator, extent, count) for name, operator in operators.items()}
    kind = next(iter(operators.values())).kind
    curves = [curve for family in families.values() for curve in family]
    length = scale_for("length", kind, *(u for u, _ in curves))
    scale, word = effort_scale(kind, *(f for _, f in curves))
    figure, (row,) = style.panels(3.2, columns=len(families), between=0.2)
    limit = 1.06 * max(float(np.max(np.abs(f))) for _, f in curves) * scale.factor
    for column, (axes, (name, (ascending, *falling))) in enumerate(zip(row, families.items(), strict=True)):
        for u, f in falling:
            axes.plot(u * length.factor, f * scale.factor, color="#5b7f9e", linewidth=0.8)
        u, f = ascending
        axes.plot(u * length.factor, f * scale.factor, color=style.INK, linewidth=1.8)
        axes.plot(-extent * length.factor, f[0] * scale.factor, "o", color="#e0a83c", markersize=4.5)
        style.title(axes, name)
        axes.set_ylim(-limit, limit)
        axes.set_xlabel(length.label(position_word(kind)))
        if column:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(scale.label(f"Friction {word.lower()}"))
    return figure


def _family(operator: Model, extent: float, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the ascending branch from the lower end, and the descending ones from it to that end."""
    rise = np.linspace(-extent, extent, SAMPLES)
    branches = [(rise, response(operator, rise, history=[-extent]))]
    for alpha in np.linspace(-extent, extent, count + 1)[1:].tolist():
        # Denser where the branch is steepest.
        fall = alpha - (alpha + extent) * np.linspace(0.0, 1.0, SAMPLES) ** 2
        branches.append((fall, response(operator, fall, history=[-extent])))
    return branches
