"""``bristle paper``: the source paper, figure by figure."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from bristle.cli.options import AllowCode, AxisFile, Data, Force, Formats, Json, folder_named
from bristle.cli.terminal import complain, progress, say, show_table

__all__ = ["EXAMPLE", "paper"]

EXAMPLE = """Example:
  bristle paper --out paper-results
  bristle paper --figure 8 --format pdf --format svg --data csv
  bristle paper --write experiments
  bristle paper --robust --seeds 4 --truth gms bouc_wen --out robust"""
USUAL_PLACE = Path("bristle-paper")
Robust = Annotated[bool, typer.Option("--robust", help="Try the compensation on other frictions and changed conditions instead.")]
Truths = Annotated[
    list[str] | None,
    typer.Option(
        "--truth",
        metavar="NAME|FILE",
        help="With --robust: only these frictions, one after another: names, model files, logs of a contact.",
    ),
]
Seeds = Annotated[int | None, typer.Option(metavar="COUNT", min=1, max=1000, help="With --robust: runs of each loop; 20 by default.")]


def paper(
    context: typer.Context,
    truths: Annotated[list[str] | None, typer.Argument(metavar="TRUTH", hidden=True, help="More of --truth.")] = None,
    *,
    figure: Annotated[list[int] | None, typer.Option("--figure", metavar="N", help="Only this figure; may be given several times.")] = None,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="DIR", parser=folder_named, help="Copy the experiments into DIR, and stop.")
    ] = None,
    source: Annotated[
        Path | None, typer.Option("--from", metavar="DIR", parser=folder_named, help="Take the experiments from DIR, as changed.")
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the results into this folder.")
    ] = USUAL_PLACE,
    formats: Formats = None,
    data: Data = None,
    robust: Robust = False,
    truth: Truths = None,
    seeds: Seeds = None,
    axis: AxisFile = None,
    allow_code: AllowCode = False,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Rebuild the source paper, figure by figure.

    Each figure is an experiment on a simulated rig, shown in one report beside what the paper says of it, with what was
    found and why it differs; and all that is wrong in the paper, corrected. To be published, --format writes each
    figure as a file, with captions.tex and errata.tex for LaTeX, and --data the numbers that it draws.

    With --robust the loops of the paper run with frictions of other kinds, from 0.7 to 1.6 times as strong, with
    compensators of several families, each identified from a log of that friction. Interrupted (Ctrl-C), it keeps the
    runs that are done in DIR (bristle-robust by default), and the same command goes on. --axis is for logs.
    """
    truths = _named(truth, truths)
    if robust:
        _refuse({"--figure": figure, "--write": write, "--from": source, "--force": force}, "beside --robust")
        from bristle.cli.robust import Request, try_robustness

        request = Request(truths, seeds, axis, None if _is_usual(context) else out, allow_code)
        try_robustness(context.obj, request, (formats, data), as_json=as_json)
        return
    _refuse({"--truth": truth, "--seeds": seeds, "--axis": axis}, "without --robust")
    if write is not None:
        _write(write, force, as_json)
        return
    from bristle.files.results import results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.paper import EXPERIMENTS, FIGURES, paper_report, paper_summary, reproduce
    from bristle.paper.errata import ERRATA_FILE, errata_tex
    from bristle.paper.page import claim_table
    from bristle.report.figure_files import figure_files
    from bristle.report.results import write_report

    # What is not asked for is replaced where nobody keeps it.
    with (
        results_folder(out, force=force or out == USUAL_PLACE) as folder,
        progress("the paper") as report,
        figure_files(folder, formats, data),
    ):
        results = reproduce(figure or FIGURES, folder=source or EXPERIMENTS, allow_code=allow_code, progress=report)
        sources = {Path(path.name).stem: [path] for result in results for path in (result.origin, *result.beside)}
        made_from = provenance(context.obj, **sources)
        summary = paper_summary(results, provenance=made_from)
        report(1.0, "writing the report")
        write_report(folder, paper_report(results, command=context.obj, provenance=made_from), summary)
        if formats:
            folder.write(ERRATA_FILE, errata_tex())
    if as_json:
        sys.stdout.write(json_text(summary))
        return
    show_table(claim_table(results))
    if figure:
        for sentence in [sentence for result in results for sentence in result.found]:
            say(sentence)
    complain(f"wrote {out}; open {out / 'report.html'} in a browser")


def _named(truth: list[str] | None, more: list[str] | None) -> list[str]:
    """Return the frictions that are named, behind the option or after that."""
    if more and not truth:
        raise typer.BadParameter(f"{more[0]} is no option: frictions are named behind --truth", param_hint="TRUTH")
    return [*(truth or []), *(more or [])]


def _is_usual(context: typer.Context) -> bool:
    """Return whether nobody named a folder."""
    origin = context.get_parameter_source("out")
    return origin is not None and origin.name == "DEFAULT"


def _refuse(options: Mapping[str, Any], place: str) -> None:
    """Refuse options that say nothing there."""
    from bristle.core import InputError

    for name, value in options.items():
        if value:
            raise InputError(f"says nothing {place}", path=name, mend=f"Leave {name} out")


def _write(folder: Path, force: bool, as_json: bool) -> None:
    from bristle.files.summary import as_json as json_text
    from bristle.paper import write_experiments

    written = write_experiments(folder, force=force)
    if as_json:
        sys.stdout.write(json_text({"written": [str(path) for path in written]}))
        return
    for path in written:
        say(str(path))
    complain(f"change them, and run them with: bristle paper --from {folder}")
