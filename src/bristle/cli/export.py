"""``bristle export``: a model as files for another world."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from bristle.cli.options import AllowCode, AxisFile, Force, Json, folder_named
from bristle.cli.prepared import experiment_in
from bristle.cli.terminal import complain, progress, say

if TYPE_CHECKING:
    from bristle.core import Model
    from bristle.exports.targets import Product

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
    from bristle.files.results import SUMMARY, results_folder
    from bristle.files.summary import as_json as json_text

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
            options = of_model | {"step": step or STEP, "points": points, "allow_code": allow_code}
            exported = _model(context, file, to, name_for(name), options)
        for file_name, content in exported.product.files.items():
            folder.write(file_name, content)
        summary: dict[str, Any] = {
            "target": to, "model": exported.name, "files": list(exported.product.files),
            "notes": [*exported.product.notes, *exported.beside], "provenance": exported.provenance,
        }  # fmt: skip
        folder.write(SUMMARY, json_text(summary))
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        for note in summary["notes"]:
            say(f"Note: {note}")
    complain(f"wrote {out}: {', '.join(exported.product.files)}")


class _Exported(NamedTuple):
    """Files of an export, what is in them, where it comes from, and notes of this command."""

    product: Product
    name: str
    provenance: dict[str, str]
    beside: tuple[str, ...] = ()


def _refuse_beside(unfit: bool, options: Mapping[str, Any], owner: str) -> None:
    """Refuse options that were given and belong to something else."""
    from bristle.core import InputError

    option = next((option for option, value in options.items() if value), None)
    if unfit and option is not None:
        raise InputError(f"belongs to {owner}", path=option, mend=f"Leave {option} out")


def _model(context: typer.Context, model: Path, to: str, name: str, options: Mapping[str, Any]) -> _Exported:
    """Return a friction model or an operator as files."""
    from bristle.core.content import content_of
    from bristle.exports.described import Source
    from bristle.exports.face import PERIOD
    from bristle.exports.targets import Request, files_for
    from bristle.files.arrays import read_arrays
    from bristle.files.axis import read_axis
    from bristle.files.model import read_model
    from bristle.files.operator import holds_operator, read_operator
    from bristle.files.provenance import provenance
    from bristle.files.toml import TOML_LIMIT
    from bristle.files.user_model import origins_of_code
    from bristle.friction import base_of
    from bristle.logs import read_log
    from bristle.testing import admit

    file = content_of(model, limit=TOML_LIMIT)
    if holds_operator(file):
        exported, offset, _ = read_operator(file)
        plant = None
        facts, code, drawn = {"uncertainty": {}, "treatment": {}}, (), {}
        beside = (f"the constant output beside the operator, {offset:g} in SI, is left out",) if offset else ()
    else:
        plant, exported, facts = read_model(file, allow_code=options["allow_code"])
        admit(exported)
        code, beside = origins_of_code([base_of(exported.component)]), ()
        drawn = read_arrays(model.parent, "draws") or (facts["bands"] or {}).get("draws", {}) if to == "draws" else {}
    axis = None if options["axis"] is None else read_axis(options["axis"])
    log = None if options["log"] is None else read_log(options["log"], axis)
    source = provenance(context.obj, model=file, log=log, code=code)
    request = Request(
        exported, name, PERIOD(options["step"], "--step", None), Source(source, facts["uncertainty"]),
        options["tunable"], options["float32"], axis, _speed(options["speed"], exported, facts["treatment"]),
        options["points"], 1.0 if plant is None else float(plant.values.get("M", 1.0)), plant, log, facts,
        options["draws"] or 0, drawn,
    )  # fmt: skip
    return _Exported(files_for(to, request), exported.name, source, beside)


def _law(
    context: typer.Context, path: Path, variant: str | None, to: str, name: str, *, allow_code: bool
) -> _Exported:  # fmt: skip
    """Return the control law of a variant of an experiment as files."""
    from bristle.core.content import SIZE_LIMIT
    from bristle.exports.described import Source
    from bristle.exports.targets import law_for, variant_of
    from bristle.files.provenance import provenance
    from bristle.testing import admit

    experiment = experiment_in(path, allow_code=allow_code, size_limit=SIZE_LIMIT)
    chosen = variant_of(experiment, variant)
    if chosen.feedforward.friction is not None:
        admit(chosen.feedforward.friction)
    source = provenance(context.obj, **experiment.origins)
    return _Exported(law_for(to, chosen, name, Source(source)), f"{chosen.controller.name} of {chosen.name}", source)


def _speed(text: str | None, friction: Model, treatment: Mapping[str, float]) -> float:
    """Return the largest speed of a table: as typed, or that of the log that the model was fitted to."""
    from bristle.core.edge import amount
    from bristle.core.variable import Variable

    if text is None:
        return float(treatment.get("velocity_max", 0.0))
    return amount(Variable("length/time", "largest speed", min=0.0))(text, "--speed", friction.kind)
