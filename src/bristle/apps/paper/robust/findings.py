"""Results of a trial: means with intervals, the best family of each truth, the claims, and their tables."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.apps.paper.robust.loops import CHOSEN, VARIANTS, setting
from bristle.apps.paper.robust.trial import Cell, Trial
from bristle.apps.paper.robust.truths import NOMINAL, Truth
from bristle.apps.paper.tracking import least_margins
from bristle.core import number
from bristle.report.table import Table

LEVELS = (NOMINAL, "level_0.7", "level_1.3", "level_1.6")
OBSERVER = "observer"
TOGETHER = "observer_feedforward"
ON_ALL_TRUTHS = 0.50e-6  # [m]
SET_A = "set_a"


class Interval(NamedTuple):
    """A following error peak to peak over runs [m]."""

    peak_to_peak: float
    low: float
    high: float
    largest: float
    seeds: int


def interval(errors: Sequence[float] | np.ndarray) -> Interval:
    """Return the mean of errors with its 95 % interval.

    Examples
    --------
    >>> interval([1.0, 2.0, 3.0])
    Interval(peak_to_peak=2.0, low=-0.484..., high=4.484..., largest=3.0, seeds=3)
    """
    from scipy.special import stdtrit

    values = np.asarray(errors, dtype=float)
    mean = float(np.mean(values))
    half = math.nan
    if values.size > 1 and math.isfinite(mean):
        quantile = float(stdtrit(values.size - 1, 0.975))
        half = quantile * float(np.std(values, ddof=1)) / math.sqrt(values.size)
    return Interval(mean, mean - half, mean + half, float(np.max(values)), values.size)


def error_of(
    trial: Trial,
    place: str,
    truth: str,
    variant: str,
    condition: str = NOMINAL,
    family: str = CHOSEN,
) -> Interval | None:
    """Return the error of a loop, or None if it was not simulated."""
    if "feedforward" not in variant:
        family = ""
    errors = trial.errors.get(Cell(place, truth, condition, variant, family))
    if errors is None or not errors.size:
        return None
    return interval(errors)


def share_left(trial: Trial, place: str, truth: str, variant: str, family: str = CHOSEN) -> float:
    """Return the remaining share of the error without compensation, under nominal conditions; NaN if unknown."""
    before = error_of(trial, place, truth, "none")
    after = error_of(trial, place, truth, variant, family=family)
    if before and after:
        return after.peak_to_peak / before.peak_to_peak
    return math.nan


def best_family(trial: Trial, place: str, truth: Truth, *, strangers: bool = False) -> str:
    """Return the family with the smallest error with feedforward on a truth; empty without a fit."""
    families = [
        family for family in trial.plan.compensators if not (strangers and family in truth.families)
    ]
    errors = _peaks(
        {
            family: error_of(trial, place, truth.name, "feedforward", family=family)
            for family in families
        }
    )
    return min(errors, key=errors.__getitem__, default="")


def _peaks(errors: Mapping[str, Interval | None]) -> dict[str, float]:
    """Return the means of the known errors."""
    return {case: error.peak_to_peak for case, error in errors.items() if error is not None}


def no_better(trial: Trial, place: str) -> list[str]:
    """Return the truths on which observer and feedforward together are not significantly better than the observer alone."""
    names = []
    for truth in trial.plan.truths:
        alone, both = (
            error_of(trial, place, truth.name, variant) for variant in (OBSERVER, TOGETHER)
        )
        if alone is None or both is None:
            continue
        halves = [
            0.0 if math.isnan(one.low) else one.peak_to_peak - one.low for one in (alone, both)
        ]
        if not alone.peak_to_peak - both.peak_to_peak > math.hypot(*halves):
            names.append(truth.name)
    return names


class Claim(NamedTuple):
    """A claim on the table, and its result."""

    claim: str
    limit: float
    errors: Mapping[str, float]

    @property
    def holds(self) -> bool:
        """Whether every case is within the limit."""
        return all(error <= self.limit for error in self.errors.values())


def claims(trial: Trial, place: str = SET_A) -> list[Claim]:
    """Return the claims for observer and feedforward together, if the trial contains their cases."""
    first = "thirty_sliders"
    strangers = [truth.name for truth in trial.plan.truths if truth.name != first]
    levels = _peaks(
        {condition: error_of(trial, place, first, TOGETHER, condition) for condition in LEVELS}
    )
    strange = _peaks({name: error_of(trial, place, name, TOGETHER) for name in strangers})
    listed = [
        Claim(
            "observer and feedforward on the thirty sliders, at 0.7 to 1.6 times the level, without a refit",
            0.45e-6,
            levels,
        ),
        Claim(
            "observer and feedforward on every other friction, without changes",
            ON_ALL_TRUTHS,
            strange,
        ),
    ]
    return [claim for claim in listed if claim.errors]


def numbers(trial: Trial) -> dict[str, Any]:
    """Return the results for the summary, lengths in m."""
    plan = trial.plan
    return {
        **{
            ("robust" if place == SET_A else f"robust_{place}"): _table(trial, place)
            for place in plan.sets
        },
        "families": {
            truth.name: {family: _family(trial, truth, family) for family in plan.compensators}
            for truth in plan.truths
        },
        "best_family": {
            truth.name: {place: _best(trial, place, truth) for place in plan.sets}
            for truth in plan.truths
        },
        "observer_alone_does_as_well": {place: no_better(trial, place) for place in plan.sets},
        "claims": {
            place: [claim._asdict() | {"holds": claim.holds} for claim in claims(trial, place)]
            for place in plan.sets
        },
    }


def _table(trial: Trial, place: str) -> dict[str, Any]:
    return {
        truth.name: {
            condition: {
                variant: error._asdict()
                for variant in VARIANTS
                if (error := error_of(trial, place, truth.name, variant, condition)) is not None
            }
            for condition in trial.plan.conditions
        }
        for truth in trial.plan.truths
    }


def _family(trial: Trial, truth: Truth, family: str) -> dict[str, Any]:
    by_set = {
        place: error._asdict()
        | {"share_left": share_left(trial, place, truth.name, "feedforward", family)}
        for place in trial.plan.sets
        if (error := error_of(trial, place, truth.name, "feedforward", family=family)) is not None
    }
    return {
        "own_structure": family in truth.families,
        "reason": trial.fits[truth.name, family].reason,
    } | by_set


def _best(trial: Trial, place: str, truth: Truth) -> dict[str, Any]:
    family, stranger = (
        best_family(trial, place, truth, strangers=strangers) for strangers in (False, True)
    )
    own_left, stranger_left = (
        share_left(trial, place, truth.name, "feedforward", name) for name in (family, stranger)
    )
    return {
        "family": family,
        "share_left": own_left,
        "stranger": stranger,
        "stranger_share_left": stranger_left,
    }


SET_NAMES = {"set_a": "Set A", "set_c": "Set C"}
LOOPS = {
    "none": "no compensation",
    "feedforward": "model feedforward",
    "observer": "observer",
    "observer_feedforward": "both",
}
OWN = "*"
DIVERGED = "diverged"


def tenths(length: float) -> str:
    """Return a length as text, in tenths of a micrometre."""
    return number(1e6 * length, resolution=0.1)


def micrometres(error: Interval | None) -> str:
    """Return an error with its 95 % interval [µm] as text."""
    if error is None:
        return "–"
    if not math.isfinite(error.peak_to_peak):
        return DIVERGED
    mean, low, high = map(tenths, error[:3])
    if math.isnan(error.low):
        return mean
    return f"{mean} ({low} to {high})"


def error_table(trial: Trial, place: str) -> Table:
    """Return the following error of every loop of a set, truth by truth and condition by condition."""
    rows = [
        (
            truth.name,
            condition,
            *(micrometres(error_of(trial, place, truth.name, v, condition)) for v in VARIANTS),
        )
        for truth in trial.plan.truths
        for condition in trial.plan.conditions
    ]
    return Table(
        f"{SET_NAMES[place]}: following error peak to peak [µm], mean over {trial.plan.seeds} runs with different noise "
        "and scatter, and its 95 % interval",
        ("Friction of the rig", "Condition", *LOOPS.values()),
        rows,
    )


def claim_table(trial: Trial) -> Table:
    """Return the claims and their results."""
    rows = []
    for place in trial.plan.sets:
        for claim in claims(trial, place):
            worst, error = max(claim.errors.items(), key=lambda case: case[1])
            rows.append(
                (
                    f"{SET_NAMES[place]}: {claim.claim}",
                    tenths(claim.limit),
                    tenths(error),
                    worst,
                    "yes" if claim.holds else "no",
                )
            )
    heads = ("Claim", "At most [µm]", "Largest mean [µm]", "On", "Holds")
    return Table("Following error peak to peak", heads, rows)


def best_table(trial: Trial) -> Table:
    """Return the best family of each truth, and the best family with a different structure."""
    rows = []
    for truth in trial.plan.truths:
        for place in trial.plan.sets:
            best = _best(trial, place, truth)
            chosen = share_left(trial, place, truth.name, "feedforward", CHOSEN)
            left, stranger_left, chosen_left = map(
                _percent, (best["share_left"], best["stranger_share_left"], chosen)
            )
            own = best["family"]
            is_own = "no"
            if own in truth.families:
                is_own = "yes"
            rows.append(
                (
                    truth.name,
                    SET_NAMES[place],
                    own or "–",
                    is_own,
                    left,
                    best["stranger"] or "–",
                    stranger_left,
                    chosen_left,
                )
            )
    best_heads = (
        "Best family",
        "Has the structure of the simulated friction",
        "Remaining error [%]",
        "Best with another structure",
        "Its remaining error [%]",
    )
    heads = ("Friction of the rig", "Set", *best_heads, f"Remaining error of {CHOSEN} [%]")
    return Table("Families with the smallest remaining error with feedforward", heads, rows)


def family_table(trial: Trial, place: str) -> Table:
    """Return the remaining share of the error with feedforward of each family, truth by truth."""
    rows = []
    for family in trial.plan.compensators:
        shares = [
            (truth, _percent(share_left(trial, place, truth.name, "feedforward", family)))
            for truth in trial.plan.truths
        ]
        rows.append(
            (
                family,
                *(share + (OWN if family in truth.families else "") for truth, share in shares),
            )
        )
    return Table(
        f"{SET_NAMES[place]}: remaining error with feedforward [% of the error without compensation]; {OWN} if "
        "the family has the structure of the simulated friction",
        ("Family", *(truth.name for truth in trial.plan.truths)),
        rows,
    )


def _percent(share: float) -> str:
    if math.isnan(share):
        return "–"
    if math.isinf(share):
        return DIVERGED
    return number(100.0 * share, resolution=10.0)


def margins_of_sets(sets: tuple[str, ...]) -> dict[str, dict[str, dict[str, float]]]:
    """Return the smallest margins of the loops of each set, independent of friction: feedforward has no margin."""
    return {
        place: {
            name: dict(zip(("phase_deg", "gain"), least_margins(loop), strict=True))
            for name, loop in setting(place).items()
            if "feedforward" not in name
        }
        for place in sets
    }


def margin_table(margins: Mapping[str, Mapping[str, Mapping[str, float]]]) -> Table:
    """Return the margins of the loops."""
    rows = [
        (
            SET_NAMES[place],
            LOOPS[name],
            number(loop["phase_deg"], digits=3),
            number(loop["gain"], digits=3),
        )
        for place, loops in margins.items()
        for name, loop in loops.items()
    ]
    heads = ("Set", "Friction compensation", "Phase margin [°]", "Gain margin")
    return Table("Smallest margins of the loops; feedforward does not change margins", heads, rows)
