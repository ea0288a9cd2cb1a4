"""The report of a prediction: the verdict on a model on another log, and its errors."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core import Kind, Model, Status, unit_of, with_unit
from bristle.identification import Settings
from bristle.logs import Log
from bristle.report.cards import COMPARE, Card, Step
from bristle.report.log_tables import log_facts
from bristle.report.loops import component_table, prediction_as_data
from bristle.report.messages import advice_of, notes_of
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.sentences import SENTENCES
from bristle.report.table import fixed, length_text, percent_text, short_text
from bristle.simulation import MODES, Prediction


def prediction_report(
    prediction: Prediction,
    *,
    plant: Model,
    friction: Model,
    log: Log,
    axis_name: str,
    own_log: bool = False,
    **options: Any,
) -> str:
    """Return the report of a prediction as an HTML page; options as of `report_page`."""
    notes = (*notes_of(prediction), *log.notes)
    errors = Block(
        "facts",
        metrics_in_words(prediction),
        ("Errors, root mean square. Percentages are relative to the measured signal",),
    )
    sections = [
        Section(
            "metrics",
            "Errors",
            [errors, Block("items", (*_further_lines(prediction, log.kind), *notes))],
        ),
        Section(
            "model",
            "The model",
            [component_table("The model", [("Plant", plant), ("Friction", friction)])],
            "Model",
        ),
        Section("log", "The log", [Block("facts", log_facts(log), ("Recorded channels",))], "Log"),
    ]
    front = _front(prediction, friction, log, axis_name, own_log=own_log)
    facts = {"prediction": prediction, "kind": log.kind, "log": log, "log_name": prediction.log}
    return report_page("prediction", facts, front, sections, **options)


def metrics_in_words(prediction: Prediction) -> list[tuple[str, str]]:
    """Return the errors of a prediction by name, as text."""
    rows, metrics = [], prediction.metrics
    for key, word in (
        ("force_error_percent", "Effort error"),
        ("position_error_percent", "Position error"),
    ):
        # In closed loop the position follows the reference, so its error in percent means little.
        of_stroke = prediction.mode == "closed-loop" and key == "position_error_percent"
        if isinstance(value := metrics.get(key), (int, float)) and not of_stroke:
            rows.append((word, f"{short_text(float(value))} %"))
    bands = _bands(prediction).items()
    rows += [
        (f"Measured {signal} inside the 95 % band", f"{short_text(share)} %")
        for signal, share in bands
    ]
    if isinstance(rmse := metrics.get("force_rmse"), (int, float)):
        rows.append(
            (
                "Effort error, root mean square",
                with_unit(float(rmse), str(metrics.get("force_unit") or "N")),
            )
        )
    if isinstance(rmse := metrics.get("position_rmse"), (int, float)):
        kind: Kind = "rotational" if metrics.get("position_unit") == "rad" else "translational"
        rows.append(
            (
                "Position error, root mean square",
                length_text(float(rmse), kind).replace("\u00a0", " "),
            )
        )
    return rows


def prediction_summary(
    prediction: Prediction,
    *,
    friction: Model,
    notes: Sequence[str],
    provenance: Mapping[str, str],
    own_log: bool = False,
) -> dict[str, Any]:
    """Return a prediction in numbers; `notes` belong to the log, `own_log` marks the log of the fit."""
    verdict = prediction_ruling(prediction, own_log=own_log).as_data()
    head = {"model": friction.name, "kind": friction.kind, "verdict": verdict}
    return head | prediction_as_data(prediction) | {"log_notes": notes, "provenance": provenance}


def _bands(prediction: Prediction) -> dict[str, float]:
    """Return the share of each signal with a 95 % band that is inside its band [%]."""
    shares = {"effort": prediction.inside_percent, "position": prediction.position_inside_percent}
    return {name: share for name, share in shares.items() if share is not None}


def prediction_ruling(prediction: Prediction, *, own_log: bool = False) -> Ruling:
    """Return the verdict on a model on a log, with its reasons.

    The predicted effort decides, because the position mostly follows the reference.
    """
    doubted = [diagnostic for diagnostic in prediction.diagnostics if diagnostic.severity != "note"]
    doubts = list(dict.fromkeys(SENTENCES[diagnostic.code].means for diagnostic in doubted))
    if prediction.status is Status.NOT_FINITE:
        return Ruling("no", "It does not run", (prediction.status.sentence, *doubts))
    signals = {"effort": "force_error_percent", "position": "position_error_percent"}
    errors = {signal: prediction.metrics.get(key) for signal, key in signals.items()}
    finite = {
        signal: float(value)
        for signal, value in errors.items()
        if isinstance(value, (int, float)) and np.isfinite(value)
    }
    signal, error = next(iter(finite.items()), ("log", 0.0))
    care = (
        ["the model was fitted to this log, so its error on other logs is unknown"]
        if own_log
        else []
    )
    # Fewer than 80 %: the band is too narrow.
    care += [
        f"only {percent_text(share)} of the measured {name} is inside the 95 % band"
        for name, share in _bands(prediction).items()
        if share < 80.0
    ]
    care += [] if prediction.status is Status.OK else [prediction.status.sentence]
    reasons = (
        ([f"the error is {percent_text(error)} of the {signal} of this log"] if finite else [])
        + care
        + doubts
    )
    if error > Settings().useless_error or any(
        diagnostic.severity == "error" for diagnostic in doubted
    ):
        return Ruling("no", "The model is not valid here", tuple(reasons))
    if care or doubts or not finite or error > Settings().usable_error:
        return Ruling("with_care", "The model is valid, with care", tuple(reasons))
    return Ruling("usable", "The model is valid", tuple(reasons))


def _further_lines(prediction: Prediction, kind: Kind) -> list[str]:
    """Return the mode, the effort that a controller would supply, the largest position error, and the advice on warnings."""
    lines, force = (
        [f"{prediction.mode} mode: {MODES.get(prediction.mode, '')}"],
        prediction.metrics.get("force_rmse"),
    )
    if (
        isinstance(force, (int, float))
        and prediction.mode == "inverse"
        and prediction.effort is not None
    ):
        efforts = (float(force), float(np.sqrt(np.mean(np.square(prediction.effort)))))
        rest, effort = (fixed(value, unit_of("force", kind)) for value in efforts)
        lines.append(
            f"with this feedforward the controller would supply {rest} instead of {effort}, root mean square"
        )
    if (
        isinstance(prediction.metrics.get("position_rmse"), (int, float))
        and prediction.position_predicted is not None
    ):
        largest = float(np.max(np.abs(prediction.position - prediction.position_predicted)))
        lines.append(f"largest position error: {length_text(largest, kind)}")
    return lines + advice_of(
        diagnostic.code for diagnostic in prediction.diagnostics if diagnostic.severity != "note"
    )


def _front(prediction: Prediction, friction: Model, log: Log, name: str, *, own_log: bool) -> Front:
    ruling, kind = prediction_ruling(prediction, own_log=own_log), log.kind
    then = "identify both logs together: `bristle identify FIRST THIS --axis axis.toml`"
    if own_log:
        then = (
            "predict a log of another motion: `bristle predict model.toml OTHER --axis axis.toml`"
        )
    elif ruling.level == "usable":
        then = f"record without and with this feedforward: {COMPARE}"
    force, length, percent = (
        prediction.metrics.get(key)
        for key in ("force_rmse", "position_rmse", "force_error_percent")
    )
    title, cards, unit = "No signal to compare", list[Card](), unit_of("force", kind)
    if isinstance(force, (int, float)):
        effort = (
            0.0
            if prediction.effort is None
            else float(np.sqrt(np.mean(np.square(prediction.effort))))
        )
        cards.append(
            Card(
                "Effort error, rms",
                fixed(float(force), unit),
                f"of {fixed(effort, unit)}" if effort else "",
            )
        )
    if isinstance(length, (int, float)):
        text = length_text(float(length), kind)
        title = f"Prediction error: {text}, rms"
        cards.append(Card("Position error, rms", text))
    if isinstance(percent, (int, float)) and np.isfinite(percent):
        title = f"Prediction error: {percent_text(float(percent))} of the effort"
    bands = [
        Card(f"{name.capitalize()} inside the band", percent_text(share), "95 % band")
        for name, share in _bands(prediction).items()
    ]
    source, ruling = (
        log.source.name.strip("<>"),
        ruling.beyond_title if cards and ruling.level != "no" else ruling,
    )
    return Front(
        f"{name}: is the model valid?",
        about(f"log {source}, {fixed(log.duration, 's')}", f"model {friction.name}"),
        ruling,
        title=title,
        basis=f"({source}, {prediction.mode} mode)" if source else f"({prediction.mode} mode)",
        cards=[*cards, *(bands or [Card("95 % band", "–", "not in the model", open=True)])],
        next=Step.of(then),
    )
