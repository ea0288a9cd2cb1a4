"""``bristle tune``: from a running axis to a better one, measured, or restored as it was."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import AllowCode, Json, Quiet, dir_option, print_json
from bristle.cli.terminal import NO, complain, progress, show

EXAMPLE = """Example:
  bristle tune machine.toml --out tuned --move"""


def tune(
    machine: Annotated[
        Path | None,
        typer.Argument(metavar="[MACHINE.toml]", help="Machine file; not with --undo and --save."),
    ] = None,
    *,
    context: typer.Context,
    out: Annotated[
        Path | None,
        dir_option("--out", "Folder of the run; a folder with a journal resumes its run."),
    ] = None,
    move: Annotated[
        bool,
        typer.Option(
            "--move", help="Allow the axis to move. Without it, bristle only shows the plan."
        ),
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show every move and every write, and do nothing.")
    ] = False,
    undo: Annotated[
        Path | None, dir_option("--undo", "Restore the machine as before the run in DIR.")
    ] = None,
    save: Annotated[
        Path | None,
        dir_option("--save", "Keep the feedforward of DIR over a restart of the controller."),
    ] = None,
    model: Annotated[
        str, typer.Option("--model", metavar="NAME[,NAME...]", help="Friction models to identify.")
    ] = "lugre,dahl,maxwell_slip",
    allow_code: AllowCode = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Tune a running axis; keep the feedforward only if it helps.

    bristle backs up all values that it writes, checks that a small effort reaches the motor, records the user's motion,
    excites the axis within the limits of its axis file, identifies the friction, and raises the gain of the feedforward
    in stages. It keeps the feedforward if the following error is lower and nothing else is worse; otherwise it restores
    the machine. The exit code is 1 if the machine was restored.

    Writes journal.jsonl, summary.json, report.html, records and results into DIR.
    """
    from bristle.apps import tune as package
    from bristle.apps.tune.report import plan_rows, sentences_of
    from bristle.core import InputError
    from bristle.report.table import Table

    if undo is not None and save is not None:
        raise InputError("exclude each other", path="--undo and --save", mend="Write one of them")
    if undo is not None:
        result = package.undo(undo, allow_code=allow_code)
    elif save is not None:
        result = package.save(save, allow_code=allow_code)
    elif machine is None or out is None:
        raise InputError(
            "is needed",
            path="MACHINE.toml and --out DIR",
            mend="Write bristle tune machine.toml --out tuned --move",
        )
    else:
        with progress("tuning", quiet=quiet) as report:
            result = package.tune(
                machine,
                out,
                move=move and not dry_run,
                options=package.Options(models=model),
                allow_code=allow_code,
                progress=report,
            )
    if as_json:
        print_json(result.as_data())
    elif result.outcome == "planned":
        show(Table("Plan", ("Step", "Duration", "Travel", "Writes"), plan_rows(result)))
        for remark in result.remarks:
            complain(remark)
        complain("nothing moved and nothing was written. Add --move to run these steps")
    else:
        show(*sentences_of(result))
    return NO if result.outcome == "restored" else 0
