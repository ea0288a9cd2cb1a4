"""``bristle demo``: the main job on a simulated axis, start to finish."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import Force, Json

__all__ = ["EXAMPLE", "demo"]

EXAMPLE = """Example:
  bristle demo --out demo-results"""


def demo(
    context: typer.Context,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Write the results into this new folder.")] = Path(
        "bristle-demo"
    ),
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Do the main job on a simulated axis.

    A log, the identification, the compensated loop, the report. Ends by saying how to do it with a log of your own.
    """
