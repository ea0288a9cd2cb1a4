"""The report of a prediction: a model run on a log, and how far off it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bristle.core.typography import number, with_unit
from bristle.core.variable import Kind
from bristle.report.front import length_text
from bristle.report.fronts.prediction import prediction_front
from bristle.report.further import further_figures
from bristle.report.log_facts import log_facts
from bristle.report.loop_tables import component_table
from bristle.report.messages import notes_of
from bristle.report.page import render
from bristle.report.pictures import pictures_on
from bristle.simulation.result import MODES

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.figures.report_figure import Facts, ReportFigure
    from bristle.logs.log import Log
    from bristle.simulation.result import Prediction

__all__ = ["metrics_in_words", "prediction_report"]


def prediction_report(
    prediction: Prediction,
    *,
    plant: Model,
    friction: Model,
    log: Log,
    command: str,
    axis_name: str,
    provenance: Mapping[str, str],
    banner: str | None = None,
    own_log: bool = False,
    figures: Sequence[ReportFigure] = (),
) -> str:
    """Return the report of a prediction as one HTML page."""
    predicts = MODES.get(prediction.mode, prediction.mode)
    basis: Facts = {"prediction": prediction, "kind": log.kind, "log": log}
    figure = next(iter(pictures_on("prediction", basis)["front"]), None)
    return render(
        "prediction.html",
        provenance=provenance,
        command=command,
        banner=banner,
        front=prediction_front(prediction, friction, log, axis_name, predicts, figure, own_log=own_log),
        axis_name=axis_name,
        metrics=metrics_in_words(prediction),
        notes=(*notes_of(prediction), *log.notes),
        components=component_table("The model", [("Plant", plant), ("Friction", friction)]),
        log=log_facts(log),
        further=further_figures(figures, basis),
    )


def metrics_in_words(prediction: Prediction) -> list[tuple[str, str]]:
    """Return the errors of a prediction, each with its name, set for reading."""
    rows = []
    for key, word in (("force_error_percent", "Effort error"), ("position_error_percent", "Position error")):
        value = prediction.metrics.get(key)
        # Of a position that follows a reference a share of the stroke means nothing.
        of_stroke = prediction.mode == "closed-loop" and key == "position_error_percent"
        if isinstance(value, (int, float)) and not of_stroke:
            rows.append((word, f"{number(float(value), digits=3)} %"))
    for signal, share in (("effort", prediction.inside_percent), ("position", prediction.position_inside_percent)):
        if share is not None:
            rows.append((f"Measured {signal} inside the 95 % band", f"{number(share, digits=3)} %"))
    rmse, unit = prediction.metrics.get("force_rmse"), prediction.metrics.get("force_unit")
    if isinstance(rmse, (int, float)):
        rows.append(("Effort error, root mean square", with_unit(float(rmse), str(unit or "N"))))
    rmse, unit = prediction.metrics.get("position_rmse"), prediction.metrics.get("position_unit")
    if isinstance(rmse, (int, float)):
        kind: Kind = "rotational" if unit == "rad" else "translational"
        rows.append(("Position error, root mean square", length_text(float(rmse), kind).replace("\u00a0", " ")))
    return rows
