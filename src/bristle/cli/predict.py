"""``bristle predict``: prediction of a log by a model."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from bristle.cli.options import (
    LOG_FILE,
    AllowCode,
    AxisFile,
    FigureFiles,
    Output,
    Readers,
    own_figures,
    own_readers,
    refuse,
    size_limit,
    toml_content,
)
from bristle.cli.terminal import NO

EXAMPLE = """Example:
  bristle predict results/model.toml other.mat --axis axis.toml --mode closed-loop"""


def predict(
    model: Annotated[Path, typer.Argument(metavar="MODEL.toml", help="A model file written by identify.")],
    log: Annotated[Path, typer.Argument(metavar="LOG", help=f"A log: {LOG_FILE}")],
    *,
    axis: AxisFile = None,
    allow_code: AllowCode = False,
    reader: Readers = None,
    mode: Annotated[str, typer.Option("--mode", metavar="MODE", help="Prediction mode: inverse, closed-loop or open-loop.")] = "inverse",
    output: Output,
    figure: FigureFiles = None,
) -> int:
    """Predict a log with an identified model.

    Mode inverse predicts the effort from the measured motion. Mode closed-loop predicts effort and motion from the
    reference, with the controller of the axis file. Mode open-loop predicts the motion from the measured effort.

    If the model is a hysteresis operator, LOG contains its input and output, and bristle predicts the output.
    """
    from bristle.core import InputError, Status
    from bristle.files import holds_operator, origins_of_code, provenance, read_axis, read_model
    from bristle.identification import Bands
    from bristle.logs import read_log
    from bristle.prediction import predict as predicted
    from bristle.report.messages import message
    from bristle.report.prediction import metrics_in_words, prediction_report, prediction_ruling, prediction_summary
    from bristle.report.results import write_report
    from bristle.testing import admit

    output.context.with_resource(own_readers(reader))
    file, axis_file = toml_content(model), toml_content(axis)
    if holds_operator(file):
        from bristle.cli.operators import predict_operator

        refuse({"--figure": figure}, "applies to friction, not to recorded curves")
        predict_operator(file, log, axis_file, output)
        return 0
    further, code = own_figures(figure, "predict", has_folder=output.out is not None)
    with output.opened("predicting", [file, log, axis_file]) as (folder, _):
        plant, friction, facts = read_model(file, allow_code=allow_code)
        if plant is None:
            raise InputError("is missing", path=f"{file.source}: plant", mend='Write [plant], model = "inertia" and M = ...')
        admit(friction)
        described = read_axis(axis_file) if axis_file else None
        recorded = read_log(log, described, size_limit=size_limit())
        bands = Bands(**facts["bands"]) if facts["bands"] else None
        prediction = predicted(plant, friction, recorded, described, mode, bands=bands, **facts["treatment"])
        own = origins_of_code([friction.component])
        source = provenance(output.command, model=file, log=recorded, axis=axis_file, code=own, figure=code)
        own_log = "::" not in str(log) and _was_fitted(recorded, facts["provenance"])
        summary = prediction_summary(prediction, friction=friction, notes=recorded.notes, provenance=source, own_log=own_log)
        if folder:
            page = prediction_report(
                prediction,
                plant=plant,
                friction=friction,
                log=recorded,
                command=output.command,
                axis_name=described.name if described else log.stem,
                provenance=source,
                own_log=own_log,
                figures=further,
            )
            write_report(folder, page, summary)
    ruling = prediction_ruling(prediction, own_log=own_log)
    found = [(diagnostic.severity, message(diagnostic)) for diagnostic in prediction.diagnostics]
    output.tell(
        summary,
        f"{ruling.words}: {'; '.join(ruling.reasons)}." if ruling.reasons else f"{ruling.words}.",
        *(f"{word}: {value}" for word, value in metrics_in_words(prediction)),
        *(f"Note: {note}" for note in (*recorded.notes, *(text for severity, text in found if severity == "note"))),
        warnings=[
            *(f"{severity}: {text}" for severity, text in found if severity != "note"),
            *([] if prediction.status is Status.OK else [prediction.status.sentence]),
        ],
    )
    return 0 if summary["completed"] else NO


def _was_fitted(recorded: Any, fitted: Mapping[str, Any]) -> bool:
    """Return whether a model was fitted to this log: same file and columns, and a common span of time."""
    checksum = recorded.origin.checksum
    keys = [key.removesuffix("_sha256") for key, value in fitted.items() if key.endswith("_sha256") and value == checksum]
    return bool(checksum) and any(recorded.is_part(fitted.get(f"{key}_part", "")) for key in keys)
