"""``bristle export``: a model as files for another world."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import AllowCode, AxisFile, Force, Json, folder_named
from bristle.cli.prepared import experiment_in
from bristle.cli.terminal import complain, progress, say

if TYPE_CHECKING:
    from bristle.workflow.exported import ExportedModel

__all__ = ["EXAMPLE", "export"]

STEP = "0.5 ms"
Speed = Annotated[
    str | None, typer.Option(metavar="SPEED", help="Largest of a table; that of the log that was fitted, if known.")
]
Points = Annotated[int, typer.Option(metavar="COUNT", help="Entries of a table, at most; 3: gravity and two levels.")]
LogOfTable = Annotated[
    Path | None, typer.Option(metavar="LOG", help="Tell how far a table is from the model along this log.")
]
VariantOfLaw = Annotated[
    str | None, typer.Option("--variant", metavar="NAME", help="Which variant of that experiment.")
]
Step = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="Time step of self-test and example, or inside of an FMU; 0.5 ms by default."),
]
Draws = Annotated[
    int | None, typer.Option(metavar="COUNT", help="How many draws of what was identified; 1000 by default.")
]
TARGETS = "c, wasm, st, cuda, table, tf5200, sinumerik, cogging, mjcf, draws, fmu2 or fmu3."
EXAMPLE = """Example:
  bristle export results --to c --out axis_c"""


def export(
    context: typer.Context,
    *,
    model: Annotated[
        Path | None,
        typer.Argument(metavar="[MODEL.toml|RESULTS]", help="A model file, or results of identify with one."),
    ] = None,
    to: Annotated[str, typer.Option("--to", metavar="TARGET", help=TARGETS)],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the files into this new folder.")
    ],
    name: Annotated[str, typer.Option(metavar="NAME", help="What files and functions are called.")] = "axis_x",
    law: Annotated[
        Path | None,
        typer.Option("--law", metavar="EXPERIMENT.toml", help="Write the control law of an experiment, not a model."),
    ] = None,
    variant: VariantOfLaw = None,
    step: Step = None,
    tunable: Annotated[bool, typer.Option("--tunable", help="Let parameters be changed at run time.")] = False,
    float32: Annotated[bool, typer.Option("--float32", help="Write C in single precision.")] = False,
    axis: AxisFile = None,
    speed: Speed = None,
    points: Points = 20,
    log: LogOfTable = None,
    draws: Draws = None,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a model or a control law as C, for a PLC or a drive.

    c, of hysteresis operators too: a header, a source that compiles alone, an example, and a self-test that proves
    that the target gives the same bits. Nothing is compiled here, and no compiler is needed. wasm: a module and the
    script that loads it, for a browser or node. st, of operators too: a function block in Structured Text for a PLC,
    its self-test, and both as XML of PLCopen. table: effort over velocity, CSV, in the units of the log and of the
    drive that AXIS.toml describes; with --points 3, gravity, a level for each direction and the inertia. tf5200: the
    same for the friction compensation of a Beckhoff TF5200 CNC. sinumerik: start values for that of a SINUMERIK, to
    be tuned by the circularity test. cogging: its harmonics, where they were identified. mjcf: a scene of MuJoCo with
    what it has of friction. draws: what the bootstrap found, a row a draw with all correlations, and the same as
    attributes of such a scene. fmu2, fmu3: FMUs of the friction and, where the model file has a plant, of both, with a
    library for each platform that there is a compiler for.

    With --law, what a variant of an experiment commands, for c and st: its controller and all that is fed forward.
    """
    from bristle.core import InputError
    from bristle.exports.targets import name_for
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.workflow.exported import export_model_file

    read = model if law is None else law
    if read is None or (law is not None and model is not None):
        raise InputError("must be a model or a law, and one of them", path="export",
                         mend="Name a model file, or --law EXPERIMENT.toml")  # fmt: skip
    _refuse_beside(law is None, {"--variant": variant}, "--law")
    of_model = {"step": step, "axis": axis, "speed": speed, "tunable": tunable, "float32": float32, "log": log,
                "draws": draws}  # fmt: skip
    _refuse_beside(law is not None, {f"--{option}": value for option, value in of_model.items()}, "a model")
    file = read / "model.toml" if read.is_dir() else read
    with results_folder(out, force=force, reads=[file, log] if log else [file]) as folder, progress("exporting"):
        if law is not None:
            exported = _law(context, law, variant, to, name_for(name), allow_code=allow_code)
        else:
            options = of_model | {"step": step or STEP, "draws": draws or 0, "points": points}
            exported = export_model_file(file, to, command=context.obj, name=name, allow_code=allow_code, **options)
        exported.write(folder)
    summary = exported.summary
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        for note in summary["notes"]:
            say(f"Note: {note}")
    complain(f"wrote {out}: {', '.join(exported.product.files)}")


def _refuse_beside(unfit: bool, options: Mapping[str, Any], owner: str) -> None:
    """Refuse options that were given and belong to something else."""
    from bristle.core import InputError

    option = next((option for option, value in options.items() if value), None)
    if unfit and option is not None:
        raise InputError(f"belongs to {owner}", path=option, mend=f"Leave {option} out")


def _law(
    context: typer.Context, path: Path, variant: str | None, to: str, name: str, *, allow_code: bool
) -> ExportedModel:  # fmt: skip
    """Return the control law of a variant of an experiment as files."""
    from bristle.core.content import SIZE_LIMIT
    from bristle.exports.described import Source
    from bristle.exports.targets import law_for, variant_of
    from bristle.files.provenance import provenance
    from bristle.testing import admit
    from bristle.workflow.exported import ExportedModel

    experiment = experiment_in(path, allow_code=allow_code, size_limit=SIZE_LIMIT)
    chosen = variant_of(experiment, variant)
    if chosen.feedforward.friction is not None:
        admit(chosen.feedforward.friction)
    source = provenance(context.obj, **experiment.origins)
    return ExportedModel(
        to, law_for(to, chosen, name, Source(source)), f"{chosen.controller.name} of {chosen.name}", source
    )
