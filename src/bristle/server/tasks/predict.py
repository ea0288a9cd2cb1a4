"""What the identified model says of logs that it was not fitted to."""

from __future__ import annotations

from bristle.core.errors import InputError
from bristle.server.tasks.errand import Answer, Errand
from bristle.server.tasks.thinned import thinned

__all__ = ["predict"]

MODE = "inverse"


def predict(errand: Errand) -> Answer:
    """Return the error of the model on each log that was held out."""
    import bristle
    from bristle.report.prediction import prediction_ruling

    if errand.results is None:
        raise InputError("is missing", path="model", mend="Identify first")
    axis, model, logs = errand.axis(), bristle.load(errand.results), []
    chosen = [log for log in errand.logs if log.role == "held_out"]
    for place, log in enumerate(chosen):
        errand.report(place / len(chosen), f"predicting {log.label}")
        recorded = bristle.read_log(log.content, axis, size_limit=errand.size_limit)
        prediction = model.predict(recorded, MODE, axis=axis)
        assert prediction.effort is not None
        assert prediction.effort_predicted is not None
        ruling = prediction_ruling(prediction)
        logs.append(
            {
                "label": log.label,
                "error_percent": prediction.metrics["force_error_percent"],
                "inside_percent": prediction.inside_percent,
                "verdict": ruling.as_data(),
                "time": thinned(prediction.time, prediction.effort, prediction.effort_predicted),
            }
        )
    return {"logs": len(logs)}, {"logs": logs, "mode": MODE, "kind": axis.kind}
