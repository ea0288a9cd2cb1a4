"""``bristle bench``: the score board of friction before sliding."""

from __future__ import annotations

from datetime import date as calendar
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.options import Json, Output, dir_option, print_json, refuse
from bristle.cli.study import interruptible
from bristle.cli.terminal import NO, complain, progress, show

if TYPE_CHECKING:
    from bristle.bench.run import Bench

EXAMPLE = """Example:
  bristle bench my_competitor.py stribeck --task known_axis
  bristle bench --all --date 2026-11-28"""


def _day(text: str) -> str:
    try:
        return calendar.fromisoformat(text).isoformat()
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a date. Write YYYY-MM-DD") from None


def bench(
    context: typer.Context,
    competitors: Annotated[
        list[str] | None,
        typer.Argument(metavar="[COMPETITOR]...", help="Names of competitors, or Python files. Files alone meet all, which takes minutes."),
    ] = None,
    *,
    everything: Annotated[bool, typer.Option("--all", help="Run all tasks with all competitors: 30 minutes on two cores.")] = False,
    task: Annotated[list[str] | None, typer.Option("--task", metavar="TASK", help="Run only this task; repeatable.")] = None,
    listing: Annotated[bool, typer.Option("--list", help="List tasks, competitors and scores.")] = False,
    date: Annotated[
        str | None, typer.Option("--date", metavar="YYYY-MM-DD", parser=_day, help="Seed of the simulated axes; by default today.")
    ] = None,
    out: Annotated[Path, dir_option("--out", "Write the results to this folder, or continue those in it.")] = Path("bristle-bench"),
    workers: Annotated[
        int | None, typer.Option(metavar="COUNT", min=1, max=1024, help="Number of competitors at once; by default one per core.")
    ] = None,
    as_json: Json = False,
) -> int:
    """Compare friction models, laws and estimators on fixed tasks.

    A competitor is a Python file with fit(train) and any of predict, feedforward and parameters. It never receives the
    effort that it predicts. It runs in a separate process with a time limit. A competitor that fails gets a row with the reason.

    The same command continues an interrupted run. The folder named in BRISTLE_DATA holds the measured logs.

    Writes score-board.md, score-board.json and a file for each result into DIR.
    """
    from bristle.bench.run import Bench, competitors_named, date_in
    from bristle.bench.task import tasks_named

    named = competitors or []
    chosen, entered = tasks_named(tuple(task or ())), competitors_named(named)
    if listing:
        return _list(Bench(chosen, entered, ""), as_json=as_json)
    refuse({"bristle bench": not (everything or named or task)}, "runs for half an hour", "Name tasks or competitors, or add --all")
    day = date or date_in(out) or calendar.today().isoformat()
    return _run(Bench(chosen, entered, day), Output(context, out, as_json=as_json), workers)


def _list(bench: Bench, *, as_json: bool) -> int:
    """Print tasks, competitors and scores."""
    from bristle.bench.task import SCORES
    from bristle.report.table import Table

    tasks = {task.name: {"title": task.title, "scores": ", ".join(task.scores), "skipped": task.missing} for task in bench.tasks}
    entered = {part.name: {"method": part.description, "skipped": part.missing} for part in bench.competitors}
    if as_json:
        print_json({"tasks": tasks, "competitors": entered, "scores": SCORES})
        return 0
    for caption, listed in {"Task": tasks, "Competitor": entered}.items():
        heads = [caption, *(key.capitalize() for key in next(iter(listed.values())))]
        show(Table(f"{caption}s", heads, [(name, *entry.values()) for name, entry in listed.items()]))
    show(Table("Scores; smaller is better", ("Score", "Meaning"), list(SCORES.items())))
    return 0


def _run(bench: Bench, output: Output, workers: int | None) -> int:
    """Run the missing results, and print and write the board."""
    from bristle.bench.board import DATA, PAGE, board, failures, page, tables, verdicts
    from bristle.bench.scores import OK
    from bristle.files import allow, as_json, growing_folder, provenance

    assert output.out is not None
    for competitor in bench.competitors:
        allow(competitor.content)
    for name, reason in bench.skipped.items():
        complain(f"skipped {name}: {reason}")
    with growing_folder(output.out, "score board", made_anew=lambda _: True) as (folder, damaged), progress("beginning") as report:
        folder.set_all_aside(damaged)
        with interruptible(output.out, "results"):
            finished = bench.run(folder, workers, report)
        further = bench.further(folder)
        if not finished:
            complain(f"no task can run with these competitors: the board in {output.out} is unchanged")
            return NO
        summary = board(bench, finished, provenance=provenance(output.command))
        for name, text in {DATA: as_json(summary), PAGE: page(summary)}.items():
            folder.write(name, text)
    lines = [f"Date, the seed of the simulated axes: {bench.date}.", *verdicts(summary), *failures(summary)]
    if further:
        lines.append(f"{output.out} holds {further} results of other tasks or competitors: name them, too, for a board with them.")
    output.tell(summary, *tables(summary), *lines, files=f"{PAGE}, {DATA}")
    scored = {
        name for entry in summary["scores"].values() for task in entry["tasks"].values() for name in task if task[name]["status"] == OK
    }
    return NO if any(entered.is_file and entered.name not in scored for entered in bench.competitors) else 0
