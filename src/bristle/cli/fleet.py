"""``bristle identify --each``: every log by itself, a row each, into a store that is gone on with and may grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bristle.cli.options import Output, code_in, refuse, size_limit
from bristle.cli.study import exit_code, interruptible
from bristle.cli.terminal import progress, say, show_table


def identify_each(
    logs: Sequence[Path], axes: Sequence[Any], options: Mapping[str, Any], output: Output, *, readers: Sequence[Path], workers: int | None
) -> int:
    """Identify each of many logs."""
    from bristle.files.axis import read_axis
    from bristle.files.summary import provenance
    from bristle.fleet.identify import FleetStore, Identifier, fleet_of
    from bristle.report.fleet import failed_logs_table, fleet_report, fleet_sentences, fleet_summary, parameters_table
    from bristle.report.results import write_report
    from bristle.study.dataset import runs_in
    from bristle.study.run import run_within
    from bristle.study.store import opened

    refuse({"bristle identify --each": output.out is None}, "needs a folder to write into", "Add --out DIR")
    assert output.out is not None
    options = dict(options)
    fleet = fleet_of(
        logs,
        model=options.pop("model"),
        axes=[read_axis(file) for file in axes],
        name=output.out.name,
        options=options,
        size_limit=size_limit(),
        readers=[code_in(file) for file in readers],
    )
    source = provenance(output.command, axis=axes, reader=fleet.readers)
    with opened(output.out, fleet, source, FleetStore) as store, progress("beginning") as report:
        with interruptible(output.out, "logs"):
            ran = run_within(store, workers=workers, progress=report, simulator=Identifier)
        report(1.0, "writing the report")
        runs = runs_in(store.folder)
        summary = fleet_summary(runs, provenance=runs.described["provenance"])
        write_report(store.grown, fleet_report(runs, summary, command=output.command), summary)

    def show() -> None:
        show_table(parameters_table(summary))
        if (failed := failed_logs_table(summary)) is not None:
            show_table(failed)
        for sentence in fleet_sentences(summary):
            say(sentence)

    output.tell(summary, show)
    return exit_code(ran, summary)
