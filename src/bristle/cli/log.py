"""``bristle log``: what is in a log."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from bristle.cli.failure import NO
from bristle.cli.options import AxisFile, Json
from bristle.cli.terminal import complain, say, show_table

__all__ = ["EXAMPLE", "log"]

EXAMPLE = """Example:
  bristle log axis.mat --axis axis.toml"""


def log(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="A log: CSV, MAT, TDMS, Parquet, HDF5 or NPZ; FILE::TABLE names a table in it."
        ),
    ],
    axis: AxisFile = None,
    as_json: Json = False,
) -> int:
    """Tell what is in a log.

    Columns, channels, rates, ranges, and every problem.
    Without an axis file, columns that are called as usual are taken. The exit code is 1 if the log has problems.
    """
    from bristle.files.axis import read_axis
    from bristle.files.summary import as_json as json_text
    from bristle.logs import summarize

    summary = summarize(file, read_axis(axis) if axis else None)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        _show(summary)
    for problem in summary["problems"]:
        complain(f"problem: {problem}")
    return NO if summary["problems"] else 0


def _show(summary: dict[str, Any]) -> None:
    show_table(_table("Columns of the file", "name", summary["columns"]))
    if summary["channels"]:
        show_table(_table(f"Channels of the axis, {summary['kind']}", "name", summary["channels"]))
    if summary["rate"]:
        duration = f", {summary['duration']:.6g} s" if summary["duration"] else ""
        say(f"{summary['rate']:.6g} samples a second{duration}.")
    for note in summary["notes"]:
        say(f"Note: {note}")


def _table(caption: str, first: str, entries: list[dict[str, Any]]) -> Any:
    from bristle.core.typography import typeset
    from bristle.report.table import Table

    numbers = ("samples", "min", "max", "mean", "std", "step")
    rows = [
        [one[first], one.get("column") or "", typeset(one.get("unit") or "1")]
        + ["–" if one[key] is None else f"{one[key]:.6g}" for key in numbers]
        for one in entries
    ]
    return Table(caption, (first.capitalize(), "Column", "Unit", *(key.capitalize() for key in numbers)), rows)
