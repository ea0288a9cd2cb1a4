"""The report of a prediction: a model run on a log, and how far off it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.typography import number, with_unit
from bristle.core.variable import Kind
from bristle.report.front import length_text
from bristle.report.fronts.prediction import prediction_front
from bristle.report.log_facts import log_facts
from bristle.report.loop_tables import component_table
from bristle.report.messages import notes_of
from bristle.report.page import Picture, picture, render

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.logs.log import Log
    from bristle.simulation.result import Prediction

__all__ = ["metrics_in_words", "prediction_picture", "prediction_report"]

MODES = {
    "inverse": "the effort, from the measured motion",
    "closed-loop": "effort and motion, from the reference and the controller of the axis",
    "open-loop": "the motion, from the measured effort",
}


def prediction_report(
    prediction: Prediction, *, plant: Model, friction: Model, log: Log, command: str, axis_name: str,
    provenance: Mapping[str, str], banner: str | None = None, own_log: bool = False,
) -> str:  # fmt: skip
    """Return the report of a prediction as one HTML page.

    Parameters
    ----------
    prediction : Prediction
        What the model says of the log.
    plant, friction : Model
        The model.
    log : Log
        The log.
    command : str
        The command that repeats it.
    axis_name : str
        What people call the axis.
    provenance : mapping of str to str
        Versions, files, checksums.
    banner : str, optional
        What a reader must know before anything else.
    own_log : bool
        Whether the model was fitted to this very log.
    """
    predicts, pictures = MODES.get(prediction.mode, prediction.mode), prediction_picture(prediction, log.kind)
    return render(
        "prediction.html",
        provenance=provenance,
        command=command,
        banner=banner,
        front=prediction_front(
            prediction, friction, log, axis_name, predicts, pictures.get("prediction"), own_log=own_log
        ),
        axis_name=axis_name,
        metrics=metrics_in_words(prediction),
        notes=(*notes_of(prediction), *log.notes),
        components=component_table("The model", [("Plant", plant), ("Friction", friction)]),
        log=log_facts(log),
    )


def prediction_picture(prediction: Prediction, kind: Kind) -> dict[str, Picture]:
    """Return the figure of a prediction, where it predicts anything."""
    if prediction.effort_predicted is None and prediction.position_predicted is None:
        return {}
    from bristle.figures import prediction as draw

    return {
        "prediction": picture(
            "prediction", lambda: draw(prediction, kind), f"Measured and predicted signals, {prediction.mode} mode",
            f"The model run on the log in {prediction.mode} mode: {MODES.get(prediction.mode, '')}. Where the light "
            "line looks out from under the dark one, what was measured is not predicted."
            + " Shaded: where 95 % of what is measured are expected." * _has_band(prediction),
        )
    }  # fmt: skip


def _has_band(prediction: Prediction) -> bool:
    return prediction.half_width is not None or prediction.position_half_width is not None


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
