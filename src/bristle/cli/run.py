"""``bristle run``: simulate an experiment."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import AllowCode, Data, FigureFiles, Force, Formats, Json, Out, SizeLimit, bytes_asked, own_figures
from bristle.cli.prepared import experiment_in
from bristle.cli.terminal import complain, progress, say, show_table

if TYPE_CHECKING:
    from bristle.loop import Assessment

__all__ = ["EXAMPLE", "run"]

EXAMPLE = """Example:
  bristle run experiment.toml --out results"""


def run(
    context: typer.Context,
    experiment: Annotated[Path, typer.Argument(metavar="EXPERIMENT.toml", help="An experiment file.")],
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    figure: FigureFiles = None,
    allow_code: AllowCode = False,
    size_limit: SizeLimit = None,
    force: Force = False,
    log: Annotated[bool, typer.Option("--log", help="Write what the drive would record of each variant into DIR, as CSV.")] = False,
    as_json: Json = False,
) -> int:
    """Simulate an experiment.

    With [compare] in the file, several variants of the loop side by side. A loop that is unstable is named before it
    is simulated, and one that would diverge is not simulated at all. The exit code is 1 if a loop diverges.

    With [effort] in place of [controller] and [reference] an open loop: the effort is given. There a tolerance in
    [run] takes the place of substeps, and the steps are as long as it allows.

    Writes summary.json and report.html into DIR, and with --log log.csv: reference, encoder and commanded effort.
    """
    from bristle.core import InputError
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.loop import runnable
    from bristle.report.best import closing_sentences
    from bristle.report.figure_files import figure_files
    from bristle.report.loop_tables import variant_table
    from bristle.report.loop_warnings import about_loops, loop_doubts, loop_warnings
    from bristle.report.results import write_logs, write_report
    from bristle.report.summary import simulation_summary
    from bristle.simulation import simulate
    from bristle.simulation.compensation import on_another_rig
    from bristle.testing import admit_friction_of

    if log and not out:
        raise InputError("needs a folder to write into", path="--log", mend="Add --out DIR")
    further, code = own_figures(figure, "run", has_folder=out is not None)
    with (
        results_folder(out, force=force, reads=[experiment]) if out else nullcontext() as folder,
        progress("simulating") as report,
        figure_files(folder, formats, data),
    ):
        described = experiment_in(experiment, allow_code=allow_code, size_limit=bytes_asked(size_limit), progress=report)
        admit_friction_of(described)
        stable, judged = runnable(described)
        about = about_loops(judged, on_another_rig(described))
        warnings = loop_warnings(about)
        for warning in warnings:
            complain(warning)
        result = replace(simulate(stable, report), refused=_refused(judged))
        source = provenance(context.obj, **described.origins, figure=code)
        files = write_logs(folder, result) if folder and log else {}
        summary = simulation_summary(result, files=files, provenance=source, diagnostics=about)
        if folder:
            from bristle.report.simulation import simulation_report

            page = simulation_report(
                result, command=context.obj, provenance=source, warnings=warnings, doubts=loop_doubts(about), figures=further
            )
            write_report(folder, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    elif result.variants:
        show_table(variant_table(result))
        for sentence in closing_sentences(result):
            say(sentence)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    failed = [name for name, outcome in summary["variants"].items() if not outcome["completed"]]
    for name in (name for name in failed if name not in result.refused):
        complain(f"{name}: {summary['variants'][name]['status']}")
    return NO if failed else 0


def _refused(judged: Mapping[str, Assessment]) -> dict[str, str]:
    """Return the loops that would diverge, and why."""
    from bristle.loop import Verdict, verdict_of
    from bristle.report.messages import message

    return {name: message(verdict_of(judgement)) for name, judgement in judged.items() if judgement.verdict is Verdict.DIVERGES}
