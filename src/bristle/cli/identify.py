"""``bristle identify``: from a log to a friction model, its uncertainty, and the gain of compensation."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from time import process_time
from typing import TYPE_CHECKING, Annotated, Any, TextIO

import typer

from bristle.cli.commands import SPELLINGS
from bristle.cli.options import (
    LOG_FILE,
    AxisFiles,
    FigureFiles,
    Output,
    Readers,
    Verbose,
    holds_own,
    own_figures,
    own_model,
    own_readers,
    refuse,
    size_limit,
    toml_content,
)
from bristle.cli.signals import INTERRUPTED
from bristle.cli.terminal import complain, exit_code, progress, show, show_lines

if TYPE_CHECKING:
    from bristle.core import Content
    from bristle.identification import Identification
    from bristle.prediction import Following
    from bristle.report.brief import Line
    from bristle.report.identified import Identified, Outcome
    from bristle.report.table import Table
    from bristle.simulation import SimulationResult


EXAMPLE = """Example:
  bristle identify axis.mat --axis axis.toml --out results
  bristle identify axis.mat --axis axis.toml --model lugre,maxwell_slip+asymmetry --out compared
  bristle identify logs --each --axis axis.toml --out fleet"""

REPORT = 1.0  # duration of the report over the time until the log is read
LOOPED = 300_000.0  # samples by which the loop lasts longer by this time; of a short log, it lasts twice as long
WITHOUT_LOOP = "interrupted: all models fitted; the loop was not simulated"

Method = Annotated[
    str | None,
    typer.Option(
        "--method",
        metavar="METHOD",
        help="Method: prediction_error, inverse_dynamics, output_error; by default that of the axis file.",
    ),
]
Separate = Annotated[
    bool,
    typer.Option(
        "--each", help="Identify each log separately: one row per log in DIR. Later runs add rows."
    ),
]
Robot = Annotated[
    Path | None,
    typer.Option(
        "--robot",
        metavar="ROBOT.urdf",
        help="Identify an arm: URDF or Denavit-Hartenberg parameters. One row per joint in DIR.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        metavar="COUNT",
        min=1,
        max=1024,
        help="With --each: number of processes; by default one per core.",
    ),
]
Logs = Annotated[
    list[Path], typer.Argument(metavar="LOG...", help=f"One log or several: {LOG_FILE}")
]
ModelNames = Annotated[
    str | None,
    typer.Option(
        "--model",
        metavar="NAME[+slot][,NAME...]",
        help="Models to compare: built-in names, 'all', or a file my_model.py. A slot is a built-in name or a file my_slot.py. By default "
        "coulomb_viscous, stribeck+asymmetry and lugre+asymmetry; with --each coulomb_viscous.",
    ),
]
Cutoff = Annotated[
    str | None,
    typer.Option(
        "--cutoff", metavar="FREQUENCY", help="Cut-off of the zero-phase filter, such as '100 Hz'."
    ),
]
Draws = Annotated[
    int,
    typer.Option(
        "--draws",
        metavar="COUNT",
        help="Number of simulated logs for the 95 % intervals: 20 to 100000, or 0 for no intervals.",
    ),
]
Free = Annotated[
    str,
    typer.Option(
        "--free",
        metavar="NAME[,NAME...]",
        help="Shape parameters that bristle also identifies, such as exponent of dahl.",
    ),
]


def identify(
    *,
    log: Logs,
    axis: AxisFiles = None,
    model: ModelNames = None,
    output: Output,
    figure: FigureFiles = None,
    cutoff: Cutoff = None,
    draws: Draws = 100,
    free: Free = "",
    method: Method = None,
    separate: Separate = False,
    robot: Robot = None,
    workers: Workers = None,
    reader: Readers = None,
    verbose: Verbose = False,
) -> int:
    """Identify friction models from one log or several.

    bristle ranks several models by their error on stretches of the log, or of each log, that it did not fit. To test a
    model on another day, predict the log of that day. Method output_error fits a simulation of the axis to the log, in
    closed loop if the axis file has a controller. If the axis file names the columns input and output, bristle
    identifies hysteresis operators.

    Writes model.toml, drive_table.csv, summary.json, report.html, experiment.toml (for bristle run) and files for other
    programs and for bristle.load into DIR. Ctrl-C ends the search: bristle then writes the best result so far, marks it
    as unfinished, and ends with exit code 130. A second Ctrl-C ends at once.

    With --each, bristle writes one row per log into DIR, for br.read_study. If a log fails, its row states the reason. LOG
    may be a folder, and FILE::* selects every table of a file. Give the same command again to add missing or new logs.
    With --robot, LOG contains all joints of an arm, and AXIS.toml has a table [[joint]] for each of them.
    """
    from bristle.core import Variable, amount
    from bristle.files import axes_in, describes_curves
    from bristle.models.friction import DEFAULT_MODELS

    axes = [toml_content(file) for file in axis or ()]
    of_joints = robot is not None or any(axes_in(content) for content in axes)
    separate = separate or of_joints
    if separate:
        refuse(
            {"--force": output.force},
            "cannot replace the results of --each, because bristle adds to them",
            "Name another folder",
        )
        refuse(
            {"--format, --figure": output.formats or figure},
            "with --each, the results have no figures",
            "Read the rows with br.read_study(DIR)",
        )
    else:
        refuse({"--workers": workers is not None}, "applies to --each only", "Add --each")
    output.context.with_resource(own_readers(reader))
    if axes and describes_curves(axes[0]) and not separate:
        from bristle.cli.operators import identify_operators

        refuse({"--figure": figure}, "applies to friction, not to recorded curves")
        return identify_operators(log, axes, model, output)
    # Parameters of different models cannot be compared.
    names = DEFAULT_MODELS
    if separate:
        names = "coulomb_viscous"
    if robot:
        names = "lugre"
    if model is not None:
        names = model
    models = []
    for part in map(str.strip, names.split(",")):
        if holds_own(part):
            part = own_model(part, "--model")
        models.append(part)
    if cutoff is not None:
        hertz = amount(Variable("frequency", "cut-off of the filter", min=0.0), exclusive=True)
        cutoff = hertz(cutoff, "--cutoff", None)
    options = {"model": models, "cutoff": cutoff, "free": free, "draws": draws, "method": method}
    if separate:
        identify_each = resolve_name(SPELLINGS["identify --each"])
        return identify_each(
            log, axes, options, output, readers=reader or (), workers=workers, robot=robot
        )
    return _identify_friction(log, axes, options, output, figure, verbose=verbose)


def _identify_friction(
    log: list[Path],
    axis: list[Content],
    options: dict[str, Any],
    output: Output,
    own: list[Path] | None,
    *,
    verbose: bool,
) -> int:
    from bristle.core import between
    from bristle.files import logs_and_axes, read_axis
    from bristle.identification import Work
    from bristle.report.identified import identify as identified

    out = output.out
    further, code = own_figures(own, "identify", has_folder=out is not None)
    with output.opened("identifying", [*log, *axis]) as (folder, report):
        answer = None
        if not (output.as_json or output.quiet):
            answer = partial(_show_first, sys.stderr)
        work = Work(report)
        try:
            pairs = logs_and_axes(log, [read_axis(file) for file in axis], size_limit=size_limit())
            recorded, axes = map(list, zip(*pairs, strict=True))
            reading = process_time()
            looped = axes[0] is not None and axes[0].controller is not None
            looping = looped * reading * (2.0 + len(recorded[0]) / LOOPED)
            work.ahead = looping + REPORT * reading
            identification = identified(
                recorded, axis=axes, progress=work.task(), answer=answer, **options
            )
        except KeyboardInterrupt:
            complain("no model is fitted yet, so bristle writes no results")
            raise
        name = log[0].stem
        if axes[0]:
            name = axes[0].name
        words = {
            "command": output.command,
            "axis_name": name,
            "figures": further,
            "files": {"axis": axis, "figure": code},
        }
        work.ahead = REPORT * reading
        try:
            outcome = identification.outcome_with(
                progress=between(work.task("", looping), 0.5, 1.0), **words
            )
        except KeyboardInterrupt:
            if identification.unfinished:  # the second interruption
                raise
            outcome = replace(identification, unfinished=WITHOUT_LOOP).outcome_with(**words)
        identification = outcome.identification
        if outcome.uncertified:
            complain(f"no certificates: {outcome.uncertified}")
        if folder:
            work.ahead = 0.0
            work.task("writing the report", REPORT * reading)(0.0)
            try:
                outcome.write(folder)
            except KeyboardInterrupt:
                if identification.unfinished:
                    raise
                outcome.write(folder)  # nothing is missing
    if output.as_json:
        output.tell(outcome.summary)
    else:
        results, following = _steps(outcome, out)
        show_identification(
            outcome, verbose=verbose, quiet=output.quiet, results=results, following=following
        )
        # A rehearsal takes seconds: only a person who reads its line waits for it.
        if out and not output.quiet:
            show_lines(_motion_to_record(identification, options["draws"], out, axis))
    if identification.unfinished:
        complain(identification.unfinished)
    return exit_code(identification.unfinished, INTERRUPTED)


def _show_first(stream: TextIO, identification: Identification) -> None:
    """Show the first of several models, beside the progress and apart from the results."""
    from bristle.report.brief import first_answer

    show_lines(first_answer(identification), stream)


def _motion_to_record(
    identification: Identified, draws: int, out: Path, axis: Sequence[Any]
) -> list[Line]:
    """Return the line on the motion that narrows open intervals; without draws, intervals are unknown and bristle designs no motion."""
    from bristle.report.brief import Line, advice_to_record

    # A motion is designed on the identified axis: of a faulty log, that is not the axis.
    if not draws or identification.unfinished or advice_to_record(identification.best):
        return []
    from bristle.core import Axis
    from bristle.report.next_motion import next_motion

    logs = (identification.log, *identification.further_logs)
    log = max(logs, key=lambda log: log.position.values.max() - log.position.values.min())
    motion = None
    with progress("rehearsing a motion") as report, suppress(KeyboardInterrupt):
        motion = next_motion(
            identification.best, identification.axis or Axis(kind=log.kind), log, report
        )
    if motion is None:
        return []
    file = "AXIS.toml"
    if axis:
        file = str(axis[0].source)
    words = [
        "bristle",
        "excite",
        file,
        "--model",
        str(out / "model.toml"),
        "--for",
        motion.purposes,
        *motion.options,
    ]
    before = "run"
    if motion.limits:
        before = f"write {' and '.join(motion.limits)} under [limits] of {file}, then run"
    command = shlex.join([*words, "--out", f"{out}_motion"])
    return [
        Line("Record", f"To narrow the 95 % intervals ({motion.text}), {before}:", command=command)
    ]


def _steps(outcome: Outcome, out: Path | None) -> tuple[list[Line], list[Line]]:
    """Return the lines on the results, and on the next step: the loop, or a better log."""
    from bristle.report.brief import Line, advice_to_record
    from bristle.report.identified import EXPERIMENT
    from bristle.report.two_masses import EXPERIMENT_FILE as TWO_MASSES

    if out is None:
        return [], [
            Line("Next", "Add --out DIR for the report, the drive table and the loop to simulate.")
        ]
    masses = outcome.identification.two_masses
    has_table = masses is not None and masses.is_elastic
    further = ""
    if has_table:
        further = f", {TWO_MASSES}"
    table = ""
    if outcome.table:
        table = "drive_table.csv, "
    results = [Line("Results", f"{out}: report.html, {table}model.toml, {EXPERIMENT}{further}")]
    file = out / EXPERIMENT
    gains = " and ".join(outcome.following_experiment(out).missing)
    command = shlex.join(
        ["bristle", "run", str(file), "--out", str(out.with_name(f"{out.name}_loop"))]
    )
    lines = [Line("Next", "Simulate the loop:", command=command)]
    if gains:
        lines = [
            Line(
                "Next",
                f"Write {gains} into the axis file and identify again, or fill in {file} and run:",
                command=command,
            )
        ]
    again = advice_to_record(outcome.identification.best)
    if again:
        lines = [Line("Next", again)]
    if has_table:
        command = shlex.join(
            [
                "bristle",
                "run",
                str(out / TWO_MASSES),
                "--out",
                str(out.with_name(f"{out.name}_two_masses")),
            ]
        )
        lines.append(
            Line(
                "Table",
                "Compare the error of the load with feedforward of one mass and of both masses:",
                command=command,
            )
        )
    return results, lines


def identification_parts(
    identification: Identification,
    simulation: SimulationResult | None,
    following: Following | None = None,
) -> list[str | Table]:
    """Return the full output of -v: parameters, comparison of models, gain, warnings and notes."""
    from bristle.report.compensation import about_loop, gain_of
    from bristle.report.judgement import misfit
    from bristle.report.log_tables import break_away_table
    from bristle.report.messages import warnings_of, whole_sentence
    from bristle.report.model_tables import comparison_table, parameter_table
    from bristle.report.sweep import sweep_table
    from bristle.report.table import capital
    from bristle.report.two_masses import two_masses_table

    best = identification.best
    parts: list[str | Table] = [parameter_table(best)]
    parts += [
        whole_sentence(diagnostic)
        for diagnostic in best.diagnostics
        if diagnostic.code == "delay_found"
    ]
    if len(identification.fits) > 1:
        parts.append(comparison_table(identification, details=False))
    tables = (
        break_away_table(identification),
        sweep_table(identification),
        two_masses_table(identification),
    )
    parts += [table for table in tables if table is not None]
    parts += [f"{capital(text)}." for text in misfit(best)]
    gain = None
    if simulation:
        gain = gain_of(simulation)
    parts += about_loop(gain, following, best.plant.kind)
    parts += [f"Note: {note}" for note in identification.notes]
    return [*parts, *(f"Warning: {warning}." for warning in warnings_of(best))]


def show_identification(
    outcome: Outcome,
    *,
    verbose: bool,
    quiet: bool,
    results: Sequence[Line] = (),
    following: Sequence[Line] = (),
) -> None:
    """Write an identification to the standard output: in brief, in full or only its verdict, then the next steps."""
    from bristle.report.brief import brief
    from bristle.report.sweep import sweep_lines

    identification = outcome.identification
    *lines, feedforward, verdict = brief(
        identification, outcome.simulation, outcome.following, identification.axis
    )
    if quiet:
        show_lines([verdict])
        return
    if verbose:
        show(*identification_parts(identification, outcome.simulation, outcome.following))
    show_lines([*lines, *sweep_lines(identification), *results, feedforward, verdict, *following])
