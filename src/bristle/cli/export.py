"""``bristle export``: a model as files for another world."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import AllowCode, AxisFile, Force, Json, folder_named
from bristle.cli.terminal import complain, progress, say

if TYPE_CHECKING:
    from bristle.core import Model

__all__ = ["EXAMPLE", "export"]

EXAMPLE = """Example:
  bristle export results --to c --out axis_c"""


def export(
    context: typer.Context,
    model: Annotated[
        Path, typer.Argument(metavar="MODEL.toml|RESULTS", help="A model file, or results of identify with one.")
    ],
    to: Annotated[str, typer.Option("--to", metavar="TARGET", help="c, wasm, table, tf5200, mjcf, fmu2 or fmu3.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the files into this new folder.")
    ],
    *,
    name: Annotated[str, typer.Option(metavar="NAME", help="What files and functions are called.")] = "axis_x",
    step: Annotated[
        str, typer.Option(metavar="TIME", help="Time step of the self-test and of the example; that inside of an FMU.")
    ] = "0.5 ms",
    tunable: Annotated[bool, typer.Option("--tunable", help="Let parameters be changed at run time.")] = False,
    float32: Annotated[bool, typer.Option("--float32", help="Write C in single precision.")] = False,
    axis: AxisFile = None,
    speed: Annotated[
        str | None, typer.Option(metavar="SPEED", help="Largest of a table; that of the log that was fitted, if known.")
    ] = None,
    points: Annotated[int, typer.Option(metavar="COUNT", help="Entries of a table for each direction, at most.")] = 20,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a friction model as C, for the web, for a drive.

    c, of hysteresis operators too: a header, a source that compiles alone, an example, and a self-test that proves
    that the target gives the same bits. Nothing is compiled here, and no compiler is needed. wasm: a module and the
    script that loads it, for a browser or node. table: effort over velocity, CSV, in the units of the log that
    AXIS.toml describes. tf5200: the same for the friction compensation of a Beckhoff TF5200 CNC. mjcf: a scene of
    MuJoCo with what it has of friction. fmu2, fmu3: FMUs of the friction and, where the model file has a plant, of
    both, with a library for each platform that there is a compiler for.
    """
    from bristle.core.content import content_of
    from bristle.exports.described import Source
    from bristle.exports.face import PERIOD
    from bristle.exports.targets import Request, files_for, name_for
    from bristle.files.axis import read_axis
    from bristle.files.model import read_model
    from bristle.files.operator import holds_operator, read_operator
    from bristle.files.provenance import provenance
    from bristle.files.results import SUMMARY, results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.toml import TOML_LIMIT
    from bristle.files.user_model import origins_of_code
    from bristle.friction import base_of
    from bristle.testing import admit

    file = content_of(model / "model.toml" if model.is_dir() else model, limit=TOML_LIMIT)
    with results_folder(out, force=force, reads=[file]) as folder, progress("exporting"):
        if holds_operator(file):
            exported, offset, _ = read_operator(file)
            plant = None
            facts, code = {"uncertainty": {}, "treatment": {}}, ()
            beside = (f"the constant output beside the operator, {offset:g} in SI, is left out",) if offset else ()
        else:
            plant, exported, facts = read_model(file, allow_code=allow_code)
            admit(exported)
            code, beside = origins_of_code([base_of(exported.component)]), ()
        source = provenance(context.obj, model=file, code=code)
        request = Request(
            exported, name_for(name), PERIOD(step, "--step", None), Source(source, facts["uncertainty"]),
            tunable, float32, None if axis is None else read_axis(axis), _speed(speed, exported, facts["treatment"]),
            points,
            1.0 if plant is None else float(plant.values.get("M", 1.0)), plant,
        )  # fmt: skip
        product = files_for(to, request)
        for file_name, content in product.files.items():
            folder.write(file_name, content)
        summary: dict[str, Any] = {
            "target": to, "model": exported.name, "files": list(product.files), "notes": [*product.notes, *beside],
            "provenance": source,
        }  # fmt: skip
        folder.write(SUMMARY, json_text(summary))
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        for note in summary["notes"]:
            say(f"Note: {note}")
    complain(f"wrote {out}: {', '.join(product.files)}")


def _speed(text: str | None, friction: Model, treatment: Mapping[str, float]) -> float:
    """Return the largest speed of a table: as typed, or that of the log that the model was fitted to."""
    from bristle.core.edge import amount
    from bristle.core.variable import Variable

    if text is None:
        return float(treatment.get("velocity_max", 0.0))
    return amount(Variable("length/time", "largest speed", min=0.0))(text, "--speed", friction.kind)
