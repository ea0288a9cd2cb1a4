"""``bristle predict``: what a model says of a log."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import (
    LOG_FILE,
    AllowCode,
    AxisFile,
    Data,
    FigureFiles,
    Figures,
    Force,
    Formats,
    Json,
    Out,
    Readers,
    SizeLimit,
    bytes_asked,
    own_figures,
    own_readers,
)
from bristle.cli.terminal import complain, progress, say

if TYPE_CHECKING:
    from bristle.core.content import Content
    from bristle.logs import Log
    from bristle.simulation import Prediction

__all__ = ["EXAMPLE", "predict"]

EXAMPLE = """Example:
  bristle predict results/model.toml other.mat --axis axis.toml --mode closed-loop"""


def predict(
    context: typer.Context,
    model: Annotated[Path, typer.Argument(metavar="MODEL.toml", help="A model file, as identify writes it.")],
    log: Annotated[Path, typer.Argument(metavar="LOG", help=f"A log: {LOG_FILE}")],
    *,
    axis: AxisFile = None,
    allow_code: AllowCode = False,
    reader: Readers = None,
    size_limit: SizeLimit = None,
    mode: Annotated[str, typer.Option("--mode", metavar="MODE", help="inverse, closed-loop or open-loop.")] = "inverse",
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    figure: FigureFiles = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Predict a log with an identified model.

    inverse: the effort from the measured motion. closed-loop: effort and motion from the reference, with the
    controller of the axis file. open-loop: the motion from the measured effort. A model of a hysteresis operator
    predicts recorded curves.
    """
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.operator import holds_operator
    from bristle.files.toml import TOML_LIMIT

    context.with_resource(own_readers(reader))
    limit = bytes_asked(size_limit)
    file = content_of(model, limit=TOML_LIMIT)
    described = None if axis is None else content_of(axis, limit=TOML_LIMIT)
    if holds_operator(file):
        if figure:
            raise InputError("is for friction, not for recorded curves", path="--figure", mend="Leave --figure out")
        from bristle.cli.operators import predict_operator

        predict_operator(file, log, described, out, force=force, as_json=as_json, command=context.obj, limit=limit, figures=(formats, data))
        return 0
    return _predict_friction(
        file,
        log,
        described,
        mode,
        out,
        allow_code=allow_code,
        force=force,
        as_json=as_json,
        command=context.obj,
        limit=limit,
        figures=(formats, data),
        own=figure,
    )


def _predict_friction(
    model: Content,
    log: Path,
    axis_file: Content | None,
    mode: str,
    out: Path | None,
    *,
    allow_code: bool,
    force: bool,
    as_json: bool,
    command: str,
    limit: int,
    figures: Figures,
    own: list[Path] | None,
) -> int:
    from bristle.core import InputError
    from bristle.files.axis import read_axis
    from bristle.files.model import read_model
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.files.user_model import origins_of_code
    from bristle.identification.prediction_interval import Bands
    from bristle.logs import read_log
    from bristle.prediction import predict as predicted
    from bristle.report.figure_files import figure_files
    from bristle.report.summary import prediction_summary
    from bristle.testing import admit

    further, code = own_figures(own, "predict", has_folder=out is not None)
    with (
        results_folder(out, force=force, reads=[model, log, axis_file]) if out else nullcontext() as folder,
        progress("predicting"),
        figure_files(folder, *figures),
    ):
        plant, friction, facts = read_model(model, allow_code=allow_code)
        if plant is None:
            raise InputError("is missing", path=f"{model.source}: plant", mend='Write [plant], model = "inertia" and M = ...')
        admit(friction)
        described = read_axis(axis_file) if axis_file else None
        recorded = read_log(log, described, size_limit=limit)
        bands = Bands(**facts["bands"]) if facts["bands"] else None
        prediction = predicted(plant, friction, recorded, described, mode, bands=bands, **facts["treatment"])
        source = provenance(command, model=model, log=recorded, axis=axis_file, code=origins_of_code([friction.component]), figure=code)
        own_log = "::" not in str(log) and _was_fitted_to(facts["provenance"], recorded)
        summary = prediction_summary(prediction, friction=friction, notes=recorded.notes, provenance=source, own_log=own_log)
        if folder:
            from bristle.report.prediction import prediction_report
            from bristle.report.results import write_report

            page = prediction_report(
                prediction,
                plant=plant,
                friction=friction,
                log=recorded,
                command=command,
                axis_name=described.name if described else log.stem,
                provenance=source,
                own_log=own_log,
                figures=further,
            )
            write_report(folder, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        _show(prediction, recorded.notes, own_log=own_log)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    return 0 if summary["completed"] else NO


def _was_fitted_to(provenance: Mapping[str, str], recorded: Log) -> bool:
    """Return whether a model was fitted to a log: to the same columns of the same file, at a time that both have."""
    checksum, end = recorded.origin.checksum, "_sha256"
    keys = [key.removesuffix(end) for key, value in provenance.items() if key.endswith(end) and value == checksum]
    return bool(checksum) and any(recorded.is_part(provenance.get(f"{key}_part", "")) for key in keys)


def _show(prediction: Prediction, log_notes: tuple[str, ...], *, own_log: bool) -> None:
    from bristle.core.status import Status
    from bristle.report.fronts.prediction import prediction_ruling
    from bristle.report.messages import message
    from bristle.report.prediction import metrics_in_words

    ruling = prediction_ruling(prediction, own_log=own_log)
    say(f"{ruling.words}: {'; '.join(ruling.reasons)}." if ruling.reasons else f"{ruling.words}.")
    for word, value in metrics_in_words(prediction):
        say(f"{word}: {value}")
    for note in log_notes:
        say(f"Note: {note}")
    for diagnostic in prediction.diagnostics:
        if diagnostic.severity == "note":
            say(f"Note: {message(diagnostic)}")
        else:
            complain(f"{diagnostic.severity}: {message(diagnostic)}")
    if prediction.status is not Status.OK:
        complain(prediction.status.sentence)
