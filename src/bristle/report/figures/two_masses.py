"""The pictures of an axis with two masses: forces and friction of motor and load, lost motion, and the frequency response of the motor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.report.figures import style
from bristle.report.figures.first_screen import (
    CELLS,
    LOW,
    SIDE,
    TALL,
    WITH,
    draw_friction,
    draw_pair,
)
from bristle.report.figures.report_figure import shown
from bristle.simulation import worst_reversal

if TYPE_CHECKING:
    from bristle.identification import Fit, Identification

POINT: style.Look = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 1.6,
    "color": style.MEASURED["color"],
}
LARGE_POINT: style.Look = POINT | {"markersize": 2.4}
COHERENT = 0.5  # smallest coherence of a frequency that is drawn


@shown(
    "sides",
    "both_sides",
    "Measured and modelled force on the motor and on the load at the reversal with the largest change; below, the whole log of the load",
)
def force_of_both_sides(identification: Identification) -> Figure:
    """Return measured and modelled effort of motor and load at the reversal with the largest change, over the whole log of the load."""
    masses = identification.two_masses
    assert masses is not None
    heights = (1.8, 1.8, 0.7)
    figure, rows = style.panels(
        TALL, rows=3, heights=heights, right=style.room_for(["measured"]), gap=0.62, top=0.25
    )
    loads = masses.sides["load"].best.traces
    part = worst_reversal(np.cumsum(loads.velocity), loads.measured) or style.window(
        loads.time, loads.residual, 0.05
    )
    ends, (motor, load, strip) = loads.time[part][[0, -1]], [axes for (axes,) in rows]
    for axes, (name, side) in zip((motor, load), masses.sides.items(), strict=True):
        traces, kind = side.best.traces, side.best.plant.kind
        scale, word = style.effort_scale(kind, traces.measured, traces.predicted)
        inside = slice(*np.searchsorted(traces.time, ends).tolist())
        draw_pair(
            axes,
            strip if name == "load" else None,
            traces.time,
            (traces.measured, traces.predicted),
            inside,
            scale=scale,
            word=word,
        )
        rest = (
            f": {word.lower()} of the coupling"
            if name == "load"
            else f": {word.lower()} minus that of the coupling"
        )
        style.title(axes, f"{name.capitalize()}{rest}")
    return figure


@shown(
    "frictions",
    ("both_sides", "curves"),
    "Friction of the motor and of the load over velocity, measured and modelled",
)
def friction_of_both_sides(
    identification: Identification, curves: Sequence[Sequence[tuple[float, float]]]
) -> Figure:
    """Return the friction of motor and load over velocity; `curves` are steady friction of both models."""
    masses = identification.two_masses
    assert masses is not None
    figure, (row,) = style.panels(
        LOW, columns=2, across=SIDE, right=style.room_for(["measured"]), top=0.25, between=0.75
    )
    for axes, (name, side), curve in zip(row, masses.sides.items(), curves, strict=True):
        draw_friction(axes, side.best, curve)
        style.title(axes, name.capitalize())
    style.label_lines(row[1])
    return figure


def shows_lost_motion(identification: Identification) -> bool:
    """Return whether both encoders show the deflection of the coupling."""
    masses = identification.two_masses
    return masses is not None and masses.is_elastic and not masses.rigid


@shown(
    "lost_motion",
    "both_sides",
    "Lost motion over the force of the coupling, measured and modelled",
    applies=shows_lost_motion,
)
def lost_motion(identification: Identification) -> Figure:
    """Return the lost motion, motor minus load, over the force of the coupling that the motor shows, and that of the stiffness and play."""
    masses = identification.two_masses
    assert masses is not None
    motor, load = masses.sides.values()
    traces, kind, of_motor = load.best.traces, load.best.plant.kind, motor.best.traces
    twist = np.interp(
        traces.time, load.log.time.values, motor.log.position.values - load.log.position.values
    )
    # Without a sensor, the measured force of the coupling comes from the twist: that of the motor is independent of it.
    extra = 0.0 if masses.measured else np.interp(traces.time, of_motor.time, of_motor.residual)
    force, pull, softness = (
        traces.measured + extra,
        traces.measured,
        1.0 / masses.by_name["stiffness"].value,
    )
    rest, half = (
        twist - pull * softness,
        0.5 * masses.by_name["play"].value if "play" in masses.by_name else 0.0,
    )
    twist = twist - 0.5 * (np.median(rest[pull > 0.0]) + np.median(rest[pull < 0.0]))
    ends = np.quantile(force, [0.0, 1.0])
    line = (
        np.array([ends[0], 0.0, 0.0, ends[1]]),
        np.array([ends[0] * softness - half, -half, half, ends[1] * softness + half]),
    )
    figure, ((axes,),) = style.panels(
        LOW, across=SIDE, right=style.room_for(["measured"]), top=0.12
    )
    scale, word = style.effort_scale(kind, force)
    length = style.scale_for("length", kind, twist)
    chosen = style.spread(force, twist, CELLS)
    axes.plot(
        force[chosen] * scale.factor, twist[chosen] * length.factor, label="measured", **POINT
    )
    axes.plot(line[0] * scale.factor, line[1] * length.factor, label="model", **WITH)
    axes.axhline(0.0, **style.AID)
    axes.axvline(0.0, **style.AID)
    axes.set(xlabel=scale.label(f"{word} of the coupling"), ylabel=length.label("Lost motion"))
    style.label_lines(axes)
    return figure


@shown(
    "response",
    ("fit", "elastic"),
    "Acceleration of the motor per force over frequency, with antiresonance and resonance",
)
def response_of_motor(fit: Fit, identification: Identification) -> Figure:
    """Return the frequency response of the motor of an elastic axis, with antiresonance and resonance."""
    response, facts = identification.response, identification.treatment
    assert response is not None
    kind = fit.plant.kind
    figure, ((axes,),) = style.panels(TALL, right=style.room_for(["measured"]), top=0.25)
    clear = response.coherence > COHERENT
    axes.plot(response.frequency[clear], response.gain[clear], label="measured", **LARGE_POINT)
    if response.modelled.size:
        axes.plot(response.frequency, response.modelled, label="model", **WITH)
    axes.set(xscale="log", yscale="log", xlabel="Frequency [Hz]")
    style.plain_numbers(axes.xaxis, axes.yaxis)
    axes.set_ylabel(
        f"Acceleration per {style.effort_word(kind).lower()} [1/{'kg' if kind == 'translational' else '(kg·m²)'}]"
    )
    for name, side in (("antiresonance", "right"), ("resonance", "left")):
        axes.axvline(facts[name], **style.DOTTED)
        axes.text(
            facts[name],
            1.02,
            f" {name} {facts[name]:.3g} Hz ",
            transform=axes.get_xaxis_transform(),
            color=style.INK,
            horizontalalignment=side,
        )
    style.label_lines(axes)
    return figure
