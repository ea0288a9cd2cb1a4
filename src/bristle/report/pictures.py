"""The figures of an identification, each with a caption that says what to see."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from bristle.report.log import passages_picture
from bristle.report.page import Picture, picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.identification.result import Identification
    from bristle.logs.passage import Passage
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult

__all__ = ["identification_pictures"]

# For each figure: what it is, and what to see in it.
CAPTIONS = {
    "first": ("Friction over velocity", "Friction over velocity, measured and modelled."),
    "parameters": (
        "95 % interval of each parameter in percent of its value",
        "95 % intervals in percent of each value, on a scale that is linear within ± 1 % and logarithmic beyond. "
        "Dashed: not identified by this log. Hollow square: held.",
    ),
    "drive": (
        "Entries of the drive table over the friction curve",
        "The entries of the table, joined by straight lines as a drive joins them, over the steady friction of the "
        "model. Where the two part, the drive would need more entries.",
    ),
    "time": (
        "Measured and predicted effort over time",
        "Effort over the whole log, and close up where measured and predicted effort differ most (shaded above). "
        "Where the light line looks out from under the dark one, the model misses something.",
    ),
    "velocity": (
        "Friction over velocity, measured and modelled",
        "Effort less inertia, over velocity. Points of speeding up and slowing down that lie apart at one velocity "
        "are friction that depends on more than velocity. Near standstill the filter smears the step between the "
        "two directions.",
    ),
    "residuals": (
        "Residuals over time, their distribution and autocorrelation",
        "What the model leaves over. Bursts at reversals point to friction before sliding, a drift to temperature or "
        "load. Bars of the autocorrelation outside the band mean that neighbouring residuals are alike: then standard "
        "errors, which take them for independent, are too small.",
    ),
    "correlation": (
        "Correlation between the estimates of the parameters",
        "Correlation of the estimates; darker is stronger. Near ± 1 the log knows a combination of two parameters "
        "better than either of them.",
    ),
    "comparison": (
        "Error of each model on what was held out",
        "Each stroke is one time block, or of several logs one, that the model was not fitted to. Models whose strokes "
        "overlap are about equally good here: then the simpler one is the safer choice.",
    ),
}


WITH_LOOP = (
    "Friction over velocity, and the following error at its worst reversal",
    "Above, friction measured and modelled. Below, the following error around its worst reversal: measured, simulated "
    "as recorded, and compensated.",
)
"""The same of the first figure, where the log has a loop."""


def identification_pictures(
    identification: Identification, table: Sequence[tuple[float, float]], curve: Sequence[tuple[float, float]],
    segments: Sequence[Passage], simulation: SimulationResult | None = None, following: Following | None = None,
) -> dict[str, Picture]:  # fmt: skip
    """Return the figures of an identification by name.

    Parameters
    ----------
    identification : Identification
        Models fitted to a log, best first.
    table : sequence of (velocity, effort)
        Table for the drive [m/s or rad/s, N or N*m]; empty for none.
    curve : sequence of (velocity, effort)
        The same, finer.
    segments : sequence of Passage
        What the log contains.
    simulation : SimulationResult, optional
        The loop as it is and compensated.
    following : Following, optional
        How the axis followed its reference in the log.
    """
    from bristle import figures

    fit = identification.best
    draw: dict[str, Callable[[], Figure]] = {
        "first": lambda: figures.first_page(fit, curve, simulation, following.error if following else None),
        "parameters": lambda: figures.parameters(fit),
        "time": lambda: figures.effort_over_time(fit),
        "velocity": lambda: figures.friction_over_velocity(fit, curve),
        "residuals": lambda: figures.residuals(fit),
    }
    if table:
        draw["drive"] = lambda: figures.drive_table(table, curve, fit.plant.kind)
    if len(fit.correlation_names) > 1:
        draw["correlation"] = lambda: figures.correlation(fit)
    if len(identification.fits) > 1:
        draw["comparison"] = lambda: figures.model_comparison(identification)
    captions = CAPTIONS | ({"first": WITH_LOOP} if simulation is not None else {})
    drawn = {name: picture(name, drawing, *captions[name]) for name, drawing in draw.items()}
    return drawn | {"passages": passages_picture(identification.log, segments)}
