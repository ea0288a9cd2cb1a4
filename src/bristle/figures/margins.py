"""The open loop over frequency with its margins, and the poles of the closed one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from bristle.figures import style
from bristle.figures.report_figure import ReportFigure

if TYPE_CHECKING:
    from bristle.loop import Assessment, WorkingPoint

LOWEST = 0.003  # of the Nyquist frequency
NAMES = {"all": "all motions", "small": "small motions", "large": "large motions"}


@style.styled
def margins(assessment: Assessment) -> Figure:
    """Return gain and phase of the open loop without friction, with the margins, and the poles of the closed loop."""
    points = assessment.bare
    # The unit circle is to be round: its panel is as wide as both rows are tall.
    figure, grid = style.panels(3.9, rows=2, columns=2, widths=(1.25, 1.0), gap=0.28, between=0.72)
    (gain, poles), (phase, rest) = grid
    below = rest.get_position()
    rest.remove()
    above = poles.get_position()
    poles.set_position((above.x0, below.y0, above.width, above.y1 - below.y0))
    angle = np.linspace(0.0, 2.0 * math.pi, 200)
    poles.plot(np.cos(angle), np.sin(angle), **style.AID)
    poles.set_aspect("equal", adjustable="datalim")
    poles.set_xlabel("Poles, real part")
    poles.set_ylabel("imaginary part", labelpad=1.0)
    poles.margins(0.06)
    for look, point in zip(style.SERIES[1:], points, strict=False):
        _draw_open_loop(gain, phase, point, look)
        at = point.loop.poles
        poles.plot(np.real(at), np.imag(at), look["marker"], color=look["color"], fillstyle="none")
    gain.axhline(1.0, **style.AID)
    phase.axhline(-180.0, **style.AID)
    gain.set_ylabel("Open loop, gain")
    phase.set(ylabel="Phase [°]", xlabel="Frequency [Hz]")
    # The powers of ten that matplotlib writes are mathematics, which a page shows as it stands.
    for axis in (gain.yaxis, phase.xaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    gain.tick_params(labelbottom=False)
    gain.set_ylim(bottom=0.03)
    phase.set(ylim=(-360.0, -60.0), yticks=[-360.0, -270.0, -180.0, -90.0])
    style.legend(gain, columns=2)
    return figure


def _draw_open_loop(gain: style.Axes, phase: style.Axes, point: WorkingPoint, look: style.Look) -> None:
    line = {key: look[key] for key in ("color", "linestyle", "linewidth")}
    nyquist = math.pi / point.loop.sample_time
    omega = np.geomspace(LOWEST * nyquist, nyquist, 600)
    response = point.loop.response(omega)
    hertz = omega / (2.0 * math.pi)
    gain.loglog(hertz, np.abs(response), label=NAMES[point.motions], **line)
    # Continued from its start, which lies between -90 and -270 degrees, and drawn once around.
    turned = np.unwrap(np.angle(response))
    turned -= 2.0 * math.pi * round((turned[0] + math.pi) / (2.0 * math.pi))
    phase.semilogx(hertz, np.degrees(turned), **line)
    margin, crossover = point.margins.phase, point.margins.crossover
    if margin is not None and crossover is not None:
        at = crossover / (2.0 * math.pi)
        phase.plot([at, at], [-180.0, margin - 180.0], color=look["color"], linewidth=2.6, solid_capstyle="butt")
        gain.plot(at, 1.0, marker=look["marker"], color=look["color"], markersize=style.SMALL)


FIGURE = ReportFigure(
    name="margins",
    takes="assessment",
    draw=margins,
    alternative="Gain and phase of the open loop over frequency, and the poles of the closed loop",
    caption="The open loop without friction, and the phase margin where its gain crosses 1 (thick). Poles outside the "
    "circle grow; close inside it they ring.",
)
