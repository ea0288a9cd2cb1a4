"""``bristle compare``: whether a change improved the machine."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import (
    AxisFiles,
    FigureFiles,
    Output,
    Readers,
    own_figures,
    own_readers,
    size_limit,
    toml_content,
)
from bristle.cli.terminal import exit_code

EXAMPLE = """Example:
  bristle compare before.csv after.csv --axis axis.toml --out compared"""


def compare(
    before: Annotated[
        Path, typer.Argument(metavar="BEFORE", help="Log recorded before the change.")
    ],
    after: Annotated[
        Path,
        typer.Argument(
            metavar="AFTER", help="Log recorded after the change: same axis, same reference."
        ),
    ],
    *,
    axis: AxisFiles = None,
    before_too: Annotated[
        list[Path] | None,
        typer.Option(
            "--before", metavar="LOG", help="Another log from before the change; repeatable."
        ),
    ] = None,
    after_too: Annotated[
        list[Path] | None,
        typer.Option(
            "--after", metavar="LOG", help="Another log from after the change; repeatable."
        ),
    ] = None,
    output: Output,
    figure: FigureFiles = None,
    reader: Readers = None,
) -> int:
    """Compare two logs of one axis, from before and after a change.

    Shows the change of following error, of its peaks at reversals, of effort and of friction, each with a 95 % interval.
    bristle compares only the motion that occurs in both logs. The exit code is 1 if the following error is not
    significantly lower after the change.

    Writes summary.json and report.html into DIR.
    """
    from bristle.files import read_axis
    from bristle.report.compared import compared_as
    from bristle.report.comparison import advice_of, change_table, remarks_of
    from bristle.report.table import capital

    output.context.with_resource(own_readers(reader))
    sides = [before, *(before_too or ())], [after, *(after_too or ())]
    contents = [toml_content(file) for file in axis or ()]
    further, code = own_figures(figure, "compare", has_folder=output.out is not None)
    with output.opened("comparing", [*sides[0], *sides[1], *contents]) as (folder, _):
        axes = [read_axis(content) for content in contents]
        name = before.stem
        if axes:
            name = axes[0].name
        comparison = compared_as(
            *sides,
            axis=axes,
            call=output.command,
            name=name,
            read={"axis": contents, "figure": code},
            figures=further,
            size_limit=size_limit(),
        )
        if folder:
            comparison.write(folder)

    remarks = [f"{capital(remark)}." for remark in remarks_of(comparison)]
    output.tell(
        comparison.summary,
        comparison.sentences[0],
        change_table(comparison),
        *remarks,
        f"Next: {advice_of(comparison)}",
    )
    return exit_code(comparison.helped is False)
