"""The headline of an identification, in words that can be forwarded."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of
from bristle.report.compensation import Gain, about_loop
from bristle.report.messages import whole_sentence, why_effective

if TYPE_CHECKING:
    from bristle.identification.result import Fit, Identification
    from bristle.prediction.following import Following
    from bristle.simulation.result import Prediction

__all__ = ["sentences"]

WIDER_OUTSIDE = 1.25  # ratio of held-out to fitted error from which the reader is told


def sentences(
    identification: Identification, axis_name: str, gain: Gain | None, prediction: Prediction | None, following: Following | None = None
) -> list[str]:
    """Return the verdict: which model, how well it predicts, how sure it is, and what compensation gains."""
    fit = identification.best
    lines = [_model(identification, axis_name), _error(fit), _certainty(fit), *_channels(fit)]
    if prediction is not None:
        lines += _prediction(prediction)
    lines += about_loop(gain, following, fit.plant.kind)
    if gain is None:
        lines.append("What compensation gains was not simulated: that takes a log with a reference and a controller in the axis file.")
    return lines


def _model(identification: Identification, axis_name: str) -> str:
    fit, competitors = identification.best, identification.fits[1:]
    basis = f"held-out {fit.held_out.of}" if fit.held_out is not None else "the log they were fitted to"
    compared = f", the best of {len(competitors) + 1} models by their error on {basis}" if competitors else ""
    text = f"The friction of {axis_name} is described by {fit.name} ({fit.friction.component.description}){compared}."
    closer = [competitor for competitor in competitors if _held_out(competitor) < float(f"{_held_out(fit):.3g}")]
    if not closer:
        return text
    closest = min(closer, key=_held_out)
    return (
        f"{text} {closest.name} comes to {_percent(_held_out(closest))} there instead of {_percent(_held_out(fit))}, "
        "which is no reason to prefer it: the blocks do not tell the two apart, or this log leaves half of its "
        "parameters open."
    )


def _held_out(fit: Fit) -> float:
    return fit.held_out.mean_percent if fit.held_out is not None else math.inf


def _error(fit: Fit) -> str:
    if fit.position_rmse is not None:
        rmse = with_unit(fit.position_rmse, unit_of("length", fit.plant.kind))
        text = f"From the effort of the log it makes the motion to {_percent(fit.error_percent)} ({rmse} root mean square)"
    elif fit.loop_rmse is not None:
        rmse = with_unit(fit.loop_rmse, unit_of("force", fit.plant.kind))
        text = f"From the reference it makes the effort of the closed loop to {_percent(fit.error_percent)} ({rmse} root mean square)"
    else:
        text = (
            f"It reproduces the effort of the log to {_percent(fit.force_error_percent)} of its root mean square "
            f"({_percent(fit.friction_alone_error_percent)} of what friction takes of it)"
        )
    if fit.held_out is None:
        return f"{text}; nothing was held out, so how it does on another log is open."
    text += f", and to {_percent(fit.held_out.mean_percent)} on {fit.held_out.of} that it was not fitted to."
    if fit.held_out.mean_percent > WIDER_OUTSIDE * fit.error_percent:
        text += " The second is clearly larger: either the model has more freedom than this log supports, or the "
        text += "friction changed while it was recorded."
    return text


def _certainty(fit: Fit) -> str:
    free = [estimate for estimate in fit.estimates if estimate.status != "held"]
    unknown = [estimate.name for estimate in free if estimate.status != "identified"]
    if unknown:
        text = f"{len(unknown)} of {len(free)} parameters could not be identified from this log: {', '.join(unknown)}."
        return text + (f" The others are effective: {why_effective(fit)}." if fit.effective else "")
    if not free:
        return "No parameter was asked of this log: all were held."
    precisions = [(estimate.interval_percent, estimate.name) for estimate in free]
    percents = [(percent, name) for percent, name in precisions if percent is not None and percent < 100.0]
    zero = [name for percent, name in precisions if percent is None or percent >= 100.0]
    kind = f"identified, but effective: {why_effective(fit)}" if fit.effective else "identified"
    text = f"All {len(free)} parameters are {kind}"
    if percents:
        widest, name = max(percents)
        text += f"; the least certain, {name}, to ± {_percent(widest)} (95 % interval)"
    return f"{text}; {' and '.join(zero)} cannot be told from zero." if zero else f"{text}."


def _channels(fit: Fit) -> list[str]:
    """Return how the effort of the log stands in time to its position, where that was found."""
    return [whole_sentence(delay) for delay in fit.diagnostics if delay.code == "delay_found"]


def _prediction(prediction: Prediction) -> list[str]:
    force, position = prediction.metrics.get("force_error_percent"), prediction.metrics.get("position_rmse")
    parts = [f"the effort with an error of {_percent(float(force))}"] if force is not None else []
    unit = str(prediction.metrics["position_unit"])
    parts += [f"the position to {with_unit(float(position), unit)} root mean square"] if position is not None else []
    if not parts:
        return []
    return [f"Run on the log in {prediction.mode} mode, it predicts {' and '.join(parts)}."]


def _percent(value: float) -> str:
    return f"{number(value, digits=3)} %"
