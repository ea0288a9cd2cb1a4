"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["AxisFile", "Force", "Json", "Out"]

AxisFile = Annotated[Path | None, typer.Option("--axis", metavar="AXIS.toml", help="The file that describes the axis.")]
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Write the results into this new folder.")]
Force = Annotated[bool, typer.Option("--force", help="Replace results that are in DIR already.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
