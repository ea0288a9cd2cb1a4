"""``bristle demo``: the main job on a simulated axis, start to finish."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.identify import identification_parts, warnings_in
from bristle.cli.options import Force, Json, Output, folder_named, print_json
from bristle.cli.terminal import complain, say, show

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
) -> None:
    """Do the main job on a simulated axis.

    A log, the identification, a log that it has not seen, the compensated loop, the report. Ends by saying how to do
    it with a log of your own.
    """
    from bristle.demo import BANNER, run
    from bristle.report.prediction import metrics_in_words

    # Nobody keeps the results of a demonstration where it puts them unasked.
    with Output(context, out, force=force or out == USUAL_PLACE).opened("demonstration") as (folder, report):
        demonstration = run(folder, command=context.obj, progress=report)
    if as_json:
        print_json(demonstration.summary)
        return
    lines = (f"  {word}: {value}" for word, value in metrics_in_words(demonstration.prediction))
    parts = identification_parts(demonstration.identification, demonstration.simulation, demonstration.following)
    show(BANNER, *parts, "On a log that was not fitted, predicted in closed loop:", *lines)
    for warning in warnings_in(demonstration.identification):
        complain(warning)
    say(f"""
The report: {out / "report.html"} (open it in a browser). Now with a log of your own:
  1. Copy {out / "axis.toml"} and write into it what your columns are called, in which units.
  2. bristle log YOUR.csv --axis YOUR.toml
  3. bristle identify YOUR.csv --axis YOUR.toml --out results
  4. bristle predict results/model.toml ANOTHER.csv --axis YOUR.toml""")
