"""``bristle demo``: the whole workflow on a simulated axis."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.identify import show_identification
from bristle.cli.options import Force, Json, Output, Quiet, Verbose, dir_option, print_json
from bristle.cli.terminal import say

EXAMPLE = """Example:
  bristle demo --out demo-results"""
USUAL_PLACE = Path("bristle-demo")


def demo(
    context: typer.Context,
    out: Annotated[Path, dir_option("--out", "Write the results to this folder.")] = USUAL_PLACE,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Show the whole workflow on a simulated axis.

    bristle simulates a log, identifies a model, predicts a second log, compensates the loop and writes a report. The last
    lines list the commands for a log of your own.
    """
    from bristle.cli.demonstration import BANNER, run
    from bristle.report.brief import Line
    from bristle.report.prediction import metrics_in_words

    # Results in the default folder are disposable.
    with Output(context, out, force=force or out == USUAL_PLACE, quiet=quiet).opened(
        "demonstration"
    ) as (folder, report):
        demonstration = run(folder, command=context.obj, progress=report)
    if as_json:
        print_json(demonstration.summary)
        return
    metrics = ", ".join(
        f"{word} {value}" for word, value in metrics_in_words(demonstration.prediction)[:1]
    )
    results = [
        Line("Unseen log", f"{metrics}, predicted in closed loop"),
        Line("Results", f"{out}: report.html, drive_table.csv, model.toml, log.csv, unseen.csv"),
    ]
    following = [
        Line(
            "Your log", 'bristle log YOUR.csv --write axis.toml, then replace each "?" in axis.toml'
        ),
        Line("", "bristle identify YOUR.csv --axis axis.toml --out results"),
    ]
    if not quiet:
        say(BANNER)
    show_identification(
        demonstration.outcome, verbose=verbose, quiet=quiet, results=results, following=following
    )
