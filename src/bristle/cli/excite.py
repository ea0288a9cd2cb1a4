"""``bristle excite``: the motion to run on an axis, and what it will identify."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.options import AllowCode, Data, Force, Formats, Json, Out
from bristle.cli.terminal import complain, progress, say, show_table

if TYPE_CHECKING:
    from bristle.excitation import Excitation

__all__ = ["EXAMPLE", "excite"]

EXAMPLE = """Example:
  bristle excite axis.toml --out motion --for presliding,stribeck"""

OPTIONS = {"duration": "--duration", "travel": "--travel", "start": "--start", "purposes": "--for", "model": "--model"}


def excite(
    context: typer.Context,
    axis: Annotated[Path, typer.Argument(metavar="AXIS.toml", help="The file that describes the axis.")],
    out: Out = None,
    *,
    duration: Annotated[str, typer.Option("--duration", metavar="TIME", help="How long the motion may take.")] = "60 s",
    travel: Annotated[str | None, typer.Option("--travel", metavar="LENGTH", help="Stay within this distance around the start.")] = None,
    start: Annotated[
        str | None, typer.Option("--start", metavar="LENGTH", help="Where the axis stands; the middle of the stroke by default.")
    ] = None,
    purposes: Annotated[
        str | None, typer.Option("--for", metavar="NAME[,NAME...]", help="Of presliding, break-away, damping, stribeck: all by default.")
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", metavar="MODEL.toml", help="An earlier model of the axis, to rehearse with.")
    ] = None,
    formats: Formats = None,
    data: Data = None,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Design the motion to run on an axis, within its limits.

    Tells what its log would identify, and how well: it is run on what is believed of the axis, and identified.

    Writes motion.csv, moves.csv, motion.nc, axis.toml, summary.json and report.html into DIR.
    """
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.toml import TOML_LIMIT
    from bristle.report.figure_files import figure_files
    from bristle.workflow.excited import FILES, designed_motion

    axis_file = content_of(axis, limit=TOML_LIMIT)
    model_file = content_of(model, limit=TOML_LIMIT) if model else None
    with (
        results_folder(out, force=force, reads=[axis, model]) if out else nullcontext() as folder,
        progress("designing") as report,
        figure_files(folder, formats, data),
    ):
        try:
            motion = designed_motion(
                axis_file,
                command=context.obj,
                model_file=model_file,
                duration=duration,
                travel=travel,
                start=start,
                purposes=purposes,
                allow_code=allow_code,
                progress=report,
            )
        except InputError as error:
            path = OPTIONS.get(error.path, error.path)
            raise InputError(error.message, path=path, value=error.value, allowed=error.allowed, mend=error.mend) from None
        following = motion.next_command(str(Path(out.name) / "axis.toml" if out else Path("AXIS.toml")))
        if folder:
            report(0.85, "writing the report")
            motion.write(folder, following)
    if as_json:
        sys.stdout.write(json_text(motion.summary(FILES if out else {}, following)))
    else:
        _show(motion.excitation, motion.next_command(str(out / "axis.toml")) if out else following)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")


def _show(excitation: Excitation, following: str) -> None:
    from bristle.report.excitation import outlook_table, piece_table

    show_table(piece_table(excitation))
    if excitation.rehearsal is not None:
        show_table(outlook_table(excitation))
    for note in excitation.notes:
        say(f"Note: {note}")
    say(f"Then: {following}")
