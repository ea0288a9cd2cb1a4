"""``bristle demo``: the main job on a simulated axis, start to finish."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.identify import show_identification
from bristle.cli.options import Force, Json, Output, Quiet, Verbose, folder_named, print_json
from bristle.cli.terminal import say

EXAMPLE = """Example:
  bristle demo --out demo-results"""
USUAL_PLACE = Path("bristle-demo")


def demo(
    context: typer.Context,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the results into this folder.")
    ] = USUAL_PLACE,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Do the main job on a simulated axis.

    A log, the identification, a log that it has not seen, the compensated loop, the report. Ends by saying how to do
    it with a log of your own.
    """
    from bristle.demo import BANNER, run
    from bristle.report.brief import Line
    from bristle.report.prediction import metrics_in_words

    # Nobody keeps the results of a demonstration where it puts them unasked.
    with Output(context, out, force=force or out == USUAL_PLACE, quiet=quiet).opened("demonstration") as (folder, report):
        demonstration = run(folder, command=context.obj, progress=report)
    if as_json:
        print_json(demonstration.summary)
        return
    found = ", ".join(f"{word} {value}" for word, value in metrics_in_words(demonstration.prediction)[:1])
    results = [
        Line("Unseen log", f"predicted in closed loop: {found}"),
        Line("Results", f"{out}: report.html, drive_table.csv, model.toml, log.csv, unseen.csv"),
    ]
    following = [
        Line("Your log", "bristle log YOUR.csv --write axis.toml, then fill in its columns and units"),
        Line("", "bristle identify YOUR.csv --axis axis.toml --out results"),
    ]
    if not quiet:
        say(BANNER)
    show_identification(demonstration.outcome, verbose=verbose, quiet=quiet, results=results, following=following)
