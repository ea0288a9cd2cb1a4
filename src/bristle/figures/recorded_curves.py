"""Recorded hysteresis and what an operator makes of it, one panel over input, one with what is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.labels import effort_scale, position_word, scale_for
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    pass


@style.styled
def recorded_curves(curves: Sequence[tuple[np.ndarray, np.ndarray]], predicted: Sequence[np.ndarray], kind: Kind) -> Figure:
    """Return output over input, recorded and predicted, and the difference of both."""
    step = -(-len(curves) // 24)
    chosen = [(u, f, f_predicted) for (u, f), f_predicted in zip(curves, predicted, strict=True)][::step]
    length = scale_for("length", kind, *(u for u, _, _ in chosen))
    scale, word = effort_scale(kind, *(f for _, f, _ in chosen))
    rest, _ = effort_scale(kind, *(f - f_predicted for _, f, f_predicted in chosen))
    figure, ((overlay, left),) = style.panels(3.2, columns=2, between=0.75)
    for number, (u, f, f_predicted) in enumerate(chosen):
        x = u * length.factor
        overlay.plot(x, f * scale.factor, label=None if number else "recorded", **style.MEASURED)
        overlay.plot(x, f_predicted * scale.factor, label=None if number else "predicted", **style.PREDICTED)
        left.plot(x, (f - f_predicted) * rest.factor, color=style.INK, linewidth=0.8)
    overlay.set_title("recorded and predicted")
    left.set_title("recorded less predicted")
    overlay.set_ylabel(scale.label(word))
    left.set_ylabel(rest.label(word))
    for axes in (overlay, left):
        axes.set_xlabel(length.label(position_word(kind)))
    overlay.legend()
    return figure


FIGURE = ReportFigure(
    name="curves",
    takes=("recorded", "outputs"),
    draw=lambda recorded, outputs: recorded_curves(recorded.curves, outputs, recorded.kind),
    alternative="Recorded and predicted output over the input",
    caption="Where the light line looks out from under the dark one, what was recorded is not predicted. Of many curves, some are shown.",
)
