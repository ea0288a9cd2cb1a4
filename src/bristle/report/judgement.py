"""Whether an identified model can be used, and why, in the word that a person looks for; and what to measure next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core import unit_of
from bristle.report.page import Ruling
from bristle.report.sentences import SENTENCES
from bristle.report.table import fixed, length_text, percent_text

if TYPE_CHECKING:
    from bristle.identification import Fit, Settings
    from bristle.prediction import Following

LEVELS = {"usable": "Usable", "with_care": "Use with care", "measure_again": "Measure again"}  # the words of each level
# Codes that doubt a record, or the model on it, rather than a single parameter; the gravest first.
DOUBTS = (
    "structure",
    "stages_differ",
    "filter_suspect",
    "delay_or_filter",
    "delay_unknown",
    "delay_rough",
    "rows_lost",
    "unit_suspect",
    "weight_guessed",
    "velocity_contradicts",
    "clipped",
    "saturates",
    "scale_steps",
    "high_passed",
    "reference_recorded",
    "beyond_limit",
    "resolution_contradicts",
    "mass_contradicts",
    "gear_suspect",
    "sign_reversed",
    "effort_unsigned",
    "level_drifts",
    "level_over_position",
    "one_direction",
    "one_speed",
    "never_slides",
    "below_resolution",
)
WRITTEN_BY = " Written by: "  # between the motion that is needed and the command for it

# The motion that is needed, and the purposes of `bristle excite --for` that give it.
ADVICE = {
    "sliding": ("Move in both directions, at least ten reversals, each with a stretch of steady motion after it.", "stribeck"),
    "speed": ("Move at several steady speeds between a tenth and all of the working speed, in both directions.", "stribeck"),
    "stribeck": (
        "Move slowly and steadily, in both directions: at least five speeds below the one at which friction is least, "
        "down to where the axis begins to stick.",
        "stribeck",
    ),
    "presliding": (
        "Reverse gently and often, at amplitudes of the break-away distance and below (slow triangles of a few "
        "encoder counts to some ten times that), sampled so that a reversal lasts at least fifty samples.",
        "presliding,break-away,damping",
    ),
    "displacement": (
        "Move at several amplitudes, up to the largest that matters and through the resonance if there is one, so that "
        "the force yields or hardens visibly.",
        "",
    ),
    "acceleration": ("Accelerate harder, or weigh the moving mass and give it in the axis file.", "stribeck"),
}


def misfit(fit: Fit) -> list[str]:
    """Return how far off a fit is: on what it was fitted to, and on what it was not."""
    kind = fit.plant.kind
    if fit.position_rmse is not None:
        quality = f"misses the position of the log by {length_text(fit.position_rmse, kind)}"
    elif fit.loop_rmse is not None:
        quality = f"misses the effort of the loop by {fixed(fit.loop_rmse, unit_of('force', kind))}"
    else:
        quality = f"misses {percent_text(fit.force_error_percent)} of the effort of the log, "
        quality += f"{percent_text(fit.friction_alone_error_percent)} of what friction takes"
    held_out = "nothing was held out"
    if fit.held_out is not None:
        held_out = f"on {fit.held_out.of} that it was not fitted to: {percent_text(fit.held_out.mean_percent)}"
        # Ratio of held-out to fitted error from which the page says so.
        if fit.held_out.mean_percent > 1.25 * fit.error_percent:
            held_out += ", clearly larger: too free a model for this log, or friction that changed"
    return [quality, held_out]


def judged(fit: Fit, settings: Settings, following: Following | None = None) -> Ruling:
    """Return whether a fit is usable, to be used with care, or no reason to type anything into a drive.

    It takes another record where the log contradicts itself, no level of friction is identified, or the model misses most
    of what friction takes. It takes care where anything is doubted that the force along a motion like this one stands on.
    """
    misses = f"the model misses {_error(fit):.3g} % of what friction takes"
    grave = [SENTENCES[doubt.code].means for doubt in fit.diagnostics if doubt.severity == "error"]
    sought = [estimate for estimate in fit.estimates if estimate.status != "held"]
    unknown = [estimate for estimate in sought if estimate.status != "identified"]
    levels = [estimate for estimate in unknown if estimate.name in fit.levels]
    if levels and len(levels) == len(fit.levels) and any(level.matters for level in levels):
        grave.append(f"the level of friction is not identified: {', '.join(fit.levels)}")
    grave += [misses] if _error(fit) > settings.useless_error else []
    doubted = {doubt.code: doubt for doubt in fit.diagnostics if doubt.severity == "warning"}
    doubts = []
    for doubt in (doubted[code] for code in DOUBTS if code in doubted):
        causes = doubt.numbers.get("causes")
        doubts.append(SENTENCES[doubt.code].means + (f": {', '.join(map(str, causes))}" if isinstance(causes, tuple) else ""))
    matter = [estimate.name for estimate in unknown if estimate.matters]
    little = [estimate.name for estimate in unknown if not estimate.matters]
    rough = [estimate.name for estimate in sought if estimate.is_rough]
    doubts += [f"not identified: {', '.join(matter)}"] if matter else []
    doubts += [f"identified roughly: {', '.join(rough)}"] if rough else []
    doubts += [misses] if settings.usable_error < _error(fit) <= settings.useless_error else []
    if following is not None and following.contradiction is not None:
        doubts.append(SENTENCES[following.contradiction.code].means)
    level = "measure_again" if grave else "with_care" if doubts else "usable"
    remarks = [f"not identified, and of little effect on the force: {', '.join(little)}"] if little else []
    return Ruling(level, LEVELS[level], (*dict.fromkeys(grave), *doubts, *remarks))


def _error(fit: Fit) -> float:
    """Return how much the model misses, of what friction takes where it was fitted to the effort, noise apart [%]."""
    simulated = fit.position_rmse is not None or fit.loop_rmse is not None
    return fit.error_percent if simulated else fit.missed_percent


def next_measurements(fit: Fit) -> list[tuple[str, str]]:
    """Return which motion to record so that a log determines the parameters that this one did not."""
    variables = fit.plant.component.variables | fit.friction.component.variables
    open_: dict[str, list[str]] = {}
    for estimate in fit.estimates:
        if estimate.status in ("unidentifiable", "at_edge") and estimate.name in variables:
            open_.setdefault(variables[estimate.name].excitation, []).append(estimate.name)
    motions = {
        needed: text + (f"{WRITTEN_BY}`bristle excite AXIS.toml --for {purposes}`" if purposes else "")
        for needed, (text, purposes) in ADVICE.items()
    }
    return [(", ".join(names), motions[needed]) for needed, names in open_.items() if needed in motions]
