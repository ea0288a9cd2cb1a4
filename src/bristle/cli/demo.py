"""``bristle demo``: the main job on a simulated axis, start to finish."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.findings import show_identification
from bristle.cli.options import Data, Force, Formats, Json, folder_named
from bristle.cli.terminal import progress, say

if TYPE_CHECKING:
    from bristle.simulation import Prediction

__all__ = ["EXAMPLE", "demo"]

EXAMPLE = """Example:
  bristle demo --out demo-results"""
USUAL_PLACE = Path("bristle-demo")


def demo(
    context: typer.Context,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the results into this folder.")
    ] = USUAL_PLACE,
    formats: Formats = None,
    data: Data = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Do the main job on a simulated axis.

    A log, the identification, a log that it has not seen, the compensated loop, the report. Ends by saying how to do
    it with a log of your own.
    """
    from bristle.demo import BANNER, run
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.report.figure_files import figure_files

    # Nobody keeps the results of a demonstration where it puts them unasked.
    with (
        results_folder(out, force=force or out == USUAL_PLACE) as folder,
        progress("demonstration") as report,
        figure_files(folder, formats, data),
    ):
        demonstration = run(folder, command=context.obj, progress=report)
    if as_json:
        sys.stdout.write(json_text(demonstration.summary))
        return
    say(BANNER)
    show_identification(demonstration.identification, demonstration.simulation, demonstration.following)
    _show_unseen(demonstration.prediction)
    say(f"""
The report: {out / "report.html"} (open it in a browser). Now with a log of your own:
  1. Copy {out / "axis.toml"} and write into it what your columns are called, in which units.
  2. bristle log YOUR.csv --axis YOUR.toml
  3. bristle identify YOUR.csv --axis YOUR.toml --out results
  4. bristle predict results/model.toml ANOTHER.csv --axis YOUR.toml""")


def _show_unseen(prediction: Prediction) -> None:
    from bristle.report.prediction import metrics_in_words

    say("On a log that was not fitted, predicted in closed loop:")
    for word, value in metrics_in_words(prediction):
        say(f"  {word}: {value}")
