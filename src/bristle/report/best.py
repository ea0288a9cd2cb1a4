"""Which variant of a loop follows best, and by how much better than the first: in words that the runs bear out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from bristle.core.status import Status
from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import unit_of
from bristle.report.compensation import NO_CHANGE, gain_of

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["Standing", "best_sentences", "closing_sentences", "error_text", "is_alike", "percent_text", "standing"]

BASE = "base"
NAMES_MAX = 4  # names of variants that err about as little


class Standing(NamedTuple):
    """The loop as it stands, and the variant that errs least."""

    base: VariantResult
    best: VariantResult
    alike: bool


def standing(result: SimulationResult) -> Standing | None:
    """Return the loop as it stands and the best one along the same reference; None where that loop did not complete."""
    base = _base(result) if result.variants else None
    if base is None or not _is_done(base):
        return None
    references = {variant.name: variant.reference for variant in result.experiment.variants}
    completed = [variant for variant in result.variants.values() if _is_done(variant)]
    best = min((one for one in completed if references[one.name] == references[base.name]), key=_peak)
    return Standing(base, best, best is base or is_alike(best, base))


def closing_sentences(result: SimulationResult) -> list[str]:
    """Return what to take from the variants of an experiment: what compensation gains, and which variant is best."""
    gain = gain_of(result)
    if gain is None:
        return best_sentences(result)
    *before, last = gain.sentences()
    return [*before, *best_sentences(result), last] if gain.steps else [last, *best_sentences(result)]


def best_sentences(result: SimulationResult) -> list[str]:
    """Return which variant has the smallest following error, against the loop as it stands; nothing for one alone.

    Several runs that scatter as much as two variants differ do not tell them apart: nothing is called better then.
    """
    completed = [variant for variant in result.variants.values() if _is_done(variant)]
    if len(completed) < 2:
        return []
    unit = unit_of("length", result.experiment.kind)
    best = min(completed, key=_peak)
    alike = [variant for variant in completed if variant is not best and is_alike(best, variant)]
    base = _base(result)
    if base is None or not _is_done(base):
        lacks = f"{base.name if base else BASE}, against which it would be measured, did not complete"
        return [f"Of {len(completed)} variants, {best.name} errs least: {error_text(best, unit)} peak to peak. {lacks}."]
    if best is base:
        nearest = min((variant for variant in completed if variant is not base), key=_peak)
        more = "about as much as" if nearest in alike else f"{percent_text(base, nearest)} more than"
        return [
            f"No variant errs less than {base.name}: {error_text(base, unit)} peak to peak. The nearest, "
            f"{nearest.name}, errs by {error_text(nearest, unit)}, {more} that{_runs(base)}."
        ]
    less = "hardly less" if base in alike else f"{percent_text(base, best)} less"
    comparison = (
        f"Of {len(completed)} variants, {best.name} errs least: {error_text(best, unit)} peak to peak, {less} than "
        f"{base.name} with {error_text(base, unit)}{_runs(best)}."
    )
    return [comparison, *_near_ties([variant for variant in alike if variant is not base])]


def _base(result: SimulationResult) -> VariantResult | None:
    """Return the loop as it stands: the variant of that name, else the first; None where it was not simulated."""
    if BASE in result.variants or BASE in result.refused:
        return result.variants.get(BASE)
    return result.variants[result.experiment.variants[0].name]


def _near_ties(alike: list[VariantResult]) -> list[str]:
    if not alike:
        return []
    names = [variant.name for variant in sorted(alike, key=_peak)]
    more = f" and {len(names) - NAMES_MAX} more" if len(names) > NAMES_MAX else ""
    verb = "errs" if len(names) == 1 else "err"
    return [f"About as little {verb} {', '.join(names[:NAMES_MAX])}{more}."]


def _is_done(variant: VariantResult) -> bool:
    return variant.status is not Status.NOT_FINITE and math.isfinite(_peak(variant))


def _peak(variant: VariantResult) -> float:
    return variant.following_error.peak_to_peak


def _spread(variant: VariantResult) -> float:
    return float(variant.spread["following_error"]["peak_to_peak"]) if variant.spread else 0.0


def is_alike(best: VariantResult, variant: VariantResult) -> bool:
    """Return whether two variants are not told apart: by as much as nobody minds, or as their runs scatter."""
    return _peak(variant) - _peak(best) <= max(NO_CHANGE * _peak(variant), _spread(best) + _spread(variant))


def error_text(variant: VariantResult, unit: str) -> str:
    """Return the error with its unit, and the standard deviation over the runs."""
    if not _spread(variant):
        return with_unit(_peak(variant), unit)
    scale = scale_of(unit, _peak(variant))
    peak, spread = _peak(variant) * scale.factor, _spread(variant) * scale.factor
    return f"{number(peak, spread)} ± {number(spread, spread)} {scale.unit}"


def percent_text(base: VariantResult, variant: VariantResult) -> str:
    """Return by how much the error of another variant differs from that of the base, in percent of that."""
    ratio = _peak(variant) / _peak(base) if _peak(base) else math.inf
    percent = 100.0 * abs(1.0 - ratio)
    spreads = (_spread(result) / _peak(result) if _peak(result) else 0.0 for result in (base, variant))
    spread = 100.0 * ratio * math.hypot(*spreads)
    # What is left tells as much as what is gone: 99.6 % is not 100 %.
    left = 100.0 - percent if 99.0 < percent < 100.0 else None
    return f"{number(percent, spread)} ± {number(spread, spread)} %" if spread else f"{number(percent, left, 2)} %"


def _runs(variant: VariantResult) -> str:
    return f" (mean ± standard deviation over {variant.runs} runs)" if _spread(variant) else ""
