"""The picture of an arm: measured and modelled effort of each joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from bristle.report.figures import style
from bristle.report.figures.first_screen import PALE, WITH
from bristle.report.figures.report_figure import shown
from bristle.simulation import worst_reversal

if TYPE_CHECKING:
    from bristle.core import Kind
    from bristle.simulation import Prediction

COLUMNS, SHARE = 3, 0.05  # of a log without a reversal


@shown(
    "joints",
    ("joints", "kind"),
    "Effort of each joint at the reversal with its largest change: measured (wide) and model (narrow)",
)
def effort_of_joints(joints: Mapping[str, Prediction], kind: Kind) -> Figure:
    """Return measured and predicted effort of each joint at the reversal where its effort changes most."""
    figure, grid = style.grid_of(
        len(joints),
        COLUMNS,
        gap=0.6,
        between=0.82,
        top=0.3,
        names=("measured", "model"),
        over_titles=True,
    )
    scale, word = style.effort_scale(
        kind, *(one.effort for one in joints.values() if one.effort is not None)
    )
    for axes, (name, predicted) in zip(grid, joints.items(), strict=True):
        assert predicted.effort is not None
        assert predicted.effort_predicted is not None
        error = predicted.effort - predicted.effort_predicted
        part = worst_reversal(predicted.position, predicted.effort) or style.window(
            predicted.time, error, SHARE
        )
        lines = (
            (predicted.effort[part], PALE, "measured"),
            (predicted.effort_predicted[part], WITH | {"linewidth": 1.4}, "model"),
        )
        style.over_time(axes, predicted.time[part], *lines, scale=scale, word=word)
        style.title(axes, name)
    style.legend(grid[0])
    return figure
