"""What each log of a fleet says of each parameter, with its interval: a panel for each, a point for each log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle.core.typography import scale_of
from bristle.figures import style
from bristle.figures.labels import largest
from bristle.figures.names import shortened
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.study.dataset import Runs

__all__ = ["FIGURE", "fleet_parameters"]

COLUMNS = 2
ROW = 1.55  # inches
WIDEST = 1.5
APART = "#b5651d"
EDGE = 0.02  # of a panel: beyond the last interval
MARGIN = 0.6  # of what most logs span, above and below: what lies beyond ends in an arrow
FEW = 60  # logs up to which markers are large


@style.styled
def fleet_parameters(runs: Runs, names: Sequence[str], apart: Mapping[str, np.ndarray]) -> Figure:
    """Return the parameters of a fleet, log by log.

    Parameters
    ----------
    runs : Runs
        The rows of the fleet.
    names : sequence of str
        Columns of parameters, each of which a log tells.
    apart : mapping of str to ndarray
        By column, places of the logs that stand apart.
    """
    rows, columns = -(-len(names) // COLUMNS), min(len(names), COLUMNS)
    figure, grid = style.panels(0.75 + (ROW + 0.32) * rows, rows, columns, top=0.3, between=0.8, gap=0.32)
    panels = [axes for row in grid for axes in row]
    for unused in panels[len(names) :]:
        unused.remove()
    for place, (axes, name) in enumerate(zip(panels, names, strict=False)):
        _draw(axes, runs, name, apart[name])
        if place + columns >= len(names):
            axes.set_xlabel("Log, by its number")
        else:
            axes.tick_params(labelbottom=False)
    richest = max(panels[: len(names)], key=lambda axes: len(axes.get_legend_handles_labels()[1]))
    style.legend_in_corner(figure, richest)
    return figure


def _draw(axes: Axes, runs: Runs, name: str, apart: np.ndarray) -> None:
    columns, number = runs.columns, runs.columns["run"]
    tells = np.isfinite(columns[name]) & (columns[f"{name}.status"] == "identified")
    scale = scale_of(runs.described["columns"][name]["unit"], largest(np.median(np.abs(columns[name][tells]))))
    value, low, high = (columns[key] * scale.factor for key in (name, f"{name}.lower", f"{name}.upper"))
    bottom, top = _reach(value[tells])
    strange = np.zeros(runs.count, dtype=bool)
    strange[apart] = True
    size = 3.4 if runs.count <= FEW else 2.0
    axes.axhline(float(np.median(value[tells])), color=style.GREY, linewidth=0.9, linestyle="--", label="median")
    inside = (value >= bottom) & (value <= top)
    for chosen, fill, word in (
        (tells & ~strange & inside, "full", "log, 95 % interval"),
        (tells & strange & inside, "none", "stands apart"),
    ):
        if chosen.any():
            ends = np.nan_to_num(np.abs([value - low, high - value]))[:, chosen]
            axes.errorbar(
                number[chosen],
                value[chosen],
                ends,
                fmt="o",
                markersize=size,
                fillstyle=fill,
                linewidth=0.8,
                color=style.PREDICTED["color"] if fill == "full" else APART,
                label=word,
            )
    above, below = tells & (value > top), tells & (value < bottom)
    ends = np.concatenate([end[tells & inside & np.isfinite(end)] for end in (low, high)])
    bottom, top = min([bottom, *ends]), max([top, *ends])  # every interval lies inside
    for chosen, marker, height in ((above, "^", 0.97), (below, "v", 0.03)):
        axes.scatter(
            number[chosen],
            np.full(chosen.sum(), height),
            marker=marker,
            s=16,
            facecolors="none",
            edgecolors=APART,
            transform=axes.get_xaxis_transform(),
            label="_beyond",
        )
    axes.scatter(
        number[~tells],
        np.zeros((~tells).sum()),
        marker="|",
        s=49,
        color=style.INK,
        clip_on=False,
        transform=axes.get_xaxis_transform(),
        label="no value",
    )
    room = EDGE * (top - bottom)
    axes.set_ylim(bottom - room, top + room)
    axes.set_xlim(float(number.min()) - 1.0, float(number.max()) + 1.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(scale.label(shortened(name, WIDEST, style.AT_AXES)))


def _reach(values: np.ndarray) -> tuple[float, float]:
    """Return from where to where a panel reaches: past what most logs span, and to all of them if they are near."""
    low, high = np.quantile(values, (0.05, 0.95))
    margin = MARGIN * float(high - low) or 0.1 * abs(float(high)) or 1.0
    return max(float(low) - margin, float(values.min()) - 0.3 * margin), min(float(high) + margin, float(values.max()) + 0.3 * margin)


FIGURE = ReportFigure(
    name="fleet",
    takes=("fleet", "names", "apart"),
    draw=fleet_parameters,
    alternative=lambda runs, names, apart: f"{', '.join(names)} of each log with 95 % intervals",
    caption="Each log by its number, with its 95 % interval; the line is the median. Hollow: a log that stands apart. A "
    "tick at the bottom: a log that failed, or that does not tell this parameter. An arrow: beyond the panel.",
)
