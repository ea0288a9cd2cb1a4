"""The first page of a hysteresis operator: how near it comes to recorded curves, and to those that it was not shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle.core.variable import unit_of
from bristle.report.front import Front, Ruling, about, answered, fixed, percent_text

if TYPE_CHECKING:
    from bristle.hysteresis.identification.result import OperatorFit, OperatorPrediction
    from bristle.logs.curves import Curves
    from bristle.report.page import Picture

__all__ = ["operator_front", "operator_ruling"]

NEAR, FAR = 5.0, 20.0  # percent of full scale: errors up to which an operator is usable, and of some use
TWICE = 2.0  # times the fitted error, from which what was not fitted tells of too many parameters


def operator_ruling(error: float, held_out: float | None, *, fitted: bool) -> Ruling:
    """Return whether an operator is usable, and why."""
    decisive = error if held_out is None else held_out
    place = "on what it was not fitted to" if held_out is not None else "on these curves"
    reasons = [f"it misses {percent_text(decisive)} of full scale {place}"]
    if fitted and held_out is None:
        reasons.append("nothing was held out: its error says nothing of other curves")
    if held_out is not None and held_out > TWICE * error:
        reasons.append(f"on the curves that it was fitted to it misses no more than {percent_text(error)}")
    if decisive > FAR:
        return Ruling("no", "Not usable", tuple(reasons))
    care = decisive > NEAR or len(reasons) > 1
    return Ruling("with_care" if care else "usable", "Use with care" if care else "Usable", tuple(reasons))


def operator_front(
    prediction: OperatorPrediction, name: str, title: str, recorded: Curves, figure: Picture, fits: Sequence[OperatorFit] = ()
) -> Front:
    """Return the first page of an operator, identified or held against other curves; `fits` are best first."""
    best = fits[0] if fits else None
    held_out = best.held_out if best is not None else None
    ruling = operator_ruling(prediction.error_percent, held_out and held_out.mean_percent, fitted=bool(fits))
    unit, count = unit_of("force", recorded.kind), len(recorded.curves)
    quality = [f"off by {fixed(prediction.rmse, unit)} of {fixed(recorded.full_scale, unit)}, root mean square"]
    if held_out is not None:
        quality.append(f"error on {held_out.of} that it was not fitted to: {percent_text(held_out.mean_percent)}")
    trust = [f"{count} {'curve' if count == 1 else 'curves'}, each begins: {recorded.start}"]
    trust += [note for note in best.notes if note][:2] if best is not None else []
    then = "predict curves that it has not seen: `bristle predict model.toml CURVES --axis axis.toml`"
    return Front(
        f"{name}: {title}",
        about(f"{count} {'curve' if count == 1 else 'curves'}"),
        *ruling[:2],
        ruling.reasons,
        answered(
            quality,
            ["the model file, model.toml, as it is written" if fits else "nothing new: the model file as it is"],
            _beside(fits),
            trust,
            [then if fits else "where it misses: record more curves there, and identify again"],
            third="How others do",
        ),
        figure,
        "model",
    )


def _beside(fits: Sequence[OperatorFit]) -> list[str]:
    """Return how the other operators do."""
    lines = []
    for fit in fits[1:4]:
        error = fit.prediction.error_percent if fit.held_out is None else fit.held_out.mean_percent
        lines.append(f"beside it: {percent_text(error)} by {fit.name}")
    return lines or ["no other operator was compared"]
