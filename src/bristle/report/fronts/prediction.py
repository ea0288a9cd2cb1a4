"""The first page of a prediction: whether the model holds on this log, and what to do where it does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bristle.core.status import Status
from bristle.core.variable import unit_of
from bristle.identification.settings import DEFAULT, Settings
from bristle.report.front import Front, Ruling, about, answered, fixed, length_text, percent_text
from bristle.report.messages import sentence_of

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.logs.log import Log
    from bristle.report.page import Picture
    from bristle.simulation.result import Prediction

__all__ = ["prediction_front", "prediction_ruling"]

INSIDE = 80.0  # percent of what is measured that lie in a band of 95 %, below which the band is said to be too narrow
OWN_LOG = "it was fitted to this very log, which says nothing of another one"
SIGNALS = {"force": "effort", "position": "position"}


def prediction_ruling(prediction: Prediction, settings: Settings = DEFAULT, *, own_log: bool = False) -> Ruling:
    """Return whether a model holds on a log, and why.

    The effort decides, where it is predicted: of a position nearly everything is told by the reference.
    """
    doubted = [diagnostic for diagnostic in prediction.diagnostics if diagnostic.severity != "note"]
    doubts = list(dict.fromkeys(sentence_of(diagnostic.code).means for diagnostic in doubted))
    if prediction.status is Status.NOT_FINITE:
        return Ruling("no", "It does not run", (prediction.status.sentence, *doubts))
    signal, error = _decisive(prediction)
    reasons = [] if error is None else [f"it misses {percent_text(error)} of the {signal} of this log"]
    shares = {"effort": prediction.inside_percent, "position": prediction.position_inside_percent}
    narrow = [
        f"no more than {percent_text(share)} of the {name} lie in the band that should hold 95 %"
        for name, share in shares.items()
        if share is not None and share < INSIDE
    ]
    status = [] if prediction.status is Status.OK else [prediction.status.sentence]
    own = [OWN_LOG] if own_log else []
    all_reasons = (*reasons, *own, *narrow, *status, *doubts)
    if (error is not None and error > settings.useless_error) or any(diagnostic.severity == "error" for diagnostic in doubted):
        return Ruling("no", "The model does not hold", all_reasons)
    if own or narrow or doubts or status or error is None or error > settings.usable_error:
        return Ruling("with_care", "The model holds, with care", all_reasons)
    return Ruling("usable", "The model holds", all_reasons)


def _decisive(prediction: Prediction) -> tuple[str, float | None]:
    """Return the signal that decides, and its error [%]."""
    for key, name in SIGNALS.items():
        error = prediction.metrics.get(f"{key}_error_percent")
        if isinstance(error, (int, float)) and np.isfinite(error):
            return name, float(error)
    return "log", None


def prediction_front(
    prediction: Prediction, friction: Model, log: Log, name: str, predicts: str, figure: Picture | None, *, own_log: bool
) -> Front:
    """Return the first page of a prediction."""
    ruling = prediction_ruling(prediction, own_log=own_log)
    source = log.source.name.strip("<>")
    facts = about(f"log {source}, {fixed(log.duration, 's')}", f"model {friction.name}", f"{prediction.mode} mode")
    return Front(
        f"{name}: does the model hold?",
        facts,
        *ruling[:2],
        ruling.reasons,
        answered(
            _quality(prediction, log),
            _typed(ruling),
            _gain(prediction, log, predicts),
            _trust(prediction),
            _next(ruling, prediction, own_log=own_log),
            third="What was predicted",
        ),
        figure,
        "metrics",
    )


def _quality(prediction: Prediction, log: Log) -> list[str]:
    lines = []
    force, length = (prediction.metrics.get(f"{key}_rmse") for key in ("force", "position"))
    if isinstance(force, (int, float)):
        lines.append(f"effort off by {fixed(float(force), unit_of('force', log.kind))}, root mean square")
    if isinstance(length, (int, float)):
        line = f"position off by {length_text(float(length), log.kind)}, root mean square"
        if prediction.position_predicted is not None:
            worst = float(np.max(np.abs(prediction.position - prediction.position_predicted)))
            line += f", {length_text(worst, log.kind)} at most"
        lines.append(line)
    return lines or ["nothing was predicted that could be held against the log"]


def _typed(ruling: Ruling) -> list[str]:
    if ruling.level == "no":
        return ["nothing from this model"]
    return ["nothing new: what the report of the identification says stands"]


def _gain(prediction: Prediction, log: Log, predicts: str) -> list[str]:
    lines = [predicts]
    effort, rmse = prediction.effort, prediction.metrics.get("force_rmse")
    if prediction.mode == "inverse" and effort is not None and isinstance(rmse, (int, float)):
        unit = unit_of("force", log.kind)
        effort_rms = float(np.sqrt(np.mean(np.square(effort))))
        left = f"{fixed(float(rmse), unit)} of {fixed(effort_rms, unit)}"
        lines.append(f"fed forward along this motion, it would leave {left} to the controller, root mean square")
    return lines


def _trust(prediction: Prediction) -> list[str]:
    bands = (("effort", prediction.inside_percent), ("position", prediction.position_inside_percent))
    lines = [f"in its band of 95 %: {percent_text(share)} of the {name}" for name, share in bands if share is not None]
    return lines or ["the model does not say how sure it is: it has no band"]


def _next(ruling: Ruling, prediction: Prediction, *, own_log: bool) -> list[str]:
    advice = [sentence_of(diagnostic.code).advice for diagnostic in prediction.diagnostics if diagnostic.severity != "note"]
    lines = [line for line in dict.fromkeys(advice) if line != "nothing"]
    if own_log:
        return [*lines, "predict another log of this axis, of another motion"]
    if ruling.level == "usable":
        return [*lines, "feed it forward, record the machine without and with it, then `bristle compare`"]
    return [*lines, "identify this log together with the first: `bristle identify FIRST THIS --axis axis.toml`"]
