"""``bristle study``: thousands of runs of an experiment with drawn values; an interrupted study continues."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import (
    AllowCode,
    FigureFiles,
    Formats,
    Json,
    Output,
    OwnFigures,
    command_text,
    dir_option,
    own_figures,
    refuse,
    size_limit,
)
from bristle.cli.terminal import NO, complain, progress

if TYPE_CHECKING:
    from bristle.apps.study import Study
    from bristle.apps.study.run import Ran

EXAMPLE = """Example:
  bristle study study.toml --out tolerances
  bristle study study.toml --out tolerances --scheduler tcp://big-machine:8786
  bristle study study.toml --run 4711 --out run_4711"""


def study(
    context: typer.Context,
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="A study file.")],
    *,
    out: Annotated[
        Path | None,
        dir_option(
            "--out", "Write the results to this new folder, or continue the study that it contains."
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="COUNT", min=1, max=1024, help="Number of processes; by default one per core."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="tcp://HOST:PORT",
            help="Simulate on a Dask cluster; bristle writes the results on this machine.",
        ),
    ] = None,
    run: Annotated[
        int | None,
        typer.Option(metavar="NUMBER", min=0, help="Repeat only this run, and record its signals."),
    ] = None,
    formats: Formats = None,
    figure: FigureFiles = None,
    allow_code: AllowCode = False,
    as_json: Json = False,
) -> int:
    """Run an experiment thousands of times with varied values.

    The study file defines how the values vary: by distributions, by joint draws of an identification, or on a grid. The
    number of a run determines its values and its seed. Therefore the results do not depend on the number of workers.

    To continue after an interruption, give the same command again: bristle simulates only the missing runs. The exit
    code is 1 if runs are missing, or if no run succeeded.

    Writes runs/*.parquet, study.json, summary.json and report.html into DIR. With --run, writes report.html and the log
    of the repeated run into a new folder.
    """
    from bristle.apps.study import read_study_file
    from bristle.apps.study.workers import WANTED_BY
    from bristle.contract import admit_friction_of
    from bristle.core import library

    if scheduler is not None:
        library("distributed", *WANTED_BY)
        of_this_machine = {"--workers": workers is not None, "--run": run is not None}
        option = next((option for option, is_chosen in of_this_machine.items() if is_chosen), "")
        refuse(
            of_this_machine,
            "simulates on this machine, --scheduler on a cluster",
            f"Leave {option} or --scheduler out",
        )
    page = "study"
    if run is not None:
        page = "run"
    own = own_figures(figure, page, has_folder=out is not None)
    described = read_study_file(study, allow_code=allow_code, size_limit=size_limit())
    admit_friction_of(described.experiment)
    output = Output(context, out, formats, as_json=as_json)
    if run is not None:
        return _repeat(described, run, output, own)
    refuse({"bristle study": out is None}, "needs a folder to write into", "Add --out DIR")
    return _run(described, study, output, workers, scheduler, own)


def _repeat(study: Study, number: int, output: Output, own: OwnFigures) -> int:
    """Repeat one run of a study and report it like ``bristle run``, with its drawn values."""
    from bristle.apps.study.plan import seed_of_run
    from bristle.apps.study.run import repeat_run, values_of
    from bristle.files import provenance
    from bristle.report.loops import variant_table
    from bristle.report.results import write_logs, write_report
    from bristle.report.simulation import promised_in, simulation_report, simulation_summary

    with output.opened(f"run {number}") as (folder, _):
        result = repeat_run(study, number)
        source = provenance(output.command, **study.origins, figure=own.origins)
        files = {}
        if folder:
            files = write_logs(folder, result)
        values = values_of(study, number)
        drawn = {
            "run": number,
            "seed": seed_of_run(study.seed, number),
            "values": values,
            "units": study.units,
        }
        facts = {"provenance": source, "claims": promised_in(result)}
        summary = simulation_summary(result, files=files, **facts) | drawn
        if folder:
            page = simulation_report(result, command=output.command, figures=own.figures, **facts)
            write_report(folder, page, summary)

    output.tell(summary, f"Run {number}: {_in_words(values, study.units)}.", variant_table(result))
    if not all(variant["completed"] for variant in summary["variants"].values()):
        return NO
    return 0


def _in_words(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    from bristle.core import with_unit

    cells = []
    for path, value in values.items():
        text = str(value)
        if isinstance(value, float):
            text = with_unit(value, units[path] or "1", 4)
        elif isinstance(value, list):
            text = f"{len(value)} numbers"
        cells.append(f"{path} = {text}")
    return ", ".join(cells) or "only the seed varies"


def _run(
    study: Study,
    file: Path,
    output: Output,
    workers: int | None,
    scheduler: str | None,
    own: OwnFigures,
) -> int:
    from bristle.apps.study.report import (
        WORST_SHOWN,
        spread_tables,
        study_report,
        study_sentences,
        study_summary,
    )
    from bristle.apps.study.run import run_within, worst_runs
    from bristle.apps.study.store import opened, runs_in
    from bristle.files import provenance
    from bristle.report.results import figure_files, write_report

    assert output.out is not None
    command = command_text(["study", str(file), "--out", str(output.out)])
    with (
        opened(output.out, study, provenance(command, **study.origins)) as store,
        progress("beginning") as report,
    ):
        with interruptible(output.out, "runs"):
            ran = run_within(store, workers=workers, scheduler=scheduler, progress=report)
        report(1.0, "writing the report")
        for name in store.grown.names:
            if name.startswith("figures/"):
                store.grown.remove(name)  # figures of an earlier report with other numbers
        with figure_files(store.grown, output.formats):
            runs = runs_in(store.folder)
            repeat = command_text(["study", str(file)])
            figures = {
                key: text
                for key, text in provenance(command, figure=own.origins).items()
                if key.startswith("figure")
            }
            source = runs.described["provenance"] | figures
            summary = study_summary(
                runs, command=repeat, provenance=source, worst=worst_runs(runs, WORST_SHOWN)
            )
            write_report(
                store.grown,
                study_report(runs, summary, command=command, figures=own.figures),
                summary,
            )

    output.tell(summary, *spread_tables(summary), *study_sentences(summary))
    return exit_code(ran, summary)


@contextmanager
def interruptible(folder: Path, parts: str) -> Iterator[None]:
    """Report on an interruption that the finished parts are kept."""
    try:
        yield
    except KeyboardInterrupt:
        complain(f"{folder} keeps the finished {parts}. Give the same command again to continue")
        raise


def exit_code(ran: Ran, summary: Mapping[str, Any]) -> int:
    """Return the exit code of a study or a fleet. Report runs whose processes crashed."""
    from bristle.apps.study.store import OK

    for block in ran.lost:
        complain(
            f"runs {block.first} to {block.last - 1} are missing: every process that simulated them crashed. "
            "Check the free memory, then give the same command again"
        )
    if ran.is_whole and OK in summary["statuses"]:
        return 0
    return NO
