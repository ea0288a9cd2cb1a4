"""``bristle design``: margins, error budget and gains of a loop."""

import math
from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import AllowCode, FigureFiles, Output, experiment_in, own_figures
from bristle.cli.terminal import NO

EXAMPLE = """Example:
  bristle design experiment.toml --out results"""


def design(
    experiment: Annotated[
        Path, typer.Argument(metavar="EXPERIMENT.toml", help="An experiment file.")
    ],
    variant: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Variant to design; by default the first with friction feedforward.",
        ),
    ] = None,
    bandwidth: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY",
            help='Bandwidth of the proposed gains, such as "30 Hz"; by default the largest that keeps the margins.',
        ),
    ] = None,
    *,
    output: Output,
    figure: FigureFiles = None,
    allow_code: AllowCode = False,
) -> int:
    """Compute margins, error budget and gains of a loop.

    Shows the poles and margins of the sampled loop with all its delays, the contribution of each source to the following
    error, and gains that keep the margins. The report also shows the error of a circle driven by two such axes. The exit
    code is 1 if the loop is unstable.
    """
    from bristle.apps.design import design as designed
    from bristle.apps.design.report import (
        budget_table,
        design_report,
        design_sentences,
        design_summary,
        margin_table,
        proposal_table,
    )
    from bristle.contract import admit_friction_of
    from bristle.core import Variable, quantity
    from bristle.files import provenance
    from bristle.report.results import write_report

    further, code = own_figures(figure, "design", has_folder=output.out is not None)
    angular = None
    if bandwidth is not None:
        hertz = Variable("frequency", "bandwidth")
        angular = 2.0 * math.pi * quantity(bandwidth, hertz, path="--bandwidth")
    with output.opened("designing", [experiment]) as (folder, report):
        described = experiment_in(experiment, allow_code=allow_code, progress=report)
        admit_friction_of(described)
        outcome = designed(described, variant=variant, bandwidth=angular, progress=report)
        source = provenance(output.command, **described.origins, figure=code)
        summary = design_summary(outcome, provenance=source)
        if folder:
            write_report(
                folder,
                design_report(outcome, command=output.command, provenance=source, figures=further),
                summary,
            )

    output.tell(
        summary,
        margin_table(outcome),
        budget_table(outcome),
        proposal_table(outcome),
        *design_sentences(outcome),
    )
    if not outcome.is_stable:
        return NO
    return 0
