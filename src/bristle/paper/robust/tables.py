"""The tables of a trial, in words and micrometres."""

from __future__ import annotations

import math
from collections.abc import Mapping

from bristle.core.typography import number
from bristle.loop import assess
from bristle.paper.economy import WAYS, Economy
from bristle.paper.robust.competitors import CHOSEN
from bristle.paper.robust.conditions import MEANINGS
from bristle.paper.robust.findings import Interval, best_family, claims, error_of, share_left
from bristle.paper.robust.loops import VARIANTS, setting
from bristle.paper.robust.trial import Trial
from bristle.paper.robust.truths import Truth, is_own
from bristle.report.table import Table

__all__ = [
    "LOOPS",
    "SET_NAMES",
    "best_table",
    "claim_table",
    "condition_table",
    "economy_table",
    "error_table",
    "family_table",
    "margin_table",
    "margins_of_sets",
    "unfitted",
]

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
                own = ("yes" if is_own(truth, family) else "no",) if not strangers else ()
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
    rows = [(family, *(_share_cell(trial, place, truth, family) for truth in trial.plan.truths)) for family in trial.plan.compensators]
    caption = (
        f"{SET_NAMES[place]}: share of the error without compensation that feedforward leaves [%]; with {OWN} where "
        "the family has the structure of the truth"
    )
    return Table(caption, ("Family", *(truth.name for truth in trial.plan.truths)), rows)


def _share_cell(trial: Trial, place: str, truth: Truth, family: str) -> str:
    left = share_left(trial, place, truth.name, "feedforward", family)
    return _percent(left) + (OWN if is_own(truth, family) else "")


def _percent(share: float) -> str:
    if math.isnan(share):
        return "–"
    return DIVERGED if math.isinf(share) else number(100.0 * share, resolution=10.0)


def unfitted(trial: Trial) -> list[str]:
    """Return which families were not identified, and why."""
    return [f"{family} on {truth}: {fit.reason}" for (truth, family), fit in trial.fits.items() if fit.friction is None]


def margins_of_sets(sets: tuple[str, ...]) -> dict[str, dict[str, dict[str, float]]]:
    """Return the smallest margins of the loops of each set, whatever friction does: what is fed forward has none."""
    smallest: dict[str, dict[str, dict[str, float]]] = {}
    for place in sets:
        smallest[place] = {}
        for name, variant in setting(place).items():
            if "feedforward" in name:
                continue
            margins = [point.margins for point in assess(variant).points]
            smallest[place][name] = {
                "phase_deg": min((m.phase for m in margins if m.phase is not None), default=math.inf),
                "gain": min((m.gain for m in margins if m.gain is not None), default=math.inf),
            }
    return smallest


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
    rows = [
        (truth, str(count), *(_error_cell(cost, way, row) for way in WAYS), number(cost.floor, digits=2))
        for truth, cost in trial.economy.items()
        for row, count in enumerate(cost.counts)
    ]
    heads = ("Contact", "Branches", *WAYS, "Scatter alone")
    return Table("Error on motions that were not measured [%], of the largest force, mean over seeds", heads, rows)


def _error_cell(cost: Economy, way: str, row: int) -> str:
    mean = float(cost.errors[way][row].mean())
    return "–" if math.isnan(mean) else number(mean, digits=2)
