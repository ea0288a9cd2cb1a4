"""``bristle run``: simulate an experiment."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import AllowCode, FigureFiles, Output, experiment_in, own_figures, refuse
from bristle.cli.terminal import complain, exit_code

EXAMPLE = """Example:
  bristle run experiment.toml --out results"""


def run(
    experiment: Annotated[
        Path, typer.Argument(metavar="EXPERIMENT.toml", help="An experiment file.")
    ],
    *,
    output: Output,
    figure: FigureFiles = None,
    allow_code: AllowCode = False,
    log: Annotated[
        bool,
        typer.Option(
            "--log",
            help="Also write to DIR, as CSV, the log that the drive of each variant would record.",
        ),
    ] = False,
) -> int:
    """Simulate an experiment.

    With [compare] in the file, bristle simulates several variants of the loop. bristle reports an unstable loop before the
    simulation, and does not simulate a loop that would diverge. The exit code is 1 if a loop diverges.

    With [effort] instead of [controller] and [reference], bristle simulates an open loop with this effort. A tolerance in
    [run] may replace substeps: bristle then chooses the time steps of the open loop.

    Writes summary.json and report.html into DIR. With --log, also writes log.csv: reference, encoder position and
    commanded effort.
    """
    from bristle.contract import admit_friction_of
    from bristle.files import provenance
    from bristle.report.compensation import closing_sentences
    from bristle.report.loops import about_loops, loop_doubts, loop_warnings, variant_table
    from bristle.report.messages import message
    from bristle.report.results import write_logs, write_report
    from bristle.report.simulation import promised_in, simulation_report, simulation_summary
    from bristle.simulation import on_another_rig, runnable, simulate

    refuse({"--log": log and not output.out}, "needs a folder to write into", "Add --out DIR")
    further, code = own_figures(figure, "run", has_folder=output.out is not None)
    with output.opened("simulating", [experiment]) as (folder, report):
        described = experiment_in(experiment, allow_code=allow_code, progress=report)
        admit_friction_of(described)
        stable, judged = runnable(described)
        runs = [variant.name for variant in stable.variants]
        about = about_loops(judged, on_another_rig(described))
        warnings = loop_warnings(about)
        for warning in warnings:
            complain(warning)
        diverging = {
            name: message(loop.finding) for name, loop in judged.items() if name not in runs
        }
        unstable = tuple(name for name, loop in judged.items() if not loop.is_stable)
        result = replace(simulate(stable, report), refused=diverging, unstable=unstable)
        source = provenance(output.command, **described.origins, figure=code)
        files = {}
        if folder and log:
            files = write_logs(folder, result)
        facts = {"provenance": source, "claims": promised_in(result)}
        summary = simulation_summary(result, files=files, diagnostics=about, **facts)
        if folder:
            doubts = loop_doubts(about)
            page = simulation_report(
                result,
                command=output.command,
                warnings=warnings,
                doubts=doubts,
                figures=further,
                **facts,
            )
            write_report(folder, page, summary)

    parts = []
    if result.variants:
        parts = [variant_table(result), *closing_sentences(result)]
    output.tell(summary, *parts)
    failed = [name for name, outcome in summary["variants"].items() if not outcome["completed"]]
    for name in (name for name in failed if name not in result.refused):
        complain(f"{name}: {summary['variants'][name]['status']}")
    return exit_code(failed)
