"""Figures of a loop design: the open loop with margins and poles, the proposed loops, and the circle of two axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from bristle.core import Kind, number, unit_of
from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.bars import draw_bars
from bristle.report.figures.drawing import AT_TICKS, label
from bristle.report.figures.report_figure import shown

if TYPE_CHECKING:
    from bristle.apps.design import Assessment, Circle


LOWEST = 0.003  # of the Nyquist frequency
NAMES = {"all": "all motions", "small": "small motions", "large": "large motions"}


@shown(
    "margins",
    "assessment",
    "Gain and phase of the open loop over frequency, and the poles of the closed loop",
    "The open loop without friction, and the phase margin where its gain crosses 1 (thick). Poles outside the "
    "unit circle are unstable. Poles just inside it ring.",
)
def margins(assessment: Assessment) -> Figure:
    """Return gain and phase of the open loop without friction, with the margins, and the poles of the closed loop."""
    # The unit circle must be round: its panel is as wide as both rows are tall.
    figure, grid = style.panels(3.9, rows=2, columns=2, widths=(1.25, 1.0), gap=0.28, between=0.72)
    (gain, poles), (phase, rest) = grid
    rest.remove()
    poles.set_subplotspec(poles.get_gridspec()[:, 1])  # type: ignore[union-attr]
    angle = np.linspace(0.0, 2.0 * math.pi, 200)
    poles.plot(np.cos(angle), np.sin(angle), **style.AID)
    poles.set_aspect("equal", adjustable="datalim")
    poles.set_xlabel("Poles, real part")
    poles.set_ylabel("imaginary part", labelpad=1.0)
    poles.margins(0.06)
    for look, point in zip(style.SERIES[1:], assessment.bare, strict=False):
        line = {key: look[key] for key in ("color", "linestyle", "linewidth")}
        at = point.loop.poles
        nyquist = math.pi / point.loop.sample_time
        poles.plot(
            np.real(at),
            np.imag(at),
            look["marker"],
            color=look["color"],
            fillstyle="none",
            label=f"_{NAMES[point.motions]}",
        )
        omega = np.geomspace(LOWEST * nyquist, nyquist, 600)
        response = point.loop.response(omega)
        hertz = omega / (2.0 * math.pi)
        gain.loglog(hertz, np.abs(response), label=NAMES[point.motions], **line)
        # Continued from its start between -90 and -270 degrees, and drawn once around.
        turned = np.unwrap(np.angle(response))
        turned -= 2.0 * math.pi * round((turned[0] + math.pi) / (2.0 * math.pi))
        phase.semilogx(hertz, np.degrees(turned), label=f"_{NAMES[point.motions]}", **line)
        margin = point.margins.phase
        crossover = point.margins.crossover
        if margin is not None and crossover is not None:
            at = crossover / (2.0 * math.pi)
            phase.plot(
                [at, at],
                [-180.0, margin - 180.0],
                color=look["color"],
                linewidth=2.6,
                solid_capstyle="butt",
                label="_phase margin",
            )
            gain.plot(
                at,
                1.0,
                marker=look["marker"],
                color=look["color"],
                markersize=style.SMALL,
                label="_crossover",
            )
    gain.axhline(1.0, **style.AID)
    phase.axhline(-180.0, **style.AID)
    gain.set_ylabel("Open loop, gain")
    phase.set(ylabel="Phase [°]", xlabel="Frequency [Hz]")
    style.plain_numbers(gain.yaxis, phase.xaxis)
    gain.tick_params(labelbottom=False)
    gain.set_ylim(bottom=0.03)
    phase.set(ylim=(-360.0, -60.0), yticks=[-360.0, -270.0, -180.0, -90.0])
    style.legend(gain, columns=2)
    return figure


@shown(
    "loops",
    ("design", "names", "phases", "enough"),
    "Following error, effort and smallest phase margin of the present loop and of the proposed loops",
    "Blue: proposed.",
    draw=lambda draw, design, names, phases, enough: draw(
        names,
        [
            None if loop.following_error is None else loop.following_error.peak_to_peak
            for loop in design.proposals
        ],
        [loop.effort_rms for loop in design.proposals],
        phases,
        enough,
        design.experiment.kind,
    ),
)
def loops_proposed(
    names: Sequence[str],
    errors: Sequence[float | None],
    efforts: Sequence[float | None],
    phases: Sequence[float | None],
    enough: float,
    kind: Kind = "translational",
) -> Figure:
    """Return bars of the error, the effort and the least phase margin of each loop: the present loop grey, the others blue."""
    figure, row = style.named_rows(
        names, max(style.PAIR, min(1.2, 3.5 / len(names))), style.NARROW, 3, between=0.2
    )
    columns = [
        [np.nan if value is None else value for value in side] for side in (errors, efforts, phases)
    ]
    units = (unit_of("length", kind), unit_of("force", kind), "")
    labels = ("Error, p-p", f"{style.effort_word(kind)}, rms", "Phase margin [°]")
    colors = [LIGHT["without"], *[LIGHT["with"]] * (len(names) - 1)]
    for axes, values, unit, text in zip(row, columns, units, labels, strict=True):
        draw_bars(axes, values, unit, text, colors)
        axes.set_ylabel("Loop", visible=axes is row[0])  # column head of the numbers of each panel
    row[-1].axvline(enough, **style.DASHED)
    row[-1].set_title(f"dashed: usual least, {enough:g}°")
    return figure


QUARTERS = (0.0, 90.0, 180.0, 270.0, 360.0)  # degrees


@shown(
    "circles",
    ("circles", "kind"),
    "Radial deviation of the circle, around it and unrolled",
    "Deviation of the two axes from the circle, magnified, around the grey circle on the left. At each of the four "
    "reversals friction changes its sign, and the path bulges.",
)
def circles(curves: Sequence[Circle], kind: Kind) -> Figure:
    """Return the radial deviation of circles of one radius and feed over the angle: around the round circle, and unrolled."""
    scale = style.scale_for(
        "length", kind, np.array([1e-6]), *(circle.deviation for circle in curves)
    )
    low, high = (
        scale.factor * float(edge([0.0, *(edge(circle.deviation) for circle in curves)]))
        for edge in (np.min, np.max)
    )
    span = max(high - low, 1e-12)
    figure, (row,) = style.panels(
        4.3, columns=2, between=0.9, names=[circle.variant for circle in curves], over_titles=True
    )
    specs: Any = [axes.get_subplotspec() for axes in row]
    figure.clear()
    round_: Any = figure.add_subplot(specs[0], projection="polar")
    unrolled = figure.add_subplot(specs[1])
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    round_.plot(turn, np.zeros_like(turn), **style.AID)
    for look, circle in zip(style.LINES, curves, strict=False):
        angle, deviation = style.line(circle.angle, circle.deviation)
        round_.plot(angle, deviation * scale.factor, label=f"_{label(circle.variant)}", **look)
        unrolled.plot(
            np.degrees(angle), deviation * scale.factor, label=label(circle.variant), **look
        )
    round_.set_ylim(low - span, high + 0.05 * span)
    step = float(f"{0.4 * span:.1g}")
    ticks = [0.0, step]
    if -low > high:
        ticks = [-step, 0.0]
    round_.set_yticks(ticks, [""] * len(ticks))
    for tick in ticks:
        # Above the lines: the ticks of the axis would lie below them.
        box = {"facecolor": LIGHT["ground"], "edgecolor": "none", "pad": 0.6, "alpha": 0.9}
        round_.text(
            0.25 * np.pi,
            tick,
            number(tick, digits=1),
            ha="center",
            va="center",
            fontsize=AT_TICKS,
            bbox=box,
            zorder=5,
        )
    round_.set_thetagrids(QUARTERS[:-1])
    round_.spines["polar"].set_visible(False)
    round_.set_title(scale.label("Deviation from the circle"), loc="left", pad=12.0)
    unrolled.set(
        xticks=QUARTERS,
        xlabel="Angle [°]; an axis reverses at each tick",
        ylabel=scale.label("Deviation"),
    )
    style.legend(unrolled)
    return figure
