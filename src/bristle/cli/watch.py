"""``bristle watch``: the axes of fleets over time, alarms at a stated rate of false ones."""

from __future__ import annotations

import sys
from contextlib import nullcontext, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import Data, Force, Formats, Json, Out
from bristle.cli.terminal import complain, progress, say, show_table

__all__ = ["EXAMPLE", "watch"]

EXAMPLE = """Example:
  bristle watch fleet --out watched
  bristle watch fleet --axis-from "(?P<axis>x|y)_(?P<date>[0-9-]+)" --false-alarms "1 in 500 days" --json"""


def watch(
    context: typer.Context,
    folder: Annotated[list[Path], typer.Argument(metavar="DIR...", help="What bristle identify --each wrote, or folders that hold such.")],
    axis_from: Annotated[
        str | None,
        typer.Option(
            "--axis-from",
            metavar="PATTERN",
            help="Regular expression with a group axis, and date where there is one, looked for in FOLDER/LOG; the "
            "folder of a log is its axis by default.",
        ),
    ] = None,
    track: Annotated[
        list[str] | None, typer.Option("--track", metavar="COLUMN", help="Watch this, such as friction.F_C; may be repeated.")
    ] = None,
    false_alarms: Annotated[
        str, typer.Option("--false-alarms", metavar="RATE", help="How often a healthy axis may alarm.")
    ] = "1 in 1000 days",
    since: Annotated[
        str | None, typer.Option("--since", metavar="DATE", help="Leave out logs from before, as of an axis that was mended.")
    ] = None,
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Watch the axes of fleets over time.

    Tracks level, viscous part and scatter of the friction of each axis, with the temperature taken off where logs have
    a column of it. An alarm is a change that the scatter of the axis does not explain, at the stated rate of false
    alarms; it says since when, and by how much, with intervals. The exit code is 1 on an alarm.

    Writes summary.json and report.html into DIR.
    """
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.fleet import watch as watched_over
    from bristle.report.figure_files import figure_files
    from bristle.report.results import write_report
    from bristle.report.watch import alarms_table, watch_report, watch_sentences, watch_summary

    with results_folder(out, force=force) if out else nullcontext() as results, progress("watching"), figure_files(results, formats, data):
        watched = watched_over(folder, axis_from=axis_from, quantities=track or (), false_alarms=false_alarms, since=_moment(since))
        summary = watch_summary(watched, provenance=provenance(context.obj))
        if results:
            page = watch_report(watched, summary, name=folder[0].resolve().name, command=context.obj)
            write_report(results, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        if (alarms := alarms_table(watched)) is not None:
            show_table(alarms)
        for sentence in watch_sentences(watched):
            say(sentence)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    return NO if watched.alarms else 0


def _moment(text: str | None) -> float | None:
    if text is None:
        return None
    from bristle.core import InputError

    with suppress(ValueError):
        moment = datetime.fromisoformat(text)
        if moment.tzinfo is None:  # clocks of logs have none either
            return moment.replace(tzinfo=UTC).timestamp()
    raise InputError("is no date", path="--since", value=text, allowed="2026-03-01, or 2026-03-01T12:00")
