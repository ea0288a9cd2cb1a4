"""``bristle identify``: from a log to a friction model, its uncertainty, and what it gains."""

from __future__ import annotations

import shlex
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.failure import INTERRUPTED
from bristle.cli.findings import show_identification
from bristle.cli.fleet import identify_each, refuse_mixed
from bristle.cli.options import (
    LOG_FILE,
    AxisFiles,
    Data,
    FigureFiles,
    Figures,
    Force,
    Formats,
    Json,
    Out,
    Readers,
    SizeLimit,
    bytes_asked,
    own_figures,
    own_readers,
)
from bristle.cli.own import holds_own, own_model
from bristle.cli.terminal import complain, progress

if TYPE_CHECKING:
    from bristle.core.content import Content

__all__ = ["EXAMPLE", "identify"]

OF_A_FLEET = "coulomb_viscous"  # parameters of several models do not compare

EXAMPLE = """Example:
  bristle identify axis.mat --axis axis.toml --out results
  bristle identify axis.mat --axis axis.toml --model lugre,maxwell_slip+asymmetry --out compared
  bristle identify logs --each --axis axis.toml --out fleet"""

Thresholds = Annotated[
    list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A threshold of the diagnostics; may be repeated.")
]
Separate = Annotated[bool, typer.Option("--each", help="Each log by itself: a row each in DIR, which is gone on with and may grow.")]
Workers = Annotated[int | None, typer.Option(metavar="COUNT", min=1, max=1024, help="With --each: processes; as many as cores by default.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="With --each: tell how many logs there are and how long they take.")]
Logs = Annotated[list[Path], typer.Argument(metavar="LOG...", help=f"One log or several: {LOG_FILE}")]
ModelNames = Annotated[
    str | None,
    typer.Option(
        "--model",
        metavar="NAME[+slot][,NAME...]",
        help="Models to fit and compare, or a file my_model.py; 'all' for every one of bristle. By default "
        "coulomb_viscous, stribeck+asymmetry and lugre+asymmetry, with --each coulomb_viscous. A slot may be a file "
        "my_slot.py.",
    ),
]
Cutoff = Annotated[str | None, typer.Option("--cutoff", metavar="FREQUENCY", help="Of the zero-phase filter, such as '100 Hz'.")]
Decimation = Annotated[int | None, typer.Option("--decimation", metavar="COUNT", help="Keep one of so many filtered samples.")]
Draws = Annotated[int, typer.Option("--draws", metavar="COUNT", help="Simulated logs for the 95 % intervals: 0, or 20 to 100000.")]
Free = Annotated[str, typer.Option("--free", metavar="NAME[,NAME...]", help="Shapes to identify too, such as exponent of dahl.")]
Method = Annotated[
    str | None, typer.Option("--method", metavar="METHOD", help="inverse_dynamics or output_error, else as the axis file says.")
]
Everywhere = Annotated[bool | None, typer.Option("--global", help="Look over the whole range of each parameter first.")]


def identify(
    *,
    context: typer.Context,
    log: Logs,
    axis: AxisFiles = None,
    model: ModelNames = None,
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    figure: FigureFiles = None,
    cutoff: Cutoff = None,
    decimation: Decimation = None,
    draws: Draws = 100,
    free: Free = "",
    method: Method = None,
    everywhere: Everywhere = None,
    thresholds: Thresholds = None,
    separate: Separate = False,
    workers: Workers = None,
    dry_run: DryRun = False,
    reader: Readers = None,
    size_limit: SizeLimit = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Identify friction models from one log or several.

    Several models are compared on stretches of the log that they were not fitted to, or, of several logs, on each of
    them in turn. The method output_error simulates the axis, in the loop of its controller where the axis file has one,
    and fits all parameters to that. Where the axis file names the columns input and output, hysteresis operators are
    identified.

    Writes model.toml, drive_table.csv, summary.json, report.html and, for bristle run, experiment.toml into DIR, and
    beside them what other programs and bristle.load read. Interrupted (Ctrl-C), it ends with the best found until then,
    marked unfinished, and exit code 130.

    With --each, every log is a row of its own in DIR, which br.read_study reads; one that fails is a
    row with its reason. LOG may be a folder then, and FILE::* is every table of a file. The same command does what is
    missing, and with further logs those.
    """
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.curves import describes_curves
    from bristle.files.toml import TOML_LIMIT

    refuse_mixed(separate=separate, force=force, figures=bool(formats or data or figure), workers=workers is not None, dry_run=dry_run)
    context.with_resource(own_readers(reader))
    limit = bytes_asked(size_limit)
    axes = [content_of(file, limit=TOML_LIMIT) for file in axis or ()]
    if axes and describes_curves(axes[0]) and not separate:
        from bristle.cli.operators import identify_operators

        if figure:
            raise InputError("is for friction, not for recorded curves", path="--figure", mend="Leave --figure out")
        return identify_operators(
            log, axes, model, out, force=force, as_json=as_json, command=context.obj, limit=limit, figures=(formats, data)
        )
    options = {
        "model": _models(model),
        "cutoff": _hertz(cutoff),
        "decimation": decimation,
        "free": free,
        "draws": draws,
        "method": method,
        "global_search": everywhere,
        "settings": _thresholds(thresholds or []),
    }
    if separate:
        options["model"] = _models(OF_A_FLEET if model is None else model)
        return identify_each(
            log,
            axes,
            options,
            out,
            command=context.obj,
            readers=reader or (),
            limit=limit,
            workers=workers,
            dry_run=dry_run,
            as_json=as_json,
        )
    return _identify_friction(
        log, axes, options, out, force=force, as_json=as_json, command=context.obj, limit=limit, figures=(formats, data), own=figure
    )


def _identify_friction(
    log: list[Path],
    axis: list[Content],
    options: dict[str, Any],
    out: Path | None,
    *,
    force: bool,
    as_json: bool,
    command: str,
    limit: int,
    figures: Figures,
    own: list[Path] | None,
) -> int:
    from bristle.files.arguments import axes_for
    from bristle.files.axis import read_axis
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.logs import read_log
    from bristle.report.figure_files import figure_files
    from bristle.workflow import identify as identified
    from bristle.workflow.outcome import EXPERIMENT

    further, code = own_figures(own, "identify", has_folder=out is not None)
    with (
        results_folder(out, force=force, reads=[*log, *axis]) if out else nullcontext() as folder,
        progress("identifying") as report,
        figure_files(folder, *figures),
    ):
        axes = axes_for([read_axis(file) for file in axis], len(log))
        recorded = [read_log(file, described, size_limit=limit) for file, described in zip(log, axes, strict=True)]
        identification = identified(recorded, axis=axes, progress=report, **options)
        outcome = identification.outcome_with(
            command=command,
            axis_name=axes[0].name if axes[0] else log[0].stem,
            progress=report,
            figures=further,
            files={"axis": axis, "figure": code},
        )
        if outcome.uncertified:
            complain(f"no certificates: {outcome.uncertified}")
        if folder:
            outcome.write(folder)
    if as_json:
        sys.stdout.write(json_text(outcome.summary))
    else:
        show_identification(identification, outcome.simulation, outcome.following)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
        complain(_next_step(outcome.following_experiment(out).missing, out / EXPERIMENT))
    if identification.unfinished:
        complain(identification.unfinished)
    return INTERRUPTED if identification.unfinished else 0


def _next_step(missing: tuple[str, ...], file: Path) -> str:
    """Return what to type next, where the loop is known, or what to fill in first."""
    loop = file.parent.with_name(f"{file.parent.name}_loop")
    command = shlex.join(["bristle", "run", str(file), "--out", str(loop)])
    if not missing:
        return f"next: {command}"
    gains = " and ".join(missing)
    return (
        f"next: write {gains} into the axis file, as {file} shows, and identify again: that judges the loop by the "
        f"log too. Or fill in {gains} in {file} (--force then no longer writes over {file.parent}), then {command}"
    )


def _models(text: str | None) -> list[Any]:
    """Return the models of a list: names, and models with files of a user's own."""
    from bristle.friction import DEFAULT_MODELS

    names = [part.strip() for part in (DEFAULT_MODELS if text is None else text).split(",")]
    return [own_model(name, "--model") if holds_own(name) else name for name in names]


def _thresholds(texts: list[str]) -> dict[str, float]:
    """Return the thresholds of ``--set NAME=VALUE``."""
    from bristle.core import InputError
    from bristle.identification.settings import Settings

    thresholds: dict[str, float] = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            thresholds[name.strip()] = float(value)
        except ValueError:
            raise InputError("must be a name and a number", path="--set", value=text, allowed="NAME=VALUE") from None
    Settings.of(thresholds, "--set")
    return thresholds


def _hertz(text: str | None) -> float | None:
    if text is None:
        return None
    from bristle.core import Variable
    from bristle.core.edge import amount

    return amount(Variable("frequency", "cut-off of the filter", min=0.0), exclusive=True)(text, "--cutoff", None)
