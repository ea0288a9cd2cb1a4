"""What came out of a trial, in numbers: means with intervals, the best family of each truth, and what was promised."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.paper.robust.competitors import CHOSEN
from bristle.paper.robust.conditions import NOMINAL
from bristle.paper.robust.loops import VARIANTS
from bristle.paper.robust.trial import Cell, Trial
from bristle.paper.robust.truths import is_own

__all__ = ["Claim", "Interval", "best_family", "claims", "error_of", "interval", "no_better", "numbers", "share_left"]

COVERAGE = 0.95
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
        quantile = float(stdtrit(values.size - 1, 0.5 * (1.0 + COVERAGE)))
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
        if not (strangers and is_own(friction, family))
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
    return {
        **{("robust" if place == SET_A else f"robust_{place}"): _table(trial, place) for place in trial.plan.sets},
        "families": {truth.name: _families(trial, truth.name) for truth in trial.plan.truths},
        "best_family": {truth.name: {place: _best(trial, place, truth.name) for place in trial.plan.sets} for truth in trial.plan.truths},
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


def _families(trial: Trial, name: str) -> dict[str, Any]:
    truth = next(truth for truth in trial.plan.truths if truth.name == name)
    return {
        family: {
            "own_structure": is_own(truth, family),
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
