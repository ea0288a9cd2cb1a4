"""``bristle paper``: the source paper, figure by figure, or its compensation with other frictions."""

from pathlib import Path
from typing import Annotated

import typer

from bristle.cli.options import (
    AllowCode,
    Force,
    Formats,
    Json,
    Output,
    dir_option,
    print_json,
    refuse,
)
from bristle.cli.terminal import complain, show

EXAMPLE = """Example:
  bristle paper --out paper-results
  bristle paper --figure 8 --format pdf --format csv
  bristle paper --write experiments
  bristle paper --robust gms bouc_wen --seeds 4 --out robust"""
Robust = Annotated[
    bool,
    typer.Option(
        "--robust",
        help="Instead of the figures, test the compensation with several frictions and conditions.",
    ),
]
Seeds = Annotated[
    int | None,
    typer.Option(
        metavar="COUNT",
        min=1,
        max=1000,
        help="With --robust: number of runs of each loop; by default 20.",
    ),
]


def paper(
    context: typer.Context,
    truths: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FRICTION...]",
            help="With --robust: test only these frictions (names or model files).",
        ),
    ] = None,
    *,
    figure: Annotated[
        list[int] | None,
        typer.Option("--figure", metavar="N", help="Reproduce only this figure; repeatable."),
    ] = None,
    write: Annotated[
        Path | None, dir_option("--write", "Copy the experiments to DIR and exit.")
    ] = None,
    source: Annotated[
        Path | None,
        dir_option("--from", "Read the experiments from DIR, for example changed copies."),
    ] = None,
    out: Annotated[
        Path | None,
        dir_option(
            "--out",
            "Write the results to DIR; by default bristle-paper, with --robust bristle-robust.",
        ),
    ] = None,
    formats: Formats = None,
    robust: Robust = False,
    seeds: Seeds = None,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Reproduce the source paper, figure by figure.

    Each figure is an experiment on a simulated rig. One report compares every result with the statement of the paper,
    explains the differences, and lists the errors of the paper with corrections. --format writes each figure as a file
    for publication, with its caption in captions.txt, or its numbers as csv.

    --robust runs the loops of the paper with six kinds of friction and with compensators of several families. bristle
    identifies each compensator from a simulated log of the same friction. In the loops, the friction is 0.7 to 1.6
    times as strong as in this log.
    """
    usual = Path("bristle-paper")  # results in the default folder are disposable
    if robust:
        usual = Path("bristle-robust")
    output = Output(context, out or usual, formats, force or out in (None, usual), as_json)
    if robust:
        refuse(
            {"--figure": figure, "--write": write, "--from": source}, "has no effect with --robust"
        )
        _try_robustness(output, truths or [], seeds or 20, allow_code=allow_code)
        return
    refuse({"FRICTION": truths, "--seeds": seeds}, "has no effect without --robust")
    if write is not None:
        from bristle.apps.paper import write_experiments

        written = write_experiments(write, force=force)
        if as_json:
            print_json({"written": [str(path) for path in written]})
            return
        show(*map(str, written))
        complain(f"change these experiments, and run them with: bristle paper --from {write}")
        return
    from bristle.apps.paper import EXPERIMENTS, FIGURES, paper_report, paper_summary, reproduce
    from bristle.apps.paper.page import claim_table
    from bristle.files import provenance
    from bristle.report.results import write_report

    with output.opened("the paper") as (folder, report):
        results = reproduce(
            figure or FIGURES, folder=source or EXPERIMENTS, allow_code=allow_code, progress=report
        )
        sources = {
            Path(path.name).stem: [path]
            for result in results
            for path in (result.origin, *result.beside)
        }
        made_from = provenance(output.command, **sources)
        summary = paper_summary(results, provenance=made_from)
        report(1.0, "writing the report")
        write_report(
            folder, paper_report(results, command=output.command, provenance=made_from), summary
        )

    sentences = []
    if figure:
        sentences = [sentence for result in results for sentence in result.found]
    output.tell(summary, claim_table(results), *sentences)


def _try_robustness(output: Output, names: list[str], seeds: int, *, allow_code: bool) -> None:
    """Test the compensation, write the report, and show its first tables."""
    from bristle.apps.paper.robust.findings import best_table, claim_table
    from bristle.apps.paper.robust.page import robust_report, robust_summary, words_of
    from bristle.apps.paper.robust.trial import Plan, run_trial
    from bristle.apps.paper.robust.truths import truths_named
    from bristle.contract import admit
    from bristle.files import provenance
    from bristle.report.results import write_report

    # Names may be separated by commas, and a file name may contain a comma.
    separated = [
        name for text in names for name in ([text] if Path(text).is_file() else text.split(","))
    ]
    truths = truths_named(separated, allow_code=allow_code)
    for truth in truths:
        admit(truth.friction.component.inner)
    with output.opened("the trial") as (folder, report):
        trial = run_trial(Plan(tuple(truths), seeds), report)
        report(1.0, "writing the report")
        made_from = provenance(output.command, **{truth.name: [truth.origin] for truth in truths})
        summary = robust_summary(trial, provenance=made_from)
        write_report(
            folder, robust_report(trial, command=output.command, provenance=made_from), summary
        )

    output.tell(summary, claim_table(trial), best_table(trial), *words_of(trial))
