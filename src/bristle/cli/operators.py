"""``bristle identify`` and ``bristle predict`` on recorded hysteresis: operators, of friction or of magnets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from bristle.cli.options import Output, size_limit
from bristle.cli.signals import INTERRUPTED
from bristle.cli.terminal import complain, exit_code

if TYPE_CHECKING:
    from bristle.core import Content


def identify_operators(
    logs: list[Path], axes: list[Content], model: str | None, output: Output
) -> int:
    """Identify hysteresis operators from recorded curves, write the results, and return the exit code."""
    from bristle.core import InputError
    from bristle.files import provenance, read_curves, write_operator
    from bristle.identification.hysteresis import identify_operator
    from bristle.report.operators import comparison_of_operators, operator_report, operator_summary
    from bristle.report.results import write_report

    if len(logs) > 1 or len(axes) > 1:
        raise InputError(
            "needs a single file of curves, with its axis file",
            path="LOG",
            value=f"{len(logs)} files",
            mend="Put all curves into one file, with a column that numbers them",
        )
    log = logs[0]
    axis = axes[0]
    with output.opened("identifying", [log, axis]) as (folder, report):
        recorded = read_curves(log, axis, size_limit=size_limit())
        identification = identify_operator(recorded, model or "all", progress=report)
        source = provenance(output.command, log=recorded, axis=axis)
        unfinished = identification.unfinished
        banner = None
        if unfinished:
            source |= {"unfinished": unfinished}
            banner = f"Unfinished; {unfinished}."
        summary = operator_summary(identification, provenance=source)
        if folder:
            write_operator(
                folder / "model.toml",
                identification.best.operator,
                identification.best.offset,
                provenance=source,
            )
            page = operator_report(
                identification,
                name=recorded.name,
                command=output.command,
                provenance=source,
                banner=banner,
            )
            write_report(folder, page, summary)

    notes = (*identification.notes, *(f"Note: {note}" for note in recorded.notes))
    output.tell(summary, comparison_of_operators(identification), *notes)
    if unfinished:
        complain(unfinished)
    return exit_code(unfinished, INTERRUPTED)


def predict_operator(model: Content, log: Path, axis: Content | None, output: Output) -> None:
    """Predict recorded curves with an operator."""
    from bristle.core import InputError, unit_of, with_unit
    from bristle.files import provenance, read_curves, read_operator
    from bristle.identification.hysteresis import predict_operator as predicted
    from bristle.report.operators import operator_prediction_report, operator_prediction_summary
    from bristle.report.results import write_report

    if axis is None:
        raise InputError(
            "is required: the axis file names the columns of input and output",
            path="--axis",
            mend="Name input and output under [columns] of an axis file",
        )
    with output.opened("predicting", [model, log, axis]) as (folder, _):
        operator, offset, _ = read_operator(model)
        recorded = read_curves(log, axis, size_limit=size_limit())
        if recorded.kind != operator.kind:
            raise InputError(
                "model and curves are of different kinds",
                path=str(model.source),
                value=operator.kind,
                allowed=recorded.kind,
            )
        prediction = predicted(operator, recorded, offset)
        source = provenance(output.command, model=model, log=recorded, axis=axis)
        summary = operator_prediction_summary(prediction, operator, recorded, provenance=source)
        if folder:
            name = recorded.name
            page = operator_prediction_report(
                prediction, operator, recorded, name=name, command=output.command, provenance=source
            )
            write_report(folder, page, summary)

    rmse = with_unit(prediction.rmse, unit_of("force", operator.kind))
    notes = (f"Note: {note}" for note in recorded.notes)
    output.tell(
        summary, f"Error: {rmse} rms, {prediction.error_percent:.3g} % of full scale", *notes
    )
