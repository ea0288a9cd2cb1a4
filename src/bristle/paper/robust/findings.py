"""What came out of a trial: means with intervals, the best family of each truth, what was promised, and the tables of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core.typography import number
from bristle.paper.economy import WAYS
from bristle.paper.robust.loops import CHOSEN, VARIANTS, setting
from bristle.paper.robust.trial import Cell, Trial
from bristle.paper.robust.truths import MEANINGS, NOMINAL, Truth
from bristle.paper.tracking import least_margins
from bristle.report.table import Table

LEVELS = (NOMINAL, "level_0.7", "level_1.3", "level_1.6")
OBSERVER, TOGETHER = "observer", "observer_feedforward"
AT_ALL_LEVELS, ON_ALL_TRUTHS = 0.45e-6, 0.50e-6  # [m]
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


def error_of(trial: Trial, place: str, truth: str, variant: str, condition: str = NOMINAL, family: str = CHOSEN) -> Interval | None:
    """Return the error of a loop; None where it was not simulated."""
    errors = trial.errors.get(Cell(place, truth, condition, variant, family if "feedforward" in variant else ""))
    return interval(errors) if errors is not None and errors.size else None


def share_left(trial: Trial, place: str, truth: str, variant: str, family: str = CHOSEN) -> float:
    """Return which share of the error without compensation a loop leaves under nominal conditions; NaN if not known."""
    before, after = error_of(trial, place, truth, "none"), error_of(trial, place, truth, variant, family=family)
    return after.peak_to_peak / before.peak_to_peak if before and after else math.nan


def best_family(trial: Trial, place: str, truth: str, *, strangers: bool = False) -> str:
    """Return the family whose feedforward leaves least of the error of a truth; empty where none was fitted."""
    friction = next(friction for friction in trial.plan.truths if friction.name == truth)
    errors = {
        family: loop_error.peak_to_peak
        for family in trial.plan.compensators
        if not (strangers and family in friction.families)
        and (loop_error := error_of(trial, place, truth, "feedforward", family=family)) is not None
    }
    return min(errors, key=lambda family: errors[family]) if errors else ""


def no_better(trial: Trial, place: str) -> list[str]:
    """Return the truths on which observer and feedforward together leave no less than the observer alone.

    The difference of both means has to exceed its own 95 % interval, under nominal conditions.
    """
    names = []
    for truth in trial.plan.truths:
        alone, both = (error_of(trial, place, truth.name, variant) for variant in (OBSERVER, TOGETHER))
        if alone is None or both is None:
            continue
        halves = [0.0 if math.isnan(one.low) else one.peak_to_peak - one.low for one in (alone, both)]
        if not alone.peak_to_peak - both.peak_to_peak > math.hypot(*halves):
            names.append(truth.name)
    return names


class Claim(NamedTuple):
    """What the table is to show, and whether it does."""

    words: str
    limit: float
    errors: Mapping[str, float]

    @property
    def holds(self) -> bool:
        """Whether no case exceeds the limit."""
        return all(error <= self.limit for error in self.errors.values())


def claims(trial: Trial, place: str = SET_A) -> list[Claim]:
    """Return what is claimed of observer and feedforward together, as far as the trial has the cases."""
    levels = {
        condition: loop_error.peak_to_peak
        for condition in LEVELS
        if (loop_error := error_of(trial, place, FIRST, TOGETHER, condition)) is not None
    }
    strange = {
        truth.name: loop_error.peak_to_peak
        for truth in trial.plan.truths
        if truth.name != FIRST and (loop_error := error_of(trial, place, truth.name, TOGETHER)) is not None
    }
    listed = [
        Claim("observer and feedforward on the thirty sliders, at 0.7 to 1.6 times the level, without a refit", AT_ALL_LEVELS, levels),
        Claim("observer and feedforward on every other truth, nothing changed", ON_ALL_TRUTHS, strange),
    ]
    return [claim for claim in listed if claim.errors]


FIRST = "thirty_sliders"


def numbers(trial: Trial) -> dict[str, Any]:
    """Return what came out for the summary, lengths in m."""
    plan = trial.plan
    best = {truth.name: {place: _best(trial, place, truth.name) for place in plan.sets} for truth in plan.truths}
    return {
        **{("robust" if place == SET_A else f"robust_{place}"): _table(trial, place) for place in plan.sets},
        "families": {truth.name: _families(trial, truth) for truth in plan.truths},
        "best_family": best,
        "observer_alone_does_as_well": {place: no_better(trial, place) for place in trial.plan.sets},
        "claims": {
            place: [
                {"claim": claim.words, "limit": claim.limit, "errors": dict(claim.errors), "holds": claim.holds}
                for claim in claims(trial, place)
            ]
            for place in trial.plan.sets
        },
    }


def _table(trial: Trial, place: str) -> dict[str, Any]:
    return {
        truth.name: {
            condition: {
                variant: loop_error._asdict()
                for variant in VARIANTS
                if (loop_error := error_of(trial, place, truth.name, variant, condition)) is not None
            }
            for condition in trial.plan.conditions
        }
        for truth in trial.plan.truths
    }


def _families(trial: Trial, truth: Truth) -> dict[str, Any]:
    name = truth.name
    return {
        family: {
            "own_structure": family in truth.families,
            "reason": trial.fits[name, family].reason,
            **{
                place: loop_error._asdict() | {"share_left": share_left(trial, place, name, "feedforward", family)}
                for place in trial.plan.sets
                if (loop_error := error_of(trial, place, name, "feedforward", family=family)) is not None
            },
        }
        for family in trial.plan.compensators
    }


def _best(trial: Trial, place: str, truth: str) -> dict[str, Any]:
    family, stranger = best_family(trial, place, truth), best_family(trial, place, truth, strangers=True)
    return {
        "family": family,
        "share_left": share_left(trial, place, truth, "feedforward", family),
        "stranger": stranger,
        "stranger_share_left": share_left(trial, place, truth, "feedforward", stranger),
    }


SET_NAMES = {"set_a": "Set A", "set_c": "Set C"}
LOOPS = {"none": "nothing", "feedforward": "a model, fed forward", "observer": "an observer", "observer_feedforward": "both"}
OWN = "*"
DIVERGED = "diverged"


def micrometres(error: Interval | None) -> str:
    """Return an error with its 95 % interval [µm] as text."""
    if error is None:
        return "–"
    if not math.isfinite(error.peak_to_peak):
        return DIVERGED
    mean = number(1e6 * error.peak_to_peak, resolution=0.1)
    if math.isnan(error.low):
        return mean
    return f"{mean} ({number(1e6 * error.low, resolution=0.1)} to {number(1e6 * error.high, resolution=0.1)})"


def error_table(trial: Trial, place: str) -> Table:
    """Return the following error of every loop of a set, truth by truth and condition by condition."""
    rows = [
        (truth.name, condition, *(micrometres(error_of(trial, place, truth.name, v, condition)) for v in VARIANTS))
        for truth in trial.plan.truths
        for condition in trial.plan.conditions
    ]
    caption = (
        f"{SET_NAMES[place]}: following error peak to peak [µm], mean over {trial.plan.seeds} runs with other noise "
        "and scatter, and its 95 % interval"
    )
    return Table(caption, ("Friction of the rig", "Condition", *LOOPS.values()), rows)


def condition_table(trial: Trial) -> Table:
    """Return what each condition is."""
    rows = [(condition, MEANINGS[condition]) for condition in trial.plan.conditions]
    return Table("Conditions, which no compensator is told", ("Condition", "The rig"), rows)


def claim_table(trial: Trial) -> Table:
    """Return what was to be shown, and whether it is."""
    rows = []
    for place in trial.plan.sets:
        for claim in claims(trial, place):
            worst = max(claim.errors, key=lambda case: claim.errors[case])
            error = number(1e6 * claim.errors[worst], resolution=0.1)
            limit = number(1e6 * claim.limit, resolution=0.1)
            rows.append((f"{SET_NAMES[place]}: {claim.words}", limit, error, worst, "yes" if claim.holds else "no"))
    heads = ("What", "At most [µm]", "Largest mean [µm]", "On", "Holds")
    return Table("Following error peak to peak", heads, rows)


def best_table(trial: Trial) -> Table:
    """Return the best family of each truth, and the best that has not its structure."""
    rows = []
    for truth in trial.plan.truths:
        for place in trial.plan.sets:
            cells = []
            for strangers in (False, True):
                family = best_family(trial, place, truth.name, strangers=strangers)
                own = ("yes" if family in truth.families else "no",) if not strangers else ()
                cells += [family or "–", *own, _percent(share_left(trial, place, truth.name, "feedforward", family))]
            chosen = _percent(share_left(trial, place, truth.name, "feedforward", CHOSEN))
            rows.append((truth.name, SET_NAMES[place], *cells, chosen))
    heads = (
        "Friction of the rig",
        "Set",
        "Best family",
        "Of the truth’s structure",
        "Leaves [%]",
        "Best of another structure",
        "It leaves [%]",
        f"{CHOSEN} leaves [%]",
    )
    return Table("Which family fed forward leaves least of the error without compensation", heads, rows)


def family_table(trial: Trial, place: str) -> Table:
    """Return the share that feedforward of each family leaves, truth by truth."""
    rows = []
    for family in trial.plan.compensators:
        shares = [(truth, _percent(share_left(trial, place, truth.name, "feedforward", family))) for truth in trial.plan.truths]
        rows.append((family, *(share + (OWN if family in truth.families else "") for truth, share in shares)))
    caption = (
        f"{SET_NAMES[place]}: share of the error without compensation that feedforward leaves [%]; with {OWN} where "
        "the family has the structure of the truth"
    )
    return Table(caption, ("Family", *(truth.name for truth in trial.plan.truths)), rows)


def _percent(share: float) -> str:
    if math.isnan(share):
        return "–"
    return DIVERGED if math.isinf(share) else number(100.0 * share, resolution=10.0)


def unfitted(trial: Trial) -> list[str]:
    """Return which families were not identified, and why."""
    return [f"{family} on {truth}: {fit.reason}" for (truth, family), fit in trial.fits.items() if fit.friction is None]


def margins_of_sets(sets: tuple[str, ...]) -> dict[str, dict[str, dict[str, float]]]:
    """Return the smallest margins of the loops of each set, whatever friction does: what is fed forward has none."""
    return {
        place: {
            name: dict(zip(("phase_deg", "gain"), least_margins(variant), strict=True))
            for name, variant in setting(place).items()
            if "feedforward" not in name
        }
        for place in sets
    }


def margin_table(margins: Mapping[str, Mapping[str, Mapping[str, float]]]) -> Table:
    """Return the margins of the loops."""
    rows = [
        (SET_NAMES[place], LOOPS[name], number(loop["phase_deg"], digits=3), number(loop["gain"], digits=3))
        for place, loops in margins.items()
        for name, loop in loops.items()
    ]
    heads = ("Set", "Against friction works", "Phase margin [°]", "Gain margin")
    return Table("Smallest margins of the loops; a model that is fed forward changes none", heads, rows)


def economy_table(trial: Trial) -> Table:
    """Return the error of models from few and more measured branches, truth by truth."""
    rows = []
    for truth, cost in trial.economy.items():
        for row, count in enumerate(cost.counts):
            means = (float(cost.errors[way][row].mean()) for way in WAYS)
            cells = ("–" if math.isnan(mean) else number(mean, digits=2) for mean in means)
            rows.append((truth, str(count), *cells, number(cost.floor, digits=2)))
    heads = ("Contact", "Branches", *WAYS, "Scatter alone")
    return Table("Error on motions that were not measured [%], of the largest force, mean over seeds", heads, rows)
