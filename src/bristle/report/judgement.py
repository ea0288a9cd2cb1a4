"""The verdict on an identified model with its reasons, and the next measurements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core import unit_of
from bristle.files import origins_of_code
from bristle.prediction import compensation_of, first_gain, level_values
from bristle.report.compensation import helped_text
from bristle.report.page import Ruling
from bristle.report.sentences import SENTENCES
from bristle.report.table import fixed, length_text, percent_text

if TYPE_CHECKING:
    from bristle.identification import Fit, Identification, Settings
    from bristle.prediction import Compensation, Following

# The words of each level.
LEVELS = {"usable": "Usable", "with_care": "Use with care", "measure_again": "Measure again"}
# Codes that concern a log or its model, not a single parameter; most severe first.
DOUBTS = (
    "unfinished",
    "elastic_load",
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
WRITTEN_BY = " Generate it with: "  # between the motion and its command

# The forces that a model lacks, by their cause.
LACKING = {
    "speed": "friction over speed",
    "direction": "friction by direction",
    "lag": "friction that lags the speed",
    "play": "play of the drive",
    "presliding": "pre-sliding",
}

# The required motion, and the purposes of `bristle excite --for` that generate it.
ADVICE = {
    "sliding": (
        "Move in both directions, with at least ten reversals. Add a constant-velocity segment after each reversal.",
        "stribeck",
    ),
    "speed": (
        "Move at several constant speeds, from a tenth of the working speed up to the working speed, in both directions.",
        "stribeck",
    ),
    "stribeck": (
        "Move slowly at constant speed, in both directions. Use at least five speeds below the speed of least friction, "
        "down to the speed at which the axis sticks.",
        "stribeck",
    ),
    "presliding": (
        "Reverse gently and often, at amplitudes up to the break-away distance, in slow triangles of a few to some ten encoder "
        "counts. Sample at least fifty times per reversal.",
        "presliding,break-away,damping",
    ),
    "displacement": (
        "Move at several amplitudes, up to the working stroke and through any resonance, until the stiffness visibly falls or rises.",
        "",
    ),
    "place": (
        "Move slowly through the whole range in both directions, so that the force of the load changes and turns round.",
        "",
    ),
    "acceleration": (
        "Accelerate harder, or weigh the moving mass and give it in the axis file.",
        "stribeck",
    ),
}


def misfit(fit: Fit) -> list[str]:
    """Return the model error of a fit and its held-out error."""
    kind = fit.plant.kind
    if fit.position_rmse is not None:
        quality = f"model error {length_text(fit.position_rmse, kind)} of the position"
    elif fit.loop_rmse is not None:
        quality = (
            f"model error {fixed(fit.loop_rmse, unit_of('force', kind))} of the effort in the loop"
        )
    else:
        quality = f"model error {percent_text(fit.force_error_percent)} of the effort, "
        quality += f"{percent_text(fit.friction_alone_error_percent)} of the friction"
    held_out = "no held-out stretches"
    if fit.held_out is not None:
        held_out = (
            f"held-out error {percent_text(fit.held_out.mean_percent)}, over {fit.held_out.of}"
        )
        # Smallest ratio of held-out to fitted error for a remark.
        if fit.held_out.mean_percent > 1.25 * fit.error_percent:
            held_out += ". This is clearly larger than the model error: the model has too many parameters for this log, or friction changed"
    return [quality, held_out]


def judged(fit: Fit, settings: Settings, following: Following | None = None) -> Ruling:
    """Return the verdict on a fit: usable, use with care, or measure again.

    Measure again if the log contradicts itself, no level of friction is identified, or the model error is most of the
    friction. Use with care if a doubt affects the force along similar motions.
    """
    misses = f"the model error is {_error(fit):.3g} % of the friction"
    grave = [SENTENCES[doubt.code].means for doubt in fit.diagnostics if doubt.severity == "error"]
    sought = [estimate for estimate in fit.estimates if estimate.status != "held"]
    unknown = [estimate for estimate in sought if estimate.status != "identified"]
    levels = [estimate for estimate in unknown if estimate.name in fit.levels]
    if levels and len(levels) == len(fit.levels) and any(level.matters for level in levels):
        grave.append(f"the level of friction is not identified: {', '.join(fit.levels)}")
    grave += [misses] if _error(fit) > settings.useless_error else []
    grave += [SENTENCES["one_direction"].means] if is_one_sided(fit) else []
    doubted = {doubt.code: doubt for doubt in fit.diagnostics if doubt.severity == "warning"}
    doubts = []
    for doubt in (doubted[code] for code in DOUBTS if code in doubted):
        causes = doubt.numbers.get("causes")
        named = [LACKING[str(cause)] for cause in causes] if isinstance(causes, tuple) else []
        doubts.append(f"{SENTENCES[doubt.code].means}{': ' * bool(named)}{', '.join(named)}")
    matter = [estimate.name for estimate in unknown if estimate.matters]
    little = [estimate.name for estimate in unknown if not estimate.matters]
    rough = [estimate.name for estimate in sought if estimate.is_rough]
    doubts += [f"not identified: {', '.join(matter)}"] if matter else []
    doubts += [f"roughly identified: {', '.join(rough)}"] if rough else []
    doubts += [misses] if settings.usable_error < _error(fit) <= settings.useless_error else []
    if following is not None and following.contradiction is not None:
        doubts.append(SENTENCES[following.contradiction.code].means)
    level = "measure_again" if grave else "with_care" if doubts else "usable"
    remarks = (
        [f"not identified, but with little effect on the force: {', '.join(little)}"]
        if little
        else []
    )
    return Ruling(level, LEVELS[level], tuple(dict.fromkeys((*grave, *doubts, *remarks))))


def feedforward_of(identification: Identification) -> str:
    """Return whether a feedforward of the best model is safe to try; of a plant with two masses, it is that of one mass."""
    # Saved results contain one mass only.
    of_one = getattr(identification, "two_masses", None) is not None
    return "of one mass: " * of_one + _feedforward_text(identification)


def _feedforward_text(identification: Identification) -> str:
    """Return whether a feedforward is safe to try, even if parameters are open, and which moves it improves."""
    fit = identification.best
    if fit.position_rmse is not None:
        return "not judged, because the model was fitted to the position"
    compensation = compensation_in(identification)
    if gain := first_gain(fit, compensation):
        helped = helped_text(
            compensation.claims, fit.friction.kind, "; beside acceleration feedforward it helps"
        )
        return f"safe to try at gain {gain:g}{helped}"
    faults = [
        doubt.code
        for doubt in fit.diagnostics
        if doubt.severity == "error" or doubt.code == "one_direction"
    ]
    error = f"the model error is {fit.friction_alone_error_percent:.3g} % of the friction"
    return f"do not try it: {SENTENCES[faults[0]].means if faults else error}"


def compensation_in(identification: Identification) -> Compensation:
    """Return how the best model is fed forward in the loop of its log; of the fits alone, without a simulation of the loop."""
    simulated = getattr(identification, "compensation", None)
    return simulated or compensation_of(
        identification.best.friction,
        getattr(identification, "axis", None),
        identification.treatment,
    )


def is_one_sided(fit: Fit) -> bool:
    """Return whether the level of friction is unknown in a direction."""
    levels = level_values(fit)
    return levels is not None and None in (levels.forward, levels.backward)


def ruling_of(identification: Identification, following: Following | None = None) -> Ruling:
    """Return the verdict on the best model of a log; with two encoders, on the friction of motor and load."""
    masses = identification.two_masses
    if masses is None or masses.load is None:
        return judged(identification.best, identification.settings, following)
    rulings = {name: judged(side.best, side.settings) for name, side in masses.sides.items()}
    reasons = [
        f"friction of the {name}: {reason}"
        for name, ruling in rulings.items()
        for reason in ruling.reasons
    ]
    levels = [ruling.level for ruling in rulings.values()]
    if following is not None and following.contradiction is not None:
        reasons.append(SENTENCES[following.contradiction.code].means)
        levels.append("with_care")
    level = max(levels, key=list(LEVELS).index)
    return Ruling(level, LEVELS[level], tuple(reasons))


def level_of(identification: Identification) -> str:
    """Return the level of the verdict on a log."""
    return ruling_of(identification).level


def _error(fit: Fit) -> float:
    """Return the model error without noise, relative to friction if the model was fitted to the effort [%]."""
    simulated = fit.position_rmse is not None or fit.loop_rmse is not None
    return fit.error_percent if simulated else fit.missed_percent


def next_measurements(fit: Fit) -> list[tuple[str, str]]:
    """Return the motions to record for the parameters that this log did not determine."""
    variables = fit.plant.component.variables | fit.friction.component.variables
    open_: dict[str, list[str]] = {}
    for estimate in fit.estimates:
        has_motion = estimate.reason is not None and estimate.reason.code in (
            "small_effect",
            "coarse_position",
        )
        if (
            estimate.status in ("unidentifiable", "at_edge")
            and estimate.name in variables
            and not has_motion
        ):
            open_.setdefault(variables[estimate.name].excitation, []).append(estimate.name)
    motions = {
        needed: text
        + (f"{WRITTEN_BY}`bristle excite AXIS.toml --for {purposes}`" if purposes else "")
        for needed, (text, purposes) in ADVICE.items()
    }
    return [
        (", ".join(names), motions[needed]) for needed, names in open_.items() if needed in motions
    ]


def comparison_with(fit: Fit, models: list[str]) -> str:
    """Return the option that compares a model with others: after it, bristle proposes none of them again."""
    # The name of a user's model names no file.
    own = [] if origins_of_code([fit.friction.component]) else [fit.name]
    return f"--model {','.join(dict.fromkeys([*own, *models]))}"
