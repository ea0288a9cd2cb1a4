"""Figures of records: the motion and effort in a log, and hysteresis, recorded and predicted by an operator."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core import InputError, Kind
from bristle.core.palette import LIGHT
from bristle.logs import Log, Passage
from bristle.report.figures import style
from bristle.report.figures.first_screen import LOW, SIDE, TALL
from bristle.report.figures.report_figure import shown

# Distinguishable in grey too: from dark to light, and hatched.
SHADES = {
    "constant_velocity": ("with", 0.3, ""),
    "loops": ("measured", 0.5, ""),
    "break_away": ("third", 0.3, "////"),
    "chirp": ("fourth", 0.3, "...."),
    "oscillation": ("fourth", 0.15, "...."),
    "moves": ("shade", 1.0, ""),
}


LOOPS = ("loops", "break_away")
SLOPE = 5e-3  # [s] of a position from which a velocity is derived


@shown(
    "passages",
    ("log", "passages"),
    lambda log, passages: (
        f"Position{'' if log.effort is None else ' and effort'} over time, with the kind of motion shaded"
    ),
    "Shaded: the kind of motion.",
)
def passages(log: Log, segments: Sequence[Passage]) -> Figure:
    """Return position over time with its passages shaded, and effort over time."""
    figure, rows = style.panels(
        2.4 if log.effort is None else TALL, rows=1 if log.effort is None else 2
    )
    axes, time, position = rows[0][0], log.time.values, log.position.values
    span, scale, word = (
        style.time_scale(time),
        style.scale_for("length", log.kind, position),
        style.position_word(log.kind),
    )
    names = {kind: kind.replace("_", " ") for kind in SHADES}
    for segment in segments:
        if segment.kind in SHADES:
            shade, alpha, hatch = SHADES[segment.kind]
            look = {
                "facecolor": LIGHT[shade],
                "alpha": alpha,
                "hatch": hatch,
                "edgecolor": LIGHT["ground"],
                "linewidth": 0,
                "zorder": 0,
            }
            axes.axvspan(
                segment.begin * span.factor,
                segment.end * span.factor,
                label=names[segment.kind],
                **look,
            )
            names[segment.kind] = f"_{names[segment.kind].lstrip('_')}"
    style.over_time(axes, time, (position, style.PREDICTED, ""), scale=scale, word=word)
    style.legend(axes, columns=len(SHADES))
    if log.effort is not None:
        force, word = style.effort_scale(log.kind, log.effort.values)
        style.over_time(
            rows[1][0],
            time,
            (log.effort.values, style.MEASURED | {"linewidth": 1.0}, ""),
            scale=force,
            word=word,
        )
    return figure


@shown(
    "loops",
    ("log", "passages"),
    "Effort over position of pre-sliding loops and break-aways",
    "Pre-sliding loops and break-aways, each from its start.",
    applies=lambda log, passages: (
        log.effort is not None and any(passage.kind in LOOPS for passage in passages)
    ),
)
def loops_of_log(log: Log, segments: Sequence[Passage]) -> Figure:
    """Return effort over position of pre-sliding loops and break-aways, each from its start."""
    assert log.effort is not None
    figure, ((axes,),) = style.panels(LOW, across=SIDE, top=0.12)
    loops, effort = [segment for segment in segments if segment.kind in LOOPS], log.effort.values
    positions = [
        log.position.values[loop.samples] - log.position.values[loop.samples][0] for loop in loops
    ]
    efforts = [effort[loop.samples] for loop in loops]
    length, (force, word) = (
        style.scale_for("length", log.kind, *positions),
        style.effort_scale(log.kind, *efforts),
    )
    step = max(sum(loop.size for loop in positions) // 20_000, 1)
    for x, u in zip(positions, efforts, strict=True):
        axes.plot(x[::step] * length.factor, u[::step] * force.factor, **style.REST)
    axes.set(xlabel=length.label(style.position_word(log.kind)), ylabel=force.label(word))
    return figure


@shown(
    "velocities",
    "log",
    "Measured effort over velocity",
    "Effort over velocity.",
    applies=lambda log: log.effort is not None,
)
def effort_over_velocity(log: Log) -> Figure:
    """Return effort over velocity of each sample, or of some of many."""
    assert log.effort is not None
    figure, ((axes,),) = style.panels(LOW, across=SIDE, top=0.12)
    velocity = (
        np.gradient(log.position.values, log.time.values)
        if log.velocity is None
        else log.velocity.values
    )
    speed, (force, word) = (
        style.scale_for("length/time", log.kind, velocity),
        style.effort_scale(log.kind, log.effort.values),
    )
    drawn = style.spread(velocity, log.effort.values)
    points = velocity[drawn] * speed.factor, log.effort.values[drawn] * force.factor
    axes.plot(
        *points,
        linestyle="none",
        marker="o",
        markersize=1.6,
        color=style.MEASURED["color"],
        label="measured",
    )
    axes.set(xlabel=speed.label("Velocity"), ylabel=force.label(word))
    return figure


@style.styled
def log_over_time(log: Log) -> Figure:
    """Return position, velocity and effort of a log over time, a panel each; the slope of the position for a missing velocity."""
    if not hasattr(log, "sample_time"):
        raise InputError(
            "must be a log", path="log", value=log, mend="Read it first: br.read_log(...)"
        )
    time, position, reach = (
        log.time.values,
        log.position.values,
        max(round(SLOPE / log.sample_time), 1),
    )
    span, slope = time[reach:] - time[:-reach], position[reach:] - position[:-reach]
    # Not across a gap.
    velocity = np.where(span < 1.5 * reach * log.sample_time, slope / span, np.nan)
    signals = [
        (time, position, "length", style.position_word(log.kind)),
        (time[reach:] - 0.5 * span, velocity, "length/time", "Velocity"),
    ]
    if log.velocity is not None:
        signals[1] = time, log.velocity.values, "length/time", "Velocity"
    signals += (
        []
        if log.effort is None
        else [(time, log.effort.values, "force", style.effort_word(log.kind))]
    )
    figure, rows = style.panels(0.3 + style.ROW * len(signals), rows=len(signals))
    for (axes,), (instants, values, quantity, word) in zip(rows, signals, strict=True):
        scale = style.scale_for(quantity, log.kind, values)
        style.over_time(axes, instants, (values, style.PREDICTED, "_"), scale=scale, word=word)
    rows[1][0].set_title("slope of the position" * (log.velocity is None))
    return figure


@shown(
    "curves",
    ("recorded", "outputs"),
    "Recorded and predicted output over the input",
    lambda recorded, outputs: "Some of the curves." * (len(recorded.curves) > 24),
    draw=lambda draw, recorded, outputs: draw(recorded.curves, outputs, recorded.kind),
)
def recorded_curves(
    curves: Sequence[tuple[np.ndarray, np.ndarray]], predicted: Sequence[np.ndarray], kind: Kind
) -> Figure:
    """Return output over input, recorded and predicted."""
    figure, ((axes,),) = style.panels(TALL, right=style.room_for(["predicted"]), top=0.12)
    length = style.scale_for("length", kind, *(u for u, _ in curves))
    scale, word = style.effort_scale(kind, *(f for _, f in curves))
    for number, (u, f, f_predicted) in enumerate(_thinned(curves, predicted)):
        axes.plot(
            u * length.factor,
            f * scale.factor,
            label="_recorded" if number else "recorded",
            **style.MEASURED,
        )
        axes.plot(
            u * length.factor,
            f_predicted * scale.factor,
            label="_predicted" if number else "predicted",
            **style.PREDICTED,
        )
    axes.set(xlabel=length.label(style.position_word(kind)), ylabel=scale.label(word))
    style.label_lines(axes)
    return figure


@shown(
    "errors",
    ("recorded", "outputs"),
    "Recorded minus predicted output over the input",
    "Recorded minus predicted.",
    draw=lambda draw, recorded, outputs: draw(recorded.curves, outputs, recorded.kind),
)
def curve_errors(
    curves: Sequence[tuple[np.ndarray, np.ndarray]], predicted: Sequence[np.ndarray], kind: Kind
) -> Figure:
    """Return recorded minus predicted output over input."""
    figure, ((axes,),) = style.panels(LOW, across=SIDE, top=0.12)
    chosen = _thinned(curves, predicted)
    length, (rest, word) = (
        style.scale_for("length", kind, *(u for u, _, _ in chosen)),
        style.effort_scale(kind, *(f - g for _, f, g in chosen)),
    )
    for u, f, f_predicted in chosen:
        axes.plot(
            u * length.factor, (f - f_predicted) * rest.factor, color=style.INK, linewidth=0.8
        )
    axes.set(xlabel=length.label(style.position_word(kind)), ylabel=rest.label(f"{word} error"))
    return figure


def _thinned(
    curves: Sequence[tuple[np.ndarray, np.ndarray]], predicted: Sequence[np.ndarray]
) -> list[tuple[np.ndarray, ...]]:
    """Return input, recorded and predicted output of at most 24 curves."""
    return [(u, f, f_predicted) for (u, f), f_predicted in zip(curves, predicted, strict=True)][
        :: -(-len(curves) // 24)
    ]
