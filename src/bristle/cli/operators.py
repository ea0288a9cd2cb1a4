"""``bristle identify`` and ``bristle predict`` on recorded hysteresis: operators, of friction or of magnets."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from bristle.cli.failure import INTERRUPTED
from bristle.cli.options import Figures
from bristle.cli.terminal import complain, progress, say, show_table

if TYPE_CHECKING:
    from bristle.core.content import Content

__all__ = ["identify_operators", "predict_operator"]


def identify_operators(
    logs: list[Path],
    axes: list[Content],
    model: str | None,
    out: Path | None,
    *,
    force: bool,
    as_json: bool,
    command: str,
    limit: int,
    figures: Figures = (None, None),
) -> int:
    """Identify hysteresis operators from recorded curves, write them where `out` says, and return the exit code."""
    from bristle.core import InputError
    from bristle.files.curves import read_curve_columns, read_curves
    from bristle.files.operator import write_operator
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.hysteresis.identification import FITTED, identify_operator
    from bristle.report.figure_files import figure_files
    from bristle.report.operators import comparison_of_operators, operator_report, operator_summary
    from bristle.report.results import write_report

    if len(logs) > 1 or len(axes) > 1:
        raise InputError(
            "takes one file of curves, and its axis file",
            path="LOG",
            value=f"{len(logs)} files",
            mend="Put all curves into one file, a column telling them apart",
        )
    log, axis = logs[0], axes[0]
    with (
        results_folder(out, force=force, reads=[log, axis]) if out else nullcontext() as folder,
        progress("identifying") as report,
        figure_files(folder, *figures),
    ):
        recorded = read_curves(log, axis, size_limit=limit)
        identification = identify_operator(recorded, model or tuple(FITTED), progress=report)
        source = provenance(command, log=recorded, axis=axis)
        source |= {"unfinished": identification.unfinished} if identification.unfinished else {}
        summary = operator_summary(identification, provenance=source)
        if folder:
            write_operator(folder / "model.toml", identification.best.operator, identification.best.offset, provenance=source)
            page = operator_report(
                identification,
                name=read_curve_columns(axis).name,
                command=command,
                provenance=source,
                banner=f"Unfinished; {identification.unfinished}." if identification.unfinished else None,
            )
            write_report(folder, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        show_table(comparison_of_operators(identification))
        for note in identification.notes:
            say(note)
        for note in recorded.notes:
            say(f"Note: {note}")
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    if identification.unfinished:
        complain(identification.unfinished)
    return INTERRUPTED if identification.unfinished else 0


def predict_operator(
    model: Content,
    log: Path,
    axis: Content | None,
    out: Path | None,
    *,
    force: bool,
    as_json: bool,
    command: str,
    limit: int,
    figures: Figures = (None, None),
) -> None:
    """Predict recorded curves with an operator."""
    from bristle.core import InputError
    from bristle.core.typography import with_unit
    from bristle.core.variable import unit_of
    from bristle.files.curves import read_curve_columns, read_curves
    from bristle.files.operator import read_operator
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.hysteresis.identification import predict_operator as predicted
    from bristle.report.figure_files import figure_files
    from bristle.report.operators import operator_prediction_report, operator_prediction_summary
    from bristle.report.results import write_report

    if axis is None:
        raise InputError(
            "is needed: it says which columns are input and output", path="--axis", mend="Name them under [columns] of an axis file"
        )
    with (
        results_folder(out, force=force, reads=[model, log, axis]) if out else nullcontext() as folder,
        progress("predicting"),
        figure_files(folder, *figures),
    ):
        operator, offset, _ = read_operator(model)
        recorded = read_curves(log, axis, size_limit=limit)
        if recorded.kind != operator.kind:
            raise InputError("model and curves are of different kinds", path=str(model.source), value=operator.kind, allowed=recorded.kind)
        prediction = predicted(operator, recorded, offset)
        source = provenance(command, model=model, log=recorded, axis=axis)
        summary = operator_prediction_summary(prediction, operator, recorded, provenance=source)
        if folder:
            page = operator_prediction_report(
                prediction, operator, recorded, name=read_curve_columns(axis).name, command=command, provenance=source
            )
            write_report(folder, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        rmse = with_unit(prediction.rmse, unit_of("force", operator.kind))
        say(f"Error: {rmse} root mean square, {prediction.error_percent:.3g} % of full scale")
        for note in recorded.notes:
            say(f"Note: {note}")
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
