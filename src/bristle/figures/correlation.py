"""Which parameters the log cannot tell apart: the correlation of their estimates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from bristle.figures import style
from bristle.figures.drawing import AT_TICKS
from bristle.figures.lettering import shortened_apart
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.identification.result import Fit

# Lightness carries the size of a correlation and the number in the cell its sign, so grey loses nothing.
SHADES = LinearSegmentedColormap.from_list("strength", ["#ffffff", "#cfe0f0", "#5b8fc0", "#0b3c6f"])


@style.styled
def correlation(fit: Fit) -> Figure:
    """Return the matrix of correlations between the estimates, as shades and numbers."""
    matrix = np.asarray(fit.correlation)
    names = shortened_apart(fit.correlation_names, style.NARROW, AT_TICKS)
    count = len(names)
    label_width = style.at_axis(names, style.NARROW)
    left = 0.5 + label_width
    cell = min(0.62, (style.WIDTH - left - 0.15) / count)
    slanted = label_width > cell
    bottom = 0.38 + (label_width * 0.7 if slanted else 0.2)  # height of a slanted name over its length, the height of its letters included
    tall = min(0.36, cell) * count
    figure, ((axes,),) = style.panels(tall + bottom + 0.15, left=left, right=style.WIDTH - left - cell * count, bottom=bottom, top=0.15)
    axes.pcolormesh(np.ma.masked_invalid(np.abs(matrix)), cmap=SHADES, vmin=0.0, vmax=1.0, edgecolors="white", linewidth=0.8)
    for row in range(count):
        for column in range(count):
            value = matrix[row, column]
            text = ("0" if abs(value) < 0.005 else f"{value:+.2f}".replace("-", "−")) if np.isfinite(value) else "–"
            color = "white" if abs(value) > 0.6 else style.INK
            axes.text(column + 0.5, row + 0.5, text, ha="center", va="center", color=color, fontsize=min(AT_TICKS, 16.0 * cell))
    ticks = np.arange(count) + 0.5
    axes.set_xticks(ticks, names, rotation=45 if slanted else 0, ha="right" if slanted else "center")
    axes.set_yticks(ticks, names)
    axes.set_ylim(count, 0)
    axes.grid(False)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set(xlabel="Parameter", ylabel="Parameter")
    return figure


FIGURE = ReportFigure(
    name="correlation",
    takes="fit",
    draw=correlation,
    applies=lambda fit: len(fit.correlation_names) > 1,
    alternative="Correlation between the estimates of the parameters",
    caption="Correlation of the estimates; darker is stronger. Near ± 1 the log knows a combination of two parameters "
    "better than either of them.",
)
