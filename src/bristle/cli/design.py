"""``bristle design``: what limits a loop, what it errs by, and which gains it allows."""

from __future__ import annotations

import math
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import AllowCode, Data, FigureFiles, Force, Formats, Json, Out, SizeLimit, bytes_asked, own_figures
from bristle.cli.prepared import experiment_in
from bristle.cli.terminal import complain, progress, say, show_table

__all__ = ["EXAMPLE", "design"]

EXAMPLE = """Example:
  bristle design experiment.toml --out results"""


def design(
    context: typer.Context,
    experiment: Annotated[Path, typer.Argument(metavar="EXPERIMENT.toml", help="An experiment file.")],
    variant: Annotated[
        str | None, typer.Option(metavar="NAME", help="The variant to design; by default the first that feeds friction forward.")
    ] = None,
    bandwidth: Annotated[
        str | None, typer.Option(metavar="FREQUENCY", help='Of the gains to propose, such as "30 Hz"; by default the widest.')
    ] = None,
    out: Out = None,
    formats: Formats = None,
    data: Data = None,
    figure: FigureFiles = None,
    allow_code: AllowCode = False,
    size_limit: SizeLimit = None,
    force: Force = False,
    as_json: Json = False,
) -> int:
    """Margins, error budget and gains of a loop.

    Poles and margins of the sampled loop with all its delays, what the loop errs by, gains that keep margins, and the
    circle that two such axes run. The exit code is 1 if the loop is unstable.
    """
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.loop import design as designed
    from bristle.report.design import design_report, design_sentences, design_summary
    from bristle.report.design_tables import budget_table, margin_table, proposal_table
    from bristle.report.figure_files import figure_files
    from bristle.testing import admit_friction_of

    further, code = own_figures(figure, "design", has_folder=out is not None)
    with (
        results_folder(out, force=force, reads=[experiment]) if out else nullcontext() as folder,
        progress("designing") as report,
        figure_files(folder, formats, data),
    ):
        described = experiment_in(experiment, allow_code=allow_code, size_limit=bytes_asked(size_limit), progress=report)
        admit_friction_of(described)
        outcome = designed(described, variant=variant, bandwidth=_in_radians(bandwidth), progress=report)
        source = provenance(context.obj, **described.origins, figure=code)
        summary = design_summary(outcome, provenance=source)
        if folder:
            from bristle.report.results import write_report

            page = design_report(outcome, command=context.obj, provenance=source, figures=further)
            write_report(folder, page, summary)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        show_table(margin_table(outcome))
        if outcome.budget is not None:
            show_table(budget_table(outcome.budget, outcome))
        show_table(proposal_table(outcome))
        for sentence in design_sentences(outcome):
            say(sentence)
    if out:
        complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    return 0 if outcome.is_stable else NO


def _in_radians(text: str | None) -> float | None:
    """Return a frequency that a person typed, as an angular one [rad/s]."""
    if text is None:
        return None
    from bristle.core.units import quantity
    from bristle.core.variable import Variable

    return 2.0 * math.pi * quantity(text, Variable("frequency", "bandwidth"), path="--bandwidth")
