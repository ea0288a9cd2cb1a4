"""Which variant of a loop follows best, and by how much better than the first: in words that the runs bear out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.status import Status
from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import unit_of
from bristle.report.compensation import NO_CHANGE, gain_of

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["best_sentences", "closing_sentences"]

BASE = "base"
SHOWN = 4  # names of variants that err about as little


def closing_sentences(result: SimulationResult) -> list[str]:
    """Return what to take from the variants of an experiment: what compensation gains, and which variant is best."""
    gain = gain_of(result)
    if gain is None:
        return best_sentences(result)
    *told, last = gain.sentences()
    return [*told, *best_sentences(result), last] if gain.steps else [last, *best_sentences(result)]


def best_sentences(result: SimulationResult) -> list[str]:
    """Return which variant has the smallest following error, against the loop as it stands; nothing for one alone.

    Several runs that scatter as much as two variants differ do not tell them apart: nothing is called better then.
    """
    done = [one for one in result.variants.values() if _is_done(one)]
    if len(done) < 2:
        return []
    unit = unit_of("length", result.experiment.kind)
    best = min(done, key=_peak)
    alike = [one for one in done if one is not best and _is_alike(best, one)]
    base = _base(result)
    if base is None or not _is_done(base):
        lacks = f"{base.name if base else BASE}, against which it would be measured, did not complete"
        return [f"Of {len(done)} variants, {best.name} errs least: {_told(best, unit)} peak to peak. {lacks}."]
    if best is base:
        nearest = min((one for one in done if one is not base), key=_peak)
        more = "about as much as" if nearest in alike else f"{_percent(base, nearest)} more than"
        return [
            f"No variant errs less than {base.name}: {_told(base, unit)} peak to peak. The nearest, {nearest.name}, "
            f"errs by {_told(nearest, unit)}, {more} that{_runs(base)}."
        ]  # fmt: skip
    less = "hardly less" if base in alike else f"{_percent(base, best)} less"
    told = (
        f"Of {len(done)} variants, {best.name} errs least: {_told(best, unit)} peak to peak, {less} than {base.name} "
        f"with {_told(base, unit)}{_runs(best)}."
    )
    return [told, *_others([one for one in alike if one is not base])]


def _base(result: SimulationResult) -> VariantResult | None:
    """Return the loop as it stands: the variant of that name, else the first; None where it was not simulated."""
    if BASE in result.variants or BASE in result.refused:
        return result.variants.get(BASE)
    return result.variants[result.experiment.variants[0].name]


def _others(alike: list[VariantResult]) -> list[str]:
    if not alike:
        return []
    names = [one.name for one in sorted(alike, key=_peak)]
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    verb = "errs" if len(names) == 1 else "err"
    return [f"About as little {verb} {', '.join(names[:SHOWN])}{more}."]


def _is_done(one: VariantResult) -> bool:
    return one.status is not Status.NOT_FINITE and math.isfinite(_peak(one))


def _peak(one: VariantResult) -> float:
    return one.following_error.peak_to_peak


def _spread(one: VariantResult) -> float:
    return float(one.spread["following_error"]["peak_to_peak"]) if one.spread else 0.0


def _is_alike(best: VariantResult, other: VariantResult) -> bool:
    """Return whether two variants are not told apart: by as much as nobody minds, or as their runs scatter."""
    return _peak(other) - _peak(best) <= max(NO_CHANGE * _peak(other), _spread(best) + _spread(other))


def _told(one: VariantResult, unit: str) -> str:
    """Return the error with its unit, and the standard deviation over the runs."""
    if not _spread(one):
        return with_unit(_peak(one), unit)
    scale = scale_of(unit, _peak(one))
    peak, spread = _peak(one) * scale.factor, _spread(one) * scale.factor
    return f"{number(peak, spread)} ± {number(spread, spread)} {scale.unit}"


def _percent(base: VariantResult, other: VariantResult) -> str:
    """Return by how much the error of another variant differs from that of the base, in percent of that."""
    ratio = _peak(other) / _peak(base) if _peak(base) else math.inf
    percent = 100.0 * abs(1.0 - ratio)
    spread = 100.0 * ratio * math.hypot(*(_spread(one) / _peak(one) if _peak(one) else 0.0 for one in (base, other)))
    return f"{number(percent, spread)} ± {number(spread, spread)} %" if spread else f"{number(percent, digits=2)} %"


def _runs(one: VariantResult) -> str:
    return f" (mean ± standard deviation over {one.runs} runs)" if _spread(one) else ""
