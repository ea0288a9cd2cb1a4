"""``bristle export``: a model as files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import (
    AllowCode,
    AxisFile,
    Force,
    Json,
    Listing,
    Output,
    dir_option,
    experiment_in,
    loaded_code,
    refuse,
)
from bristle.core.former import successor

if TYPE_CHECKING:
    from bristle.core import Experiment, Variant
    from bristle.exports import Target
    from bristle.report.exported import ExportedModel

Speed = Annotated[
    str | None,
    typer.Option(
        metavar="SPEED",
        help="Largest speed in the table; by default the largest speed of the fitted log.",
    ),
]
POINTS = 20
Points = Annotated[
    int,
    typer.Option(
        metavar="COUNT",
        help="Largest number of table entries. With --to table, 3 selects single values, not a curve.",
    ),
]
LogOfTable = Annotated[
    Path | None,
    typer.Option(metavar="LOG", help="Report the error of the written table along this log."),
]
VariantOfLaw = Annotated[
    str | None,
    typer.Option(
        "--variant",
        metavar="NAME",
        help="Variant in EXPERIMENT.toml; required if there are several.",
    ),
]
Step = Annotated[
    str | None,
    typer.Option(
        metavar="TIME",
        help="Time step of the self-test and the example, or of an FMU; by default 0.5 ms.",
    ),
]
Rest = Annotated[
    str | None,
    typer.Option(
        metavar="held|middle",
        help="Force at rest, if the target has no memory: force of the last direction (held), or mean of both directions (middle).",
    ),
]
HalMode = Annotated[
    str | None,
    typer.Option(
        "--hal-mode",
        metavar="torque|velocity",
        help="With --to hal: the command of the amplifier. Only torque is supported.",
    ),
]
AcceptHarm = Annotated[
    bool,
    typer.Option(
        "--accept-harm", help="Write the files even if they increase the simulated following error."
    ),
]
To = Annotated[
    str,
    typer.Option(
        "--to",
        metavar="TARGET|TARGET.py",
        help="A target from the list below, or a Python file with your own target.",
    ),
]
EXAMPLE = """Example:
  bristle export results --to c --out axis_c"""


def export(
    context: typer.Context,
    *,
    model: Annotated[
        Path | None,
        typer.Argument(
            metavar="[MODEL.toml|RESULTS]", help="A model file, or a folder of results of identify."
        ),
    ] = None,
    to: To,
    out: Annotated[Path, dir_option("--out", "Write the files to this new folder.")],
    name: Annotated[
        str, typer.Option(metavar="NAME", help="Name of the written files and functions.")
    ] = "axis_x",
    law: Annotated[
        Path | None,
        typer.Option(
            "--law",
            metavar="EXPERIMENT.toml",
            help="Write the control law of this experiment instead of a model.",
        ),
    ] = None,
    variant: VariantOfLaw = None,
    step: Step = None,
    tunable: Annotated[
        bool, typer.Option("--tunable", help="Make parameters changeable at run time.")
    ] = False,
    float32: Annotated[bool, typer.Option("--float32", help="Use single precision.")] = False,
    derivatives: Annotated[
        bool, typer.Option("--derivatives", help="Also write the derivatives of the force.")
    ] = False,
    axis: AxisFile = None,
    speed: Speed = None,
    points: Points = POINTS,
    log: LogOfTable = None,
    rest: Rest = None,
    hal_mode: HalMode = None,
    accept_harm: AcceptHarm = False,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a model or a control law as C, for a PLC or a drive.

    bristle prints every simplification that the target requires. A target of your own is a Python file that defines
    TARGET. bristle export runs this file. Test the file with bristle check first.

    --law writes the control law of one variant of an experiment: its controller with all feedforward.
    """
    from bristle.core import InputError
    from bristle.exports import target_named
    from bristle.report.exported import export_model_file

    read = law
    if law is None:
        read = model
    if read is None or (law is not None and model is not None):
        raise InputError(
            "needs either a model or a law",
            path="export",
            mend="Name a model file, or --law EXPERIMENT.toml",
        )
    if step == "":
        raise InputError(
            "is empty", path="--step", mend='Write a time, such as "1 ms", or leave --step out'
        )
    of_model = {
        "step": step,
        "axis": axis,
        "speed": speed,
        "log": log,
        "rest": rest,
        "derivatives": derivatives,
    }
    if to != "hal":
        refuse({"--hal-mode": hal_mode}, "applies to --to hal only")
    refuse({"--to draws": to == "draws"}, "was removed", successor("export --draws"))
    if law is None:
        refuse({"--variant": variant}, "applies to --law only")
    else:
        refuse(
            {f"--{option}": value for option, value in of_model.items()}, "applies to a model only"
        )
    file = read
    if read.is_dir():
        file = read / "model.toml"
    target: str | Target = to
    if to.endswith(".py"):  # naming the file allows its code
        from bristle.exports import load_target_file

        target = loaded_code([to], load_target_file)[0][0]
    stated = {"step": step, "speed": speed, "points": points != POINTS}
    refuse(
        {
            f"--{option}": stated[option]
            for option in target_named(target).useless
            if option in stated
        },
        f"has no effect on --to {to}",
    )
    output = Output(context, out, force=force, as_json=as_json)
    options: dict[str, Any] = {"command": output.command, "name": name, "allow_code": allow_code}
    inputs = [file]
    if log:
        inputs.append(log)
    if hal_mode:
        of_model |= {"mode": hal_mode}
    options |= {"tunable": tunable, "accept_harm": accept_harm}
    with output.opened("exporting", inputs, draws=False) as (folder, _):
        if law is not None:
            exported = _law(law, variant, target, **options, single=float32)
        else:
            exported = export_model_file(
                file, target, **options, **of_model, points=points, float32=float32
            )
        exported.write(folder)
    notes = (f"Note: {note}" for note in exported.summary["notes"])
    output.tell(exported.summary, *notes, files=", ".join(exported.product.files))


