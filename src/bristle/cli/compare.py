"""``bristle compare``: whether it helped on the machine."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import (
    AxisFiles,
    Data,
    FigureFiles,
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
from bristle.cli.terminal import complain, progress, say, show_table

__all__ = ["EXAMPLE", "compare"]

EXAMPLE = """Example:
  bristle compare before.csv after.csv --axis axis.toml --out compared"""


def compare(
    context: typer.Context,
    before: Annotated[Path, typer.Argument(metavar="BEFORE", help="The log from before a change.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER", help="The log from after it, of the same axis with the same reference.")],
    *,
    axis: AxisFiles = None,
    before_too: Annotated[
        list[Path] | None, typer.Option("--before", metavar="LOG", help="A further log from before; may be given several times.")
    ] = None,
    after_too: Annotated[
        list[Path] | None, typer.Option("--after", metavar="LOG", help="A further log from after; may be given several times.")
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            "--window",
            metavar="TIME",
            help="Time behind a reversal for its peak, such as '50 ms'; a tenth of the time between two by default.",
        ),
    ] = None,
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    figure: FigureFiles = None,
    reader: Readers = None,
    size_limit: SizeLimit = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Compare two logs of one axis, from before and after a change.

    Did it help on the machine? Following error, its peaks at reversals, effort and friction, each with the 95 %
    interval of its change. Only what both logs move alike is compared. The exit code is 1 if the following error is
    not told to be lower.

    Writes summary.json and report.html into DIR.
    """
    from bristle.core.content import content_of
    from bristle.files.arguments import axes_for
    from bristle.files.axis import read_axis
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.toml import TOML_LIMIT
    from bristle.logs import read_log
    from bristle.report.comparison import change_table, remarks_of
    from bristle.report.figure_files import figure_files
    from bristle.workflow.compared import compared_as

    context.with_resource(own_readers(reader))
    limit = bytes_asked(size_limit)
    sides = [before, *(before_too or ())], [after, *(after_too or ())]
    files = [*sides[0], *sides[1]]
    contents = [content_of(file, limit=TOML_LIMIT) for file in axis or ()]
    further, code = own_figures(figure, "compare", has_folder=out is not None)
    with (
        results_folder(out, force=force, reads=[*files, *contents]) if out else nullcontext() as folder,
        progress("comparing"),
        figure_files(folder, formats, data),
    ):
        axes = axes_for([read_axis(content) for content in contents], len(files))
        logs = [read_log(file, axis, size_limit=limit) for file, axis in zip(files, axes, strict=True)]
        comparison = compared_as(
            logs[: len(sides[0])],
            logs[len(sides[0]) :],
            axis=axes,
            window=_seconds(window),
            call=context.obj,
            name=axes[0].name if axes[0] else before.stem,
            read={"axis": contents, "figure": code},
            figures=further,
        )
        if folder:
            comparison.write(folder)
    if as_json:
        sys.stdout.write(json_text(comparison.summary))
    else:
        say(comparison.sentences[0])
        show_table(change_table(comparison))
        for remark in remarks_of(comparison):
            say(f"{remark[0].upper()}{remark[1:]}.")
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    return NO if comparison.helped is False else 0


def _seconds(text: str | None) -> float | None:
    if text is None:
        return None
    from bristle.core import InputError, Variable
    from bristle.core.units import quantity

    seconds = quantity(text, Variable("time", "time behind a reversal", min=0.0), path="--window")
    if not seconds > 0.0:
        raise InputError("must be positive", path="--window", value=text, allowed="> 0 s")
    return seconds
