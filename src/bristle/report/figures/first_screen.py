"""The pictures of the first screen of an identification: gain at the worst reversal, friction over velocity and over displacement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from bristle.core import InputError, Variable, amount
from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.drawing import label, shortened_apart
from bristle.report.figures.following_error import at_worst_reversal, loops_of
from bristle.report.figures.report_figure import shown
from bristle.simulation import worst_reversal

if TYPE_CHECKING:
    from bristle.identification import Fit
    from bristle.simulation import SimulationResult

WITHOUT: style.Look = {"color": LIGHT["without"], "linewidth": 1.4, "linestyle": "-"}
WITH: style.Look = {"color": LIGHT["with"], "linewidth": 2.0, "linestyle": "-"}
THIN: style.Look = WITH | {"linewidth": 1.2}
PALE: style.Look = style.MEASURED | {"linewidth": 3.0}
# inches: height of the large picture, width and height of the small pictures
TALL, SIDE, LOW = (4.4, 5.8, 2.5)
DISTANCE = amount(Variable("length", "distance after a reversal", min=0.0))
MOST_REVERSALS = 12
CELLS = 100, 50  # of the cloud of measured friction
# Distance after a reversal over that of 95 % of the change; shortest travel over the longest.
WAY, LONG = (4.0, 0.05)
GAP = 20.0  # median steps between samples: some are left out
LINEAR = 1e-2  # velocity over the largest velocity below which the scale is linear


@shown(
    "gain",
    ("simulation", "gain_pair"),
    "Following error at the worst reversal without and with friction feedforward, simulated on the log; below, the whole log",
    draw=lambda draw, simulation, pair, following: draw(
        simulation, pair, None if following is None else following.error
    ),
    may_take=("following",),
)
@shown(
    "reversal",
    ("simulation", "at_reversal"),
    lambda simulation, names: (
        f"Error of {' and '.join(names)} at the worst reversal; below, the whole run"
    ),
    draw=lambda draw, simulation, names: draw(
        simulation,
        names,
        labels=shortened_apart([label(name).replace("_", " ") for name in names], 1.2),
    ),
)
def gain_at_reversal(
    result: SimulationResult,
    names: Sequence[str],
    measured: np.ndarray | None = None,
    *,
    labels: Sequence[str] = ("without", "with friction"),
) -> Figure:
    """Return the following error at the worst reversal without and with friction feedforward, and below over the whole log.

    Parameters
    ----------
    result : SimulationResult
        The simulated loop.
    names : sequence of str
        The variant without and the variant with friction feedforward; or one variant.
    measured : ndarray, shape (sample,), optional
        Following error of the axis in the log [m or rad]; shown if it is not much larger than without friction feedforward.
    labels : sequence of str
        Name of each variant in the figure.
    """
    loops = loops_of(result, measured)
    by_name = {loop.variant: loop for loop in loops if not loop.is_measured}
    drawn = [by_name[name] for name in names]
    called = dict(zip(names, labels, strict=False))
    looks = {names[0]: WITHOUT, names[-1]: WITH}
    # A variant of a user may also have the name "measured".
    if loops[0].is_measured and np.ptp(loops[0].error) <= 1.5 * np.ptp(drawn[0].error):
        drawn = [loops[0]._replace(variant=""), *drawn]
        called, looks = {"": "measured", **called}, {"": PALE, **looks}
    figure, near, strip = over_a_strip(called.values())
    kind, window = result.experiment.kind, at_worst_reversal(by_name[names[0]])
    scale = style.scale_for("length", kind, *(loop.error for loop in drawn), np.array([1e-6]))
    for axes, part in ((near, (window[0], window[-1])), (strip, (-np.inf, np.inf))):
        for loop in drawn:
            piece = loop.between(*part)
            style.over_time(
                axes,
                piece.time,
                (piece.error, looks[loop.variant], called[loop.variant]),
                scale=scale,
                word=loop.word,
            )
    near.axhline(0.0, **style.AID)
    as_strip(strip, window * style.time_scale(drawn[-1].time).factor)
    style.label_lines(near)
    return figure


def over_a_strip(
    names: Iterable[str], *, small: bool = False
) -> tuple[Figure, style.Axes, style.Axes]:
    """Return a figure with a large panel, with room for the names of its lines at its right, over a narrow strip."""
    size: style.Look = {"height": LOW, "across": SIDE} if small else {"height": TALL}
    heights = (3.0 if small else 4.2, 1.0)
    figure, ((near,), (strip,)) = style.panels(
        rows=2, heights=heights, right=style.room_for(names), gap=0.5, top=0.12, **size
    )
    return figure, near, strip


def draw_pair(
    near: style.Axes,
    strip: style.Axes | None,
    time: np.ndarray,
    pair: Sequence[np.ndarray],
    part: slice,
    **words: Any,
) -> None:
    """Draw a measured and a modelled signal near a part of the log, and over the whole log in a strip below."""
    for axes, chosen in ((near, part), *([(strip, slice(None))] if strip is not None else [])):
        lines = (
            (pair[0][chosen], PALE, "measured"),
            (pair[1][chosen], WITH | {"linewidth": 1.4}, "model"),
        )
        style.over_time(axes, time[chosen], *lines, **words)
    if strip is not None:
        as_strip(strip, time[part] * style.time_scale(time).factor)
    style.label_lines(near)


def as_strip(axes: style.Axes, window: np.ndarray | None = None) -> None:
    """Turn a panel into a narrow strip of the whole log, with the window of the large picture shaded."""
    axes.yaxis.label.set_visible(False)
    axes.yaxis.set_ticks([])
    if window is not None:
        axes.axvspan(
            float(window[0]),
            float(window[-1]),
            color=LIGHT["ghost"],
            alpha=0.35,
            linewidth=0,
            zorder=0,
        )


def without_gap(time: np.ndarray, part: slice) -> slice:
    """Return the longest stretch of a part of a log in which no samples are left out."""
    steps = np.diff(time[part])
    gaps = np.flatnonzero(steps > GAP * np.median(steps)) + 1
    ends = [0, *gaps.tolist(), steps.size + 1]
    start, stop = max(pairwise(ends), key=lambda stretch: stretch[1] - stretch[0])
    return slice(part.start + start, part.start + stop)


@shown(
    "effort",
    "fit",
    "Measured and predicted effort at the reversal with the largest change of effort; below, the whole log",
)
def effort_at_reversal(fit: Fit, *, small: bool = False) -> Figure:
    """Return measured and predicted effort at the reversal where the effort changes most, and below over the whole log."""
    traces, kind = fit.traces, fit.plant.kind
    position = np.cumsum(traces.velocity)
    part = without_gap(
        traces.time,
        worst_reversal(position, traces.measured)
        or style.window(traces.time, traces.residual, 0.05),
    )
    figure, near, strip = over_a_strip(["measured", "model"], small=small)
    scale, word = style.effort_scale(kind, traces.measured, traces.predicted)
    draw_pair(
        near, strip, traces.time, (traces.measured, traces.predicted), part, scale=scale, word=word
    )
    return figure


@shown(
    "velocity",
    ("fit", "curve"),
    "Friction over velocity, measured and modelled; the velocity axis is logarithmic away from zero",
    may_take=("curve_band",),
)
def friction_over_velocity(
    fit: Fit, curve: Sequence[tuple[float, float]], band: Sequence[float] | None = None
) -> Figure:
    """Return friction over velocity, measured and modelled, with a velocity axis that is linear near zero and logarithmic beyond.

    Parameters
    ----------
    fit : Fit
        A model and its fitted traces: the friction is their effort minus inertia.
    curve : sequence of (velocity, effort)
        Steady friction of the model [m/s or rad/s, N or N*m], in order of velocity.
    band : sequence of float, optional
        Half-width of the 95 % band of the model at each point of the curve [N or N*m].
    """
    figure, ((axes,),) = style.panels(
        LOW, across=SIDE, right=style.room_for(["measured"]), top=0.12
    )
    draw_friction(axes, fit, curve, band)
    style.label_lines(axes)
    return figure


def draw_friction(
    axes: style.Axes,
    fit: Fit,
    curve: Sequence[tuple[float, float]],
    band: Sequence[float] | None = None,
) -> None:
    """Draw friction over velocity, measured and modelled."""
    traces, friction, kind = fit.traces, fit.traces.friction, fit.plant.kind
    steady = np.array(list(curve), dtype=float).reshape(-1, 2)
    scale, word = style.effort_scale(kind, friction, steady[:, 1])
    speed = style.scale_for("length/time", kind, traces.velocity, steady[:, 0])
    drawn = style.spread(
        np.arcsinh(traces.velocity / (LINEAR * style.largest(traces.velocity) or 1.0)),
        friction,
        CELLS,
    )
    points = traces.velocity[drawn] * speed.factor, friction[drawn] * scale.factor
    axes.plot(
        *points,
        linestyle="none",
        marker="o",
        markersize=1.6,
        color=style.MEASURED["color"],
        label="measured",
    )
    for side in (np.signbit(steady[:, 0]), ~np.signbit(steady[:, 0])) if band else ():
        v, force, half = steady[side, 0], steady[side, 1], np.asarray(band)[side]
        ends = (force - half) * scale.factor, (force + half) * scale.factor
        axes.fill_between(
            v * speed.factor,
            *ends,
            color=WITH["color"],
            alpha=0.18,
            linewidth=0,
            label="_95 % band",
        )
    style.plot_by_side(axes, steady * (speed.factor, scale.factor), "model", WITH)
    # A narrower band is hidden by the line.
    if band and max(band) > 0.02 * float(np.ptp(steady[:, 1])):
        axes.text(
            0.99,
            0.03,
            "shaded: 95 % band",
            color=style.INK,
            transform=axes.transAxes,
            horizontalalignment="right",
        )
    # Linear near zero and logarithmic beyond, with a number at zero and at each power of ten.
    largest = style.largest(traces.velocity) * speed.factor or 1.0
    decades = 10.0 ** np.arange(
        np.ceil(np.log10(LINEAR * largest)), np.floor(np.log10(largest)) + 1.0
    )
    axes.set_xscale(
        "symlog", linthresh=float(decades[0]) if decades.size else LINEAR * largest, linscale=1.0
    )
    marks = [*(-decades[::-1]), 0.0, *decades]
    axes.set_xticks(marks, [f"{mark:g}".replace("-", "−") for mark in marks])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.axhline(0.0, **style.AID)
    axes.axvline(0.0, **style.AID)
    axes.set(xlabel=speed.label("Velocity"), ylabel=scale.label(f"Friction {word.lower()}"))


class Reversal(NamedTuple):
    """Rows of a log from one reversal to the next: displacement since the reversal [m or rad], and the rows."""

    displacement: np.ndarray
    rows: slice
    way: float


def reversals_of(time: np.ndarray, velocity: np.ndarray) -> list[Reversal]:
    """Return the motion after each reversal, longest first; a motion of less than `LONG` of the longest is left out."""
    step = float(np.median(np.diff(time))) if time.size > 1 else 1.0
    way = np.sign(velocity)
    cuts = np.flatnonzero((way[1:] != way[:-1]) | (np.diff(time) > 1.5 * step)) + 1
    starts, stops = np.concatenate([[0], cuts]), np.concatenate([cuts, [way.size]])
    motions = []
    for before, (start, stop) in zip(
        np.concatenate([[0], starts[:-1]]), zip(starts, stops, strict=True), strict=True
    ):
        # A motion in the other direction, or a rest after it, precedes a reversal.
        follows = (
            start > 0
            and time[start] - time[start - 1] <= 1.5 * step
            and way[before] in (-way[start], 0.0)
        )
        if way[start] and follows and stop - start > 2:
            motions.append(
                Reversal(
                    np.cumsum(np.abs(velocity[start:stop])) * step,
                    slice(int(start), int(stop)),
                    float(way[start]),
                )
            )
    longest = max((float(motion.displacement[-1]) for motion in motions), default=0.0)
    return sorted(
        (motion for motion in motions if motion.displacement[-1] >= LONG * longest),
        key=lambda motion: -motion.displacement[-1],
    )


@shown(
    "reversals",
    ("at_samples", "distance"),
    "Friction in the direction of motion over the displacement after reversals, measured and modelled",
    applies=lambda fit, distance: (
        distance > 0.0 and bool(reversals_of(fit.traces.time, fit.traces.velocity))
    ),
)
def friction_after_reversals(fit: Fit, distance: float = 0.0, *, large: bool = False) -> Figure:
    """Return friction over the displacement after reversals, measured and modelled, with the distance of 95 % of the change.

    Parameters
    ----------
    fit : Fit
        A model and its traces; best at each sample of the log, because a reversal lasts a few samples.
    distance : float
        Distance after a reversal over which friction makes 95 % of its change [m or rad]; 0 if unknown.
    large : bool
        Whether it is the large picture of a log without sliding.
    """
    if not hasattr(fit, "traces"):
        raise InputError(
            "must be a model with its traces",
            path="fit",
            value=fit,
            mend="Give br.identify(...).best",
        )
    traces, kind = fit.traces, fit.plant.kind
    distance = DISTANCE(distance, "distance", kind)
    size: style.Look = {"height": TALL} if large else {"height": LOW, "across": SIDE}
    figure, ((axes,),) = style.panels(right=style.room_for(["measured"]), top=0.12, **size)
    motions = reversals_of(traces.time, traces.velocity)
    longest = float(motions[0].displacement[-1]) if motions else 1.0
    end = min(longest, WAY * distance) if distance else longest
    # The slowest reversals have the most rows within the distance.
    chosen = sorted(motions, key=lambda reversal: -np.count_nonzero(reversal.displacement <= end))[
        :MOST_REVERSALS
    ]
    length = style.scale_for("length", kind, np.array([end]))
    scale, word = style.effort_scale(kind, traces.friction)
    modelled = traces.friction - traces.residual
    for values, look, name in ((traces.friction, PALE, "measured"), (modelled, THIN, "model")):
        x, y = [np.empty(0)], [np.empty(0)]
        for reversal in chosen:
            inside = np.flatnonzero(reversal.displacement <= 1.02 * end)
            drawn = (
                inside[style.envelope(values[reversal.rows][inside], 60)] if inside.size else inside
            )
            x += [reversal.displacement[drawn] * length.factor, np.array([np.nan])]
            y += [reversal.way * values[reversal.rows][drawn] * scale.factor, np.array([np.nan])]
        axes.plot(np.concatenate(x), np.concatenate(y), label=name, **look)
    if 0.0 < distance < end:
        axes.axvline(distance * length.factor, **style.DOTTED)
        axes.text(
            distance * length.factor,
            0.02,
            " 95 %",
            transform=axes.get_xaxis_transform(),
            color=style.INK,
        )
    axes.axhline(0.0, **style.AID)
    axes.set(
        xlabel=length.label("Displacement after a reversal"),
        ylabel=scale.label(f"Friction {word.lower()}"),
        xlim=(0.0, end * length.factor),
    )
    style.label_lines(axes)
    return figure


def is_presliding(fit: Fit, distance: float) -> bool:
    """Return whether each motion of a log ends near the distance over which friction builds up, so that velocity tells little."""
    motions = reversals_of(fit.traces.time, fit.traces.velocity)
    return bool(motions) and (fit.never_slid or float(motions[0].displacement[-1]) < WAY * distance)
