"""Which parameters the log cannot tell apart: the correlation of their estimates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from bristle.figures import style

if TYPE_CHECKING:
    from bristle.identification.result import Fit

__all__ = ["correlation"]

# Lightness carries the size of a correlation and the number in the cell its sign, so grey loses nothing.
SHADES = LinearSegmentedColormap.from_list("strength", ["#ffffff", "#cfe0f0", "#5b8fc0", "#0b3c6f"])
LIGHT_TEXT_ABOVE = 0.6


@style.styled
def correlation(fit: Fit) -> Figure:
    """Return the matrix of correlations between the estimates, as shades and numbers.

    Parameters
    ----------
    fit : Fit
        A model with the correlation of its estimates.
    """
    names, matrix = fit.correlation_names, np.asarray(fit.correlation)
    count = len(names)
    wide, tall = min(0.62 * count, 5.6), min(0.36 * count, 4.4)
    left = 0.55 + 0.085 * max(map(len, names), default=4)
    figure, ((axes,),) = style.panels(tall + 0.75, left=left, right=style.WIDTH - left - wide, bottom=0.62, top=0.13)
    axes.pcolormesh(
        np.ma.masked_invalid(np.abs(matrix)), cmap=SHADES, vmin=0.0, vmax=1.0, edgecolors="white", linewidth=0.8
    )
    for row in range(count):
        for column in range(count):
            value = matrix[row, column]
            text = _signed(value) if np.isfinite(value) else "–"
            color = "white" if abs(value) > LIGHT_TEXT_ABOVE else style.INK
            axes.text(column + 0.5, row + 0.5, text, ha="center", va="center", color=color, fontsize=8)
    ticks = np.arange(count) + 0.5
    axes.set_xticks(ticks, names, rotation=0 if count <= 6 else 40, ha="center" if count <= 6 else "right")
    axes.set_yticks(ticks, names)
    axes.set_ylim(count, 0)
    axes.grid(False)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xlabel("Parameter")
    axes.set_ylabel("Parameter")
    return figure


def _signed(value: float) -> str:
    return "0" if abs(value) < 0.005 else f"{value:+.2f}".replace("-", "−")
