"""``bristle log``: what is in a log."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.failure import NO
from bristle.cli.options import (
    LOG_FILE,
    AxisFile,
    Data,
    Force,
    Formats,
    Json,
    Out,
    Readers,
    SizeLimit,
    bytes_asked,
    own_readers,
)
from bristle.cli.terminal import complain, say, show_table

if TYPE_CHECKING:
    from bristle.core import Axis
    from bristle.core.content import Content
    from bristle.files.proposal import Proposal
    from bristle.files.results import Results
    from bristle.logs.summary import Summary

__all__ = ["EXAMPLE", "log"]

EXAMPLE = """Example:
  bristle log recording.csv --write axis.toml
  bristle log recording.csv --axis axis.toml --out what-is-in-it"""
MOST_COLUMNS = 100  # in the terminal


def log(
    context: typer.Context,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help=f"A log: {LOG_FILE}",
        ),
    ],
    axis: AxisFile = None,
    write: Annotated[
        Path | None,
        typer.Option("--write", metavar="AXIS.toml", help="Write the axis file that the log itself speaks of."),
    ] = None,
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    reader: Readers = None,
    size_limit: SizeLimit = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Tell what is in a log.

    Columns, channels, rates, ranges, the experiments that it contains, and every problem.
    Without an axis file, columns are told by their names and units, and by what moves like what; --write makes an axis
    file of that, in which "?" marks what is to be filled in. Where AXIS.toml is there already, it is not replaced: the
    log is looked at with it. The exit code is 1 if the log has problems.

    Writes summary.json and report.html into DIR; the report needs a log without problems.
    """
    from bristle.core.content import content_of
    from bristle.files.axis import read_axis
    from bristle.files.provenance import provenance
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.toml import TOML_LIMIT
    from bristle.logs.readers import read_table
    from bristle.logs.summary import summary_of
    from bristle.logs.tables import content_of_log
    from bristle.report.figure_files import figure_files

    context.with_resource(own_readers(reader))
    limit = bytes_asked(size_limit)
    axis = axis or (write if write is not None and write.exists() else None)
    described = content_of(axis, limit=TOML_LIMIT) if axis else None
    log_axis = read_axis(described) if described else None
    with (
        results_folder(out, force=force, reads=[file, axis]) if out else nullcontext() as folder,
        figure_files(folder, formats, data),
    ):
        content = content_of_log(file, limit=limit)
        proposal = _proposal(content, limit) if log_axis is None else None
        used = proposal.axis if proposal else log_axis
        table = proposal.table if proposal else read_table(content, used and used.table, size_limit=limit)
        looked_at = summary_of(table, used)
        summary = _with_messages(looked_at.data)
        summary["proposal"] = {"text": None, "missing": []}
        if proposal is not None:
            summary["proposal"] = {"text": proposal.text, "missing": list(proposal.missing)}
            summary["notes"] = [*proposal.notes, *summary["notes"]]
            if "columns.position.unit" in proposal.missing:  # of a size that nobody knows nothing can be said
                summary["diagnostics"] = [entry for entry in summary["diagnostics"] if entry["code"] != "unit_suspect"]
        if folder:
            source = provenance(context.obj, log=content, axis=described)
            _write(folder, looked_at._replace(data=summary | {"provenance": source}), used, context.obj)
    if out:
        complain(f"wrote {out}" + ("" if summary["problems"] else f"; open {out / 'report.html'} in a browser"))
    if write is not None:
        _write_proposal(write, proposal)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        _show(summary)
    for problem in summary["problems"]:
        complain(f"problem: {problem}")
    return NO if summary["problems"] else 0


def _proposal(content: Content, limit: int) -> Proposal | None:
    """Return the axis file that a log speaks of; None where no column can be the position."""
    from bristle.core.errors import InputError
    from bristle.files.proposal import propose_axis

    try:
        return propose_axis(content, size_limit=limit)
    except InputError:
        return None


def _write_proposal(write: Path, proposal: Proposal | None) -> None:
    """Write a proposed axis file where there is none yet."""
    if proposal is None:
        used = write.exists()
        complain(f"{write} is there already: it was used, not replaced" if used else f"{write} was not written")
        return
    with write.open("x", encoding="utf-8") as file:
        file.write(proposal.text)
    complain(f"wrote {write}")
    for key in proposal.missing:
        complain(f"to be filled in: {key}")


def _with_messages(summary: dict[str, Any]) -> dict[str, Any]:
    """Return what is in a log with a sentence for each diagnostic."""
    from bristle.core.diagnostic import Diagnostic
    from bristle.report.messages import as_data

    found = [Diagnostic(**entry, kind=summary["kind"]) for entry in summary["diagnostics"]]
    return summary | {"diagnostics": as_data(found)}


def _write(folder: Results, looked_at: Summary, axis: Axis | None, command: str) -> None:
    """Write the numbers, and the report of a log that can be used."""
    from bristle.files.results import SUMMARY
    from bristle.files.summary import as_json

    summary, log, passages = looked_at
    if log is None:
        folder.write(SUMMARY, as_json(summary))
        return
    from bristle.report.log import log_report
    from bristle.report.results import write_report

    page = log_report(
        log, passages, name=axis.name if axis else Path(summary["file"]).stem, command=command,
        provenance=summary["provenance"], diagnostics=summary["diagnostics"],
    )  # fmt: skip
    write_report(folder, page, summary)


def _show(summary: dict[str, Any]) -> None:
    columns = summary["columns"]
    show_table(_table("Columns of the file", "name", columns[:MOST_COLUMNS]))
    if len(columns) > MOST_COLUMNS:
        say(f"... and {len(columns) - MOST_COLUMNS} columns more. --json has all of them.")
    if summary["channels"]:
        show_table(_table(f"Channels of the axis, {summary['kind']}", "name", summary["channels"]))
    if summary["passages"]:
        from bristle.report.passages import passage_table

        show_table(passage_table(summary["passages"], summary["kind"]))
    if summary["rate"]:
        duration = f", {summary['duration']:.6g} s" if summary["duration"] else ""
        say(f"{summary['rate']:.6g} samples a second{duration}.")
    for note in summary["notes"]:
        say(f"Note: {note}")
    for found in summary["diagnostics"]:
        say(f"{found['severity'].capitalize()}: {found['message']} ({found['code']})")


def _table(caption: str, first: str, entries: list[dict[str, Any]]) -> Any:
    from bristle.core.typography import typeset
    from bristle.report.table import Table

    numbers = ("samples", "min", "max", "mean", "std", "step")
    rows = [
        [entry[first], entry.get("column") or "", typeset(entry.get("unit") or "1")]
        + ["–" if entry[key] is None else f"{entry[key]:.6g}" for key in numbers]
        for entry in entries
    ]
    return Table(caption, (first.capitalize(), "Column", "Unit", *(key.capitalize() for key in numbers)), rows)
