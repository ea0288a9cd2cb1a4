"""The report of a trial: one picture of the result, all of its numbers, and its limits."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from bristle.apps.paper.robust import findings
from bristle.apps.paper.robust.loops import CHOSEN, PRINTED, VARIANTS
from bristle.apps.paper.robust.trial import Trial
from bristle.apps.paper.robust.truths import CONDITIONS
from bristle.core import number
from bristle.report.cards import Card, Step
from bristle.report.figures.loop_rows import Spread, errors_by_truth
from bristle.report.page import Block, Front, Picture, Ruling, Section, about, page_of, picture
from bristle.report.table import Table

HEADING = "Compensation on other frictions"
SIMULATED = "The loops are simulated, without a real machine."
PIPELINE = (
    "One pipeline for all: a log of the loop without compensation, a Maxwell-slip model identified from it, "
    "feedforward along the desired motion, and an observer. Changes come afterwards, without another identification."
)
FAMILIES = (
    "Each family is identified from the same log by bristle identify. Feedforward acts on the unchanged rig. "
    "The family `printed` is equations (5) to (7): identified over the position, as in the paper, and driven by z. "
    "A star marks a family with the structure of the simulated friction or of a limit of it, which a user at a machine "
    "cannot expect."
)
LIMITS = (
    "The simulated frictions are equations with chosen numbers; real contacts wear, warm up and vary along the axis.",
    "Inertia, delay and encoder are known exactly; gains are not tuned for any friction.",
)


def words_of(trial: Trial) -> list[str]:
    """Return the results in sentences: the removed share of the error, by truth."""
    sentences = []
    for place in trial.plan.sets:
        lines = [
            _taken_off(
                trial, place, "feedforward", CHOSEN, f"{findings.LOOPS['feedforward']} removes"
            ),
            _taken_off(
                trial,
                place,
                "feedforward",
                PRINTED,
                "feedforward of equations (5)–(7) as printed removes",
            ),
            _taken_off(
                trial,
                place,
                findings.TOGETHER,
                CHOSEN,
                "model feedforward and observer together remove",
            ),
        ]
        sentences += [f"{findings.SET_NAMES[place]}: {line}" for line in lines if line]
        names = findings.no_better(trial, place)
        if names:
            sentences.append(
                f"{findings.SET_NAMES[place]}: on {len(names)} of {len(trial.plan.truths)} frictions ({', '.join(names)}) the observer "
                "alone is as accurate as both."
            )
    return sentences


def _taken_off(trial: Trial, place: str, variant: str, family: str, subject: str) -> str:
    """Return the removed share of the error of a loop, in a sentence; empty without a simulation."""
    names = [truth.name for truth in trial.plan.truths]
    shares = [
        100.0 * (1.0 - findings.share_left(trial, place, name, variant, family)) for name in names
    ]
    finite = [share for share in shares if math.isfinite(share)]
    if not finite:
        return ""
    errors = [findings.error_of(trial, place, name, variant, family=family) for name in names]
    means = [1e6 * error.peak_to_peak for error in errors if error is not None]
    leaving = "leave"
    if subject.endswith("removes"):
        leaving = "leaves"
    return f"{subject} {_range(finite, 10.0)} % of the error, depending on the friction, and {leaving} {_range(means, 0.1)} µm."


def _range(values: Sequence[float], resolution: float) -> str:
    """Return the smallest and the largest number as text; a single number if they round to the same."""
    low, high = (number(end, resolution=resolution) for end in (min(values), max(values)))
    if low == high:
        return low
    return f"{low} to {high}"


def ruling_of(trial: Trial) -> Ruling:
    """Return the verdict on the claims."""
    listed = [
        (place, claim) for place in trial.plan.sets for claim in findings.claims(trial, place)
    ]
    missed = [(place, claim) for place, claim in listed if not claim.holds]
    if not missed:
        return Ruling(
            "usable", "The claims for observer and feedforward hold for every tested friction"
        )
    reasons = []
    for place, claim in missed:
        errors = [
            f"{case} {findings.tenths(error)} µm"
            for case, error in claim.errors.items()
            if error > claim.limit
        ]
        reasons.append(
            f"{findings.SET_NAMES[place]}, above {findings.tenths(claim.limit)} µm: {', '.join(errors)}"
        )
    words = "The claims for observer and feedforward do not hold everywhere"
    if len(missed) < len(listed):
        return Ruling("with_care", words, tuple(reasons))
    return Ruling("no", words, tuple(reasons))


def robust_report(trial: Trial, *, command: str, provenance: Mapping[str, str]) -> str:
    """Return the report as one HTML page."""
    plan = trial.plan
    conditions = [(condition, CONDITIONS[condition].words) for condition in plan.conditions]
    unfitted = [
        f"{family} on {truth}: {fit.reason}"
        for (truth, family), fit in trial.fits.items()
        if fit.friction is None
    ]
    tables = [findings.error_table(trial, place) for place in plan.sets]
    margins = findings.margin_table(findings.margins_of_sets(plan.sets))
    described = Table(
        "Conditions, unknown to every compensator", ("Condition", "The rig"), conditions
    )
    families = [
        findings.best_table(trial),
        *(findings.family_table(trial, place) for place in plan.sets),
    ]
    missing = []
    if unfitted:
        missing = ["Not identified:", Block("items", unfitted)]
    sections = [
        Section("claims", "Claims under test", [findings.claim_table(trial)], "Claims"),
        Section(
            "table",
            "Following error",
            [PIPELINE, Block("items", words_of(trial)), *tables, described, margins],
        ),
        Section(
            "families", "Families of compensators", [FAMILIES, *families, *missing], "Families"
        ),
        Section("limits", "Limits of this study", [Block("items", LIMITS)], "Limits"),
    ]
    return page_of(
        _front(trial), sections, command=command, provenance=provenance, banner=SIMULATED
    )


def _front(trial: Trial) -> Front:
    facts = about(
        "simulated loops", f"{len(trial.plan.truths)} frictions", f"{trial.plan.seeds} runs each"
    )
    listed = [
        (place, claim) for place in trial.plan.sets for claim in findings.claims(trial, place)
    ]
    worst = [
        (f"{findings.SET_NAMES[place]}, worst case", max(claim.errors.values()), claim.limit)
        for place, claim in listed
    ][:4]
    title = "No claim tested"
    if worst:
        title = f"Observer and feedforward: at most {findings.tenths(max(error for _, error, _ in worst))} µm"
    cards = [
        Card(label, f"{findings.tenths(error)} µm", f"limit {findings.tenths(limit)} µm")
        for label, error, limit in worst
    ]
    step = Step.of("try your own friction: `bristle paper --robust model.toml`")
    return Front(
        HEADING,
        facts,
        ruling_of(trial),
        title,
        "(peak to peak, simulated)",
        cards,
        step,
        figures=[_picture(trial)],
    )


def _picture(trial: Trial) -> Picture:
    """Return the error of each loop on each truth, and its range under all conditions."""
    errors = {
        findings.SET_NAMES[place]: {
            truth.name.replace("_", " "): {
                findings.LOOPS[variant]: _spread(trial, place, truth.name, variant)
                for variant in VARIANTS
            }
            for truth in trial.plan.truths
        }
        for place in trial.plan.sets
    }
    alternative = "Following error peak to peak of each loop on each friction, and its range under all conditions"
    caption = (
        f"{alternative}. Marks: the mean without changes; wide lines: its 95 % interval; thin lines: from the "
        "smallest to the largest mean under changes of level, scatter, place or creep, without another identification."
    )
    return picture(
        "robust",
        lambda: errors_by_truth(
            errors, 1e6 * findings.ON_ALL_TRUTHS, "Following error [µm]", "0.5 µm"
        ),
        alternative,
        caption,
        file="robust",
        published=f"{caption} {SIMULATED}",
    )


def _spread(trial: Trial, place: str, truth: str, variant: str) -> Any:
    errors = [
        findings.error_of(trial, place, truth, variant, condition)
        for condition in trial.plan.conditions
    ]
    means = [
        1e6 * error.peak_to_peak
        for error in errors
        if error is not None and math.isfinite(error.peak_to_peak)
    ]
    nominal = errors[0] or findings.Interval(math.nan, math.nan, math.nan, math.nan, 0)
    error, low, high, *_ = (1e6 * end for end in nominal)
    return Spread(error, low, high, min(means, default=math.nan), max(means, default=math.nan))


def robust_summary(trial: Trial, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the results in numbers, lengths in m."""
    return {
        "verdict": ruling_of(trial).as_data(),
        "sentences": words_of(trial),
        **findings.numbers(trial),
        "margins": findings.margins_of_sets(trial.plan.sets),
        "chosen_family": CHOSEN,
        "provenance": provenance,
    }
