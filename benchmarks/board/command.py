"""``python -m benchmarks board``: the score board of friction before sliding."""

from __future__ import annotations

from datetime import date as calendar
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.application import UsageError
from bristle.cli.options import Json, Output, command_text, dir_option, print_json, refuse
from bristle.cli.signals import ended_by_signals
from bristle.cli.terminal import (
    BAD_INPUT,
    NO,
    complain,
    progress,
    report,
    show,
    streams_that_take_all,
    warnings_as_lines,
)

if TYPE_CHECKING:
    from benchmarks.board.run import Bench

NAME = "python -m benchmarks board"
EXAMPLE = f"""Example:
  {NAME} my_competitor.py stribeck --task known_axis
  {NAME} --all --date 2026-11-28"""

app = typer.Typer(
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main(words: list[str]) -> int:
    """Run the board with the words behind its name, and return the exit code."""
    command, line = typer.main.get_command(app), command_text(words).replace("bristle", NAME, 1)
    streams_that_take_all()
    with ended_by_signals(), warnings_as_lines():
        try:
            with command.make_context(NAME, words, obj=line) as context:
                return command.invoke(context) or 0
        except typer.Exit as ended:
            return ended.exit_code
        except UsageError as error:
            complain(f"{error.format_message()} Try: {NAME} --help")
            return BAD_INPUT
        except BaseException as error:  # noqa: BLE001  (an error becomes one message)
            return report(error, results=True)


def _day(text: str) -> str:
    try:
        return calendar.fromisoformat(text).isoformat()
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a date. Write YYYY-MM-DD") from None


@app.command("board", epilog=f"\b\n{EXAMPLE}")
def score_board(
    context: typer.Context,
    competitors: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[COMPETITOR]...",
            help="Names of competitors, or Python files. Files alone meet all, which takes minutes.",
        ),
    ] = None,
    *,
    everything: Annotated[
        bool,
        typer.Option("--all", help="Run all tasks with all competitors: 30 minutes on two cores."),
    ] = False,
    task: Annotated[
        list[str] | None,
        typer.Option("--task", metavar="TASK", help="Run only this task; repeatable."),
    ] = None,
    listing: Annotated[
        bool, typer.Option("--list", help="List tasks, competitors and scores.")
    ] = False,
    date: Annotated[
        str | None,
        typer.Option(
            "--date",
            metavar="YYYY-MM-DD",
            parser=_day,
            help="Seed of the simulated axes; by default today.",
        ),
    ] = None,
    out: Annotated[
        Path, dir_option("--out", "Write the results to this folder, or continue those in it.")
    ] = Path("bristle-bench"),
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="COUNT",
            min=1,
            max=1024,
            help="Number of competitors at once; by default one per core.",
        ),
    ] = None,
    as_json: Json = False,
) -> int:
    """Compare friction models, laws and estimators on fixed tasks.

    A competitor is a Python file with fit(train) and any of predict, feedforward and parameters. It never receives the
    effort that it predicts. It runs in a separate process with a time limit. A competitor that fails gets a row with the reason.

    The same command continues an interrupted run. The folder named in BRISTLE_DATA holds the measured logs.

    Writes score-board.md, score-board.json and a file for each result into DIR.
    """
    from benchmarks.board.run import Bench, competitors_named, date_in
    from benchmarks.board.task import tasks_named

    named = competitors or []
    chosen, entered = tasks_named(tuple(task or ())), competitors_named(named)
    if listing:
        return _list(Bench(chosen, entered, ""), as_json=as_json)
    refuse(
        {NAME: not (everything or named or task)},
        "runs for half an hour",
        "Name tasks or competitors, or add --all",
    )
    day = date or date_in(out) or calendar.today().isoformat()
    return _run(Bench(chosen, entered, day), Output(context, out, as_json=as_json), workers)


def _list(bench: Bench, *, as_json: bool) -> int:
    """Print tasks, competitors and scores."""
    from benchmarks.board.task import SCORES
    from bristle.report.table import Table

    tasks = {
        task.name: {"title": task.title, "scores": ", ".join(task.scores), "skipped": task.missing}
        for task in bench.tasks
    }
    entered = {
        part.name: {"method": part.description, "skipped": part.missing}
        for part in bench.competitors
    }
    if as_json:
        print_json({"tasks": tasks, "competitors": entered, "scores": SCORES})
        return 0
    for caption, listed in {"Task": tasks, "Competitor": entered}.items():
        heads = [caption, *(key.capitalize() for key in next(iter(listed.values())))]
        show(
            Table(f"{caption}s", heads, [(name, *entry.values()) for name, entry in listed.items()])
        )
    show(Table("Scores; smaller is better", ("Score", "Meaning"), list(SCORES.items())))
    return 0


def _run(bench: Bench, output: Output, workers: int | None) -> int:
    """Run the missing results, and print and write the board."""
    from benchmarks.board.board import DATA, PAGE, board, failures, page, tables, verdicts
    from benchmarks.board.scores import OK
    from bristle.files import allow, as_json, growing_folder, provenance

    assert output.out is not None
    for competitor in bench.competitors:
        allow(competitor.content)
    for name, reason in bench.skipped.items():
        complain(f"skipped {name}: {reason}")
    with (
        growing_folder(output.out, "score board", made_anew=lambda _: True) as (folder, damaged),
        progress("beginning") as told,
    ):
        folder.set_all_aside(damaged)
        try:
            finished = bench.run(folder, workers, told)
        except KeyboardInterrupt:
            complain(
                f"{output.out} keeps the finished results. Give the same command again to continue"
            )
            raise
        further = bench.further(folder)
        if not finished:
            complain(
                f"no task can run with these competitors: the board in {output.out} is unchanged"
            )
            return NO
        summary = board(bench, finished, provenance=provenance(output.command))
        for name, text in {DATA: as_json(summary), PAGE: page(summary)}.items():
            folder.write(name, text)
    lines = [
        f"Date, the seed of the simulated axes: {bench.date}.",
        *verdicts(summary),
        *failures(summary),
    ]
    if further:
        lines.append(
            f"{output.out} holds {further} results of other tasks or competitors: name them, too, for a board with them."
        )
    output.tell(summary, *tables(summary), *lines, files=f"{PAGE}, {DATA}")
    scored = {
        name
        for entry in summary["scores"].values()
        for task in entry["tasks"].values()
        for name in task
        if task[name]["status"] == OK
    }
    return (
        NO
        if any(entered.is_file and entered.name not in scored for entered in bench.competitors)
        else 0
    )
