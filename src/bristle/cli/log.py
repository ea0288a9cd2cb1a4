"""``bristle log``: what is in a log."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.failure import NO
from bristle.cli.options import LOG_FILE, AxisFile, Data, Force, Formats, Json, Out, Readers, SizeLimit, bytes_asked, own_readers
from bristle.cli.terminal import complain, say, show_table

if TYPE_CHECKING:
    from bristle.files.proposal import Proposal

__all__ = ["EXAMPLE", "log"]

EXAMPLE = """Example:
  bristle log recording.csv --write axis.toml
  bristle log recording.csv --axis axis.toml --out what-is-in-it"""
MOST_COLUMNS = 100  # in the terminal


def log(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(metavar="FILE", help=f"A log: {LOG_FILE}")],
    axis: AxisFile = None,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="AXIS.toml", help="Write the axis file that the log itself speaks of.")
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

    Writes summary.json and report.html into DIR; the report needs a log without problems, in units that are known.
    """
    from bristle.core.content import content_of
    from bristle.files.axis import read_axis
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.files.toml import TOML_LIMIT
    from bristle.report.figure_files import figure_files
    from bristle.workflow.inspected import inspect_log

    context.with_resource(own_readers(reader))
    limit = bytes_asked(size_limit)
    axis = axis or (write if write is not None and write.exists() else None)
    described = content_of(axis, limit=TOML_LIMIT) if axis else None
    log_axis = read_axis(described) if described else None
    with results_folder(out, force=force, reads=[file, axis]) if out else nullcontext() as folder, figure_files(folder, formats, data):
        inspected = inspect_log(file, log_axis, size_limit=limit)
        summary, proposal = inspected.summary, inspected.proposal
        if folder:
            source = provenance(context.obj, log=inspected.content, axis=described)
            inspected._replace(summary=summary | {"provenance": source}).write(folder, context.obj)
    if out:
        complain(f"wrote {out}" + (f"; open {out / 'report.html'} in a browser" if inspected.log else ""))
    if write is not None:
        _write_proposal(write, proposal)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        _show(summary)
    for problem in summary["problems"]:
        complain(f"problem: {problem}")
    return NO if summary["problems"] else 0


def _write_proposal(write: Path, proposal: Proposal | None) -> None:
    """Write a proposed axis file where there is none yet."""
    if proposal is None:
        used = write.exists()
        complain(f"{write} is there already: it was used, not replaced" if used else f"{write} was not written")
        return
    from bristle.files.single import write_whole

    write_whole(write, proposal.text, new=True)
    complain(f"wrote {write}")
    for key in proposal.missing:
        complain(f"to be filled in: {key}")


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
    from bristle.report.table import Table

    numbers = ("samples", "min", "max", "mean", "std", "step")
    rows = [
        [entry[first], entry.get("column") or "", _unit(entry.get("unit") or "1")]
        + ["–" if entry[key] is None else f"{entry[key]:.6g}" for key in numbers]
        for entry in entries
    ]
    return Table(caption, (first.capitalize(), "Column", "Unit", *(key.capitalize() for key in numbers)), rows)


def _unit(unit: str) -> str:
    """Return a unit as it is printed; one that is not known, as the file has it."""
    from bristle.core.typography import typeset
    from bristle.core.units import is_unit

    return typeset(unit) if is_unit(unit) else f"{unit} (unknown)"
