"""Figures of records: the experiments in a log, and hysteresis, recorded and predicted by an operator."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core import Kind
from bristle.figures import style
from bristle.figures.report_figure import ReportFigure
from bristle.logs import Log, Passage

# Distinguishable in grey too: from dark to light, and hatched.
SHADES = {
    "constant_velocity": ("#b9d3ea", ""),
    "loops": ("#f0cf8e", ""),
    "break_away": ("#b5dcc9", "////"),
    "chirp": ("#dcb6cf", "...."),
    "oscillation": ("#e6d7e1", "...."),
    "moves": ("#e4e7ea", ""),
}


LOOPS = ("loops", "break_away")
SLOPE = 5e-3  # [s] of a position from which a velocity is derived


@style.styled
def passages(log: Log, segments: Sequence[Passage]) -> Figure:
    """Return position over time with its passages shaded, and the effort over position of the loops."""
    loops = [segment for segment in segments if segment.kind in LOOPS] if log.effort is not None else []
    figure, rows = style.panels(4.9 if loops else 2.4, rows=2 if loops else 1, heights=[1.0, 1.4] if loops else None)
    axes, time, position = rows[0][0], log.time.values, log.position.values
    span, scale, word = style.time_scale(time), style.scale_for("length", log.kind, position), style.position_word(log.kind)
    names = {kind: kind.replace("_", " ") for kind in SHADES}
    for segment in segments:
        if segment.kind in SHADES:
            shade, hatch = SHADES[segment.kind]
            look = {"facecolor": shade, "hatch": hatch, "edgecolor": "white", "linewidth": 0, "zorder": 0}
            axes.axvspan(segment.begin * span.factor, segment.end * span.factor, label=names[segment.kind], **look)
            names[segment.kind] = f"_{names[segment.kind].lstrip('_')}"
    style.over_time(axes, time, (position, style.PREDICTED, ""), scale=scale, word=word)
    style.legend(axes, columns=len(SHADES))
    if loops and log.effort is not None:
        _draw_loops(rows[1][0], log, log.effort.values, loops)
    return figure


def _draw_loops(axes: Axes, log: Log, effort: np.ndarray, loops: Sequence[Passage]) -> None:
    positions = [log.position.values[loop.samples] - log.position.values[loop.samples][0] for loop in loops]
    efforts = [effort[loop.samples] for loop in loops]
    length, (force, word) = style.scale_for("length", log.kind, *positions), style.effort_scale(log.kind, *efforts)
    step = max(sum(loop.size for loop in positions) // 20_000, 1)
    for x, u in zip(positions, efforts, strict=True):
        axes.plot(x[::step] * length.factor, u[::step] * force.factor, **style.REST)
    title = "pre-sliding loops and break-aways, each from its start"
    axes.set(title=title, xlabel=length.label(style.position_word(log.kind)), ylabel=force.label(word))


@style.styled
def log_over_time(log: Log) -> Figure:
    """Return position, velocity and effort of a log over time, a panel each; the slope of the position for a missing velocity."""
    time, position, reach = log.time.values, log.position.values, max(round(SLOPE / log.sample_time), 1)
    span, slope = time[reach:] - time[:-reach], position[reach:] - position[:-reach]
    velocity = np.where(span < 1.5 * reach * log.sample_time, slope / span, np.nan)  # not across a gap
    signals = [(time, position, "length", style.position_word(log.kind)), (time[reach:] - 0.5 * span, velocity, "length/time", "Velocity")]
    if log.velocity is not None:
        signals[1] = time, log.velocity.values, "length/time", "Velocity"
    signals += [] if log.effort is None else [(time, log.effort.values, "force", style.effort_word(log.kind))]
    figure, rows = style.panels(0.3 + style.ROW * len(signals), rows=len(signals))
    for (axes,), (instants, values, quantity, word) in zip(rows, signals, strict=True):
        scale = style.scale_for(quantity, log.kind, values)
        style.over_time(axes, instants, (values, style.PREDICTED, "_"), scale=scale, word=word)
    rows[1][0].set_title("slope of the position" * (log.velocity is None))
    return figure


def _has_loops(log: Log, passages: Sequence[Passage]) -> bool:
    return log.effort is not None and any(passage.kind in LOOPS for passage in passages)


PASSAGES = ReportFigure(
    name="passages",
    takes=("log", "passages"),
    draw=passages,
    alternative=lambda log, passages: f"Position over time{', and effort over position of its loops' if _has_loops(log, passages) else ''}",
    caption=lambda log, passages: (
        "The shading shows the kind of experiment in each part of the log."
        + " Below, effort over position where friction reverses slowly. Nested loops distinguish models of friction, "
        "loops of one amplitude do not." * _has_loops(log, passages)
    ),
)


@style.styled
def recorded_curves(curves: Sequence[tuple[np.ndarray, np.ndarray]], predicted: Sequence[np.ndarray], kind: Kind) -> Figure:
    """Return output over input, recorded and predicted, and the difference of both."""
    step = -(-len(curves) // 24)
    chosen = [(u, f, f_predicted) for (u, f), f_predicted in zip(curves, predicted, strict=True)][::step]
    length = style.scale_for("length", kind, *(u for u, _, _ in chosen))
    scale, word = style.effort_scale(kind, *(f for _, f, _ in chosen))
    rest, _ = style.effort_scale(kind, *(f - f_predicted for _, f, f_predicted in chosen))
    figure, ((overlay, left),) = style.panels(3.2, columns=2, between=0.75)
    for number, (u, f, f_predicted) in enumerate(chosen):
        x = u * length.factor
        overlay.plot(x, f * scale.factor, label=None if number else "recorded", **style.MEASURED)
        overlay.plot(x, f_predicted * scale.factor, label=None if number else "predicted", **style.PREDICTED)
        left.plot(x, (f - f_predicted) * rest.factor, color=style.INK, linewidth=0.8)
    overlay.set_title("recorded and predicted")
    left.set_title("recorded minus predicted")
    overlay.set_ylabel(scale.label(word))
    left.set_ylabel(rest.label(word))
    for axes in (overlay, left):
        axes.set_xlabel(length.label(style.position_word(kind)))
    overlay.legend()
    return figure


CURVES = ReportFigure(
    name="curves",
    takes=("recorded", "outputs"),
    draw=lambda recorded, outputs: recorded_curves(recorded.curves, outputs, recorded.kind),
    alternative="Recorded and predicted output over the input",
    caption="Where the light line of the record is visible, the prediction is wrong. If there are many curves, the figure shows only some.",
)