class _OfTargets(Listing):
    """Command whose help lists the targets."""

    heads = ("Target", "Output")

    @staticmethod
    def rows() -> list[tuple[str, str]]:
        """Return the targets, and the output of each."""
        from bristle.exports import TARGETS

        return [(target.name, described_target(target)) for target in TARGETS.values()]


COMMAND = _OfTargets


def described_target(target: Target) -> str:
    """Return the description of a target, and its further options."""
    able = {
        "--tunable": target.tunable,
        "--float32": target.single,
        "--derivatives": target.derivatives,
        "--log": target.compares,
        "--law": target.write_law is not None,
        "hysteresis operators": target.operators,
    }
    further = ", ".join(word for word, is_able in able.items() if is_able)
    if further:
        return f"{target.description}. Supports {further}."
    return f"{target.description}."


def _law(
    path: Path,
    variant: str | None,
    to: str | Target,
    *,
    command: str,
    name: str,
    allow_code: bool,
    **options: bool,
) -> ExportedModel:
    """Return the control law of a variant of an experiment as files."""
    from bristle.contract import admit
    from bristle.exports import Source, law_for, name_for, target_named
    from bristle.files import origins_of_code, provenance
    from bristle.report.exported import ExportedModel

    called = name_for(name)
    experiment = experiment_in(path, allow_code=allow_code)
    target = target_named(to)
    chosen = variant_of(experiment, variant)
    if chosen.feedforward.friction is not None:
        admit(chosen.feedforward.friction)
    source = provenance(command, **experiment.origins, target=origins_of_code([target]))
    product = law_for(target, chosen, called, Source(source), **options)
    return ExportedModel(target.name, product, f"{chosen.controller.name} of {chosen.name}", source)


def variant_of(experiment: Experiment, name: str | None) -> Variant:
    """Return the variant of this name, or the only variant if the name is missing."""
    variants = {variant.name: variant for variant in experiment.variants}
    if name is None and len(variants) == 1:
        return experiment.variants[0]
    if name not in variants:
        from bristle.core import InputError, did_you_mean

        reason = "is missing, but the experiment has several variants"
        mend = ""
        if name is not None:
            reason = "is not in the experiment"
        if name:
            mend = did_you_mean(name, variants)
        raise InputError(reason, path="variant", value=name, allowed=", ".join(variants), mend=mend)
    return variants[name]
