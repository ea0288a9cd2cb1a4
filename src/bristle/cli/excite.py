"""``bristle excite``: the motion to record on an axis, and the parameters it will identify."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import Output, size_limit, toml_content

EXAMPLE = """Example:
  bristle excite axis.toml --out motion --for presliding,stribeck"""

OPTIONS = {
    "duration": "--duration",
    "travel": "--travel",
    "start": "--start",
    "purposes": "--for",
    "model": "--model",
    "log": "--log",
}


def excite(
    axis: Annotated[Path, typer.Argument(metavar="AXIS.toml", help="Axis file.")],
    *,
    output: Output,
    duration: Annotated[
        str, typer.Option("--duration", metavar="TIME", help="Longest duration of the motion.")
    ] = "60 s",
    travel: Annotated[
        str | None,
        typer.Option(
            "--travel",
            metavar="LENGTH",
            help="Largest travel, end to end; the start is its middle.",
        ),
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            "--start", metavar="LENGTH", help="Start position; by default the middle of the stroke."
        ),
    ] = None,
    purposes: Annotated[
        str | None,
        typer.Option(
            "--for",
            metavar="NAME[,NAME...]",
            help="Goals of the motion: presliding, break-away, damping, stribeck (default); on request stiffness, resonance.",
        ),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            "--model",
            metavar="MODEL.toml",
            help="Earlier model of the axis, for the simulation of the motion.",
        ),
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            metavar="LOG",
            help="Earlier log of the axis, from which bristle identifies such a model.",
        ),
    ] = None,
) -> None:
    """Design the motion to record on an axis, within its limits.

    bristle simulates the motion on a model of the axis and identifies the simulated log. The output shows which
    parameters a log of this motion would identify, and how accurately.

    Writes motion.csv, moves.csv, motion.nc, axis.toml, summary.json and report.html into DIR.
    """
    from bristle.core import InputError
    from bristle.files import read_log
    from bristle.report.excitation import FILES, designed_motion, outlook_tables, piece_table

    axis_file = toml_content(axis)
    options = {"duration": duration, "travel": travel, "start": start, "purposes": purposes}
    model_file = toml_content(model)
    out = output.out
    with output.opened("designing", [axis, model, log]) as (folder, report):
        try:
            recorded = None
            if log is not None:
                recorded = read_log(log, axis_file, size_limit=size_limit())
            motion = designed_motion(
                axis_file,
                command=output.command,
                model_file=model_file,
                log=recorded,
                progress=report,
                **options,
            )
        except InputError as error:
            raise error.at(path=OPTIONS.get(error.path, error.path)) from None
        following = motion.next_command("AXIS.toml")
        then = f"Then: {following}"
        files = {}
        if out:
            following = motion.next_command(str(Path(out.name) / "axis.toml"))
            then = f"Then: {motion.next_command(str(out / 'axis.toml'))}"
            files = FILES
        if folder:
            report(0.85, "writing the report")
            motion.write(folder, following)

    excitation = motion.excitation
    notes = (f"Note: {note}" for note in excitation.notes)
    summary = motion.summary(files, following)
    verdict = f"Verdict: {summary['verdict']['words']}"
    reasons = "; ".join(summary["verdict"]["reasons"])
    if reasons:
        verdict += f": {reasons}"
    output.tell(
        summary, piece_table(excitation), *outlook_tables(excitation), *notes, f"{verdict}.", then
    )
