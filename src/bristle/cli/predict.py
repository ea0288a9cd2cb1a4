"""``bristle predict``: prediction of a log by a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.commands import SPELLINGS
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
from bristle.cli.terminal import exit_code

if TYPE_CHECKING:
    from bristle.core import Axis, Content
    from bristle.logs import Log
    from bristle.report.figures import ReportFigure
    from bristle.simulation import Prediction

EXAMPLE = """Example:
  bristle predict results/model.toml other.mat --axis axis.toml --mode closed-loop
  bristle predict arm other.csv --out prediction"""


def predict(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL.toml",
            help="A model file, or the results of an arm (DIR), both from identify.",
        ),
    ],
    log: Annotated[Path, typer.Argument(metavar="LOG", help=f"A log: {LOG_FILE}")],
    *,
    axis: AxisFile = None,
    allow_code: AllowCode = False,
    reader: Readers = None,
    mode: Annotated[
        str,
        typer.Option(
            "--mode", metavar="MODE", help="Prediction mode: inverse, closed-loop or open-loop."
        ),
    ] = "inverse",
    output: Output,
    figure: FigureFiles = None,
) -> int:
    """Predict a log with an identified model.

    Mode inverse predicts the effort from the measured motion. Mode closed-loop predicts effort and motion from the
    reference, with the controller of the axis file. Mode open-loop predicts the motion from the measured effort.

    With the results of an arm, bristle predicts the efforts of all joints of LOG, with the bodies of the arm along LOG.

    If the model is a hysteresis operator, LOG contains its input and output, and bristle predicts the output.
    """
    from bristle.core import Status
    from bristle.files import holds_operator, read_axis
    from bristle.logs import read_log
    from bristle.report.messages import message
    from bristle.report.prediction import metrics_in_words
    from bristle.report.results import write_report

    output.context.with_resource(own_readers(reader))
    if model.is_dir():
        refuse(
            {"--axis": axis},
            "is part of the results of an arm",
            "Leave it out, or name the model.toml of one axis",
        )
        refuse(
            {"--figure": figure},
            "applies to the report of one axis",
            "Name the model.toml of one axis",
        )
        predict_arm = resolve_name(SPELLINGS["predict ARM"])
        return predict_arm(model, log, mode, output, allow_code=allow_code)
    file = toml_content(model)
    axis_file = toml_content(axis)
    if holds_operator(file):
        from bristle.cli.operators import predict_operator

        refuse({"--figure": figure}, "applies to friction, not to recorded curves")
        predict_operator(file, log, axis_file, output)
        return 0
    further, code = own_figures(figure, "predict", has_folder=output.out is not None)
    with output.opened("predicting", [file, log, axis_file]) as (folder, _):
        described = None
        if axis_file:
            described = read_axis(axis_file)
        recorded = read_log(log, described, size_limit=size_limit())
        options = {
            "mode": mode,
            "allow_code": allow_code,
            "axis_file": axis_file,
            "figures": further,
            "code": code,
        }
        prediction, summary, page = predicted_log(
            file, recorded, described, output, page=bool(folder), **options
        )
        if folder:
            write_report(folder, page, summary)
    verdict = summary["verdict"]["words"]
    reasons = summary["verdict"]["reasons"]
    if reasons:
        verdict += f": {'; '.join(reasons)}"
    found = [(diagnostic.severity, message(diagnostic)) for diagnostic in prediction.diagnostics]
    warnings = [f"{severity}: {text}" for severity, text in found if severity != "note"]
    if prediction.status is not Status.OK:
        warnings.append(prediction.status.sentence)
    output.tell(
        summary,
        f"{verdict}.",
        *(f"{word}: {value}" for word, value in metrics_in_words(prediction)),
        *(
            f"Note: {note}"
            for note in (*recorded.notes, *(text for severity, text in found if severity == "note"))
        ),
        warnings=warnings,
    )
    return exit_code(not summary["completed"])


def predicted_log(
    file: Content,
    log: Log,
    axis: Axis | None,
    output: Output,
    *,
    mode: str,
    allow_code: bool,
    page: bool,
    axis_file: Any = None,
    figures: Sequence[ReportFigure] = (),
    code: Any = (),
) -> tuple[Prediction, dict[str, Any], str]:
    """Return the prediction of a log by a model file, its numbers and, on request, its page."""
    from bristle.contract import admit
    from bristle.core import InputError
    from bristle.files import origins_of_code, provenance, read_model
    from bristle.prediction import predict as predicted
    from bristle.report.prediction import prediction_report, prediction_summary

    plant, friction, facts = read_model(file, allow_code=allow_code)
    if plant is None:
        raise InputError(
            "is missing",
            path=f"{file.source}: plant",
            mend='Write [plant], model = "inertia" and M = ...',
        )
    admit(friction)
    prediction = predicted(
        plant, friction, log, axis, mode, bands=facts["bands"] or None, **facts["treatment"]
    )
    own = origins_of_code([friction.component])
    source = provenance(output.command, model=file, log=log, axis=axis_file, code=own, figure=code)
    own_log = "::" not in log.origin.name and _was_fitted(log, facts["provenance"])
    about = {"friction": friction, "provenance": source, "own_log": own_log}
    summary = prediction_summary(prediction, notes=log.notes, **about)
    name = log.source.stem
    if axis:
        name = axis.name
    options = about | {
        "plant": plant,
        "log": log,
        "command": output.command,
        "axis_name": name,
        "figures": figures,
    }
    text = ""
    if page:
        text = prediction_report(prediction, **options)
    return prediction, summary, text


def _was_fitted(recorded: Any, fitted: Mapping[str, Any]) -> bool:
    """Return whether a model was fitted to this log: same file and columns, and a common span of time."""
    checksum = recorded.origin.checksum
    keys = [
        key.removesuffix("_sha256")
        for key, value in fitted.items()
        if key.endswith("_sha256") and value == checksum
    ]
    return bool(checksum) and any(recorded.is_part(fitted.get(f"{key}_part", "")) for key in keys)
