"""Whether an identified model can be used: the one word that a person who types it into a drive looks for, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.report.messages import sentence_of

if TYPE_CHECKING:
    from bristle.core.diagnostic import Diagnostic
    from bristle.identification.result import Fit
    from bristle.identification.settings import Settings
    from bristle.prediction.following import Following

__all__ = ["DOUBTS", "LEVELS", "Judgement", "judged"]

LEVELS = {"usable": "Usable", "with_care": "Use with care", "measure_again": "Measure again"}
"""The words of each level."""
DOUBTS = (
    "structure",
    "stages_differ",
    "filter_suspect",
    "delay_or_filter",
    "delay_unknown",
    "delay_rough",
    "rows_lost",
    "clock_suspect",
    "unit_suspect",
    "weight_guessed",
    "velocity_contradicts",
    "clipped",
    "saturates",
    "beyond_limit",
    "beyond_stroke",
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
    "half_cycles_differ",
)
"""Codes that doubt a record, or the model on it, rather than a single parameter; the gravest first."""


class Judgement(NamedTuple):
    """What a model is good for: a level of `LEVELS`, and the reasons why it is no better."""

    level: str
    reasons: tuple[str, ...]

    @property
    def words(self) -> str:
        """The level in words."""
        return LEVELS[self.level]

    def as_data(self) -> dict[str, Any]:
        """Return it as it stands in JSON."""
        return {"level": self.level, "reasons": self.reasons}


def judged(fit: Fit, settings: Settings, following: Following | None = None) -> Judgement:
    """Return whether a fit is usable, to be used with care, or no reason to type anything into a drive.

    It takes another record where the log contradicts itself, half of the parameters are open, or the model misses most
    of what friction takes. It takes care where anything is doubted that a number stands on.
    """
    grave, doubts = _grave(fit, settings), _doubts(fit, settings, following)
    if grave:
        return Judgement("measure_again", (*grave, *doubts))
    return Judgement("with_care" if doubts else "usable", tuple(doubts))


def _grave(fit: Fit, settings: Settings) -> list[str]:
    reasons = [_means(doubt.code) for doubt in fit.diagnostics if doubt.severity == "error"]
    sought = [estimate for estimate in fit.estimates if estimate.status != "held"]
    unknown = [estimate.name for estimate in sought if estimate.status != "identified"]
    if unknown and len(unknown) >= settings.doubtful_share * len(sought):
        reasons.append(f"{len(unknown)} of {len(sought)} parameters are open: {', '.join(unknown)}")
    if _error(fit) > settings.useless_error:
        reasons.append(f"the model misses {_error(fit):.3g} % of what friction takes")
    return list(dict.fromkeys(reasons))


def _doubts(fit: Fit, settings: Settings, following: Following | None) -> list[str]:
    doubted = {doubt.code: doubt for doubt in fit.diagnostics if doubt.severity == "warning"}
    reasons = [_reason(doubted[code]) for code in DOUBTS if code in doubted]
    unknown = [estimate.name for estimate in fit.estimates if estimate.status in ("unidentifiable", "at_edge")]
    if unknown:
        reasons.append(f"not identified: {', '.join(unknown)}")
    if settings.usable_error < _error(fit) <= settings.useless_error:
        reasons.append(f"the model misses {_error(fit):.3g} % of what friction takes")
    if following is not None and following.contradiction is not None:
        reasons.append(_means(following.contradiction.code))
    return reasons


def _reason(diagnostic: Diagnostic) -> str:
    causes = diagnostic.numbers.get("causes")
    return _means(diagnostic.code) + (f": {', '.join(map(str, causes))}" if isinstance(causes, tuple) else "")


def _means(code: str) -> str:
    return sentence_of(code).means


def _error(fit: Fit) -> float:
    """Return how much the model misses, of what friction takes where it was fitted to the effort [%]."""
    simulated = fit.position_rmse is not None or fit.loop_rmse is not None
    return fit.error_percent if simulated else fit.friction_alone_error_percent
