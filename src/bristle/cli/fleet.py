"""``bristle identify --each``: every log by itself, a row each, into a store that is gone on with and may grow."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.cli.failure import NO
from bristle.cli.lost import tell_lost
from bristle.cli.terminal import complain, progress, say, show_table

if TYPE_CHECKING:
    from bristle.fleet.identify import FleetStore
    from bristle.fleet.plan import Fleet

__all__ = ["identify_each", "refuse_mixed"]


def refuse_mixed(*, separate: bool, force: bool, figures: bool, workers: bool, dry_run: bool) -> None:
    """Refuse options of one fit for a fleet, and those of a fleet for one fit."""
    from bristle.core import InputError

    if separate and force:
        raise InputError("a fleet is gone on with, never replaced", path="--force", mend="Name another folder")
    if separate and figures:
        raise InputError("a fleet has no figures", path="--format, --data, --figure", mend="Read its rows: br.read_study(DIR)")
    if not separate and (workers or dry_run):
        raise InputError("is for many logs, each by itself", path="--workers" if workers else "--dry-run", mend="Add --each")


def identify_each(
    logs: Sequence[Path],
    axes: Sequence[Any],
    options: Mapping[str, Any],
    out: Path | None,
    *,
    command: str,
    readers: Sequence[Path],
    limit: int,
    workers: int | None,
    dry_run: bool,
    as_json: bool,
) -> int:
    """Identify each of many logs, or tell what that costs."""
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.axis import read_axis
    from bristle.files.permission import CODE_LIMIT
    from bristle.fleet.identify import fleet_of

    options = dict(options)
    fleet = fleet_of(
        logs,
        model=options.pop("model"),
        axes=[read_axis(file) for file in axes],
        name=out.name if out else "fleet",
        options=options,
        size_limit=limit,
        readers=[content_of(file, limit=CODE_LIMIT) for file in readers],
    )
    if dry_run:
        _tell_cost(fleet, workers, as_json)
        return 0
    if out is None:
        raise InputError("needs a folder to write into", path="bristle identify --each", mend="Add --out DIR, or --dry-run")
    return _run(fleet, axes, out, command, workers, as_json)


def _tell_cost(fleet: Fleet, workers: int | None, as_json: bool) -> None:
    from bristle.core.cores import core_count
    from bristle.files.summary import as_json as json_text
    from bristle.fleet.identify import Identifier
    from bristle.study.run import in_words

    identifier = Identifier(fleet)
    with progress("measuring"):
        identifier.columns(fleet.blocks[0])  # which compiles
        begin = time.perf_counter()
        row = identifier.columns(fleet.blocks[min(1, fleet.count - 1)])
        seconds = time.perf_counter() - begin
    count = min(workers or core_count(), fleet.count)
    dated = sum(log.time is not None for log in fleet.logs)
    numbers = {
        "logs": fleet.count,
        "with_time": dated,
        "model": fleet.model.name,
        "kind": fleet.kind,
        "columns": list(fleet.parameters),
        "measured_on": row["log"][0],
        "status": row["status"][0],
        "seconds_per_log": seconds,
        "workers": count,
        "seconds": fleet.count * seconds / count,
    }
    if as_json:
        sys.stdout.write(json_text(numbers))
        return
    say(
        f"{fleet.count} logs, {dated} of which say when they were recorded; {fleet.model.name} is fitted to each. One "
        f"takes {in_words(seconds)} ({row['log'][0]}: {row['status'][0]}); all of them about "
        f"{in_words(numbers['seconds'])} with {count} {'worker' if count == 1 else 'workers'}."
    )


def _run(fleet: Fleet, axes: Sequence[Any], out: Path, command: str, workers: int | None, as_json: bool) -> int:
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.fleet.identify import FleetStore, Identifier
    from bristle.report.fleet import failed_logs_table, fleet_sentences, parameters_table
    from bristle.study.dataset import OK
    from bristle.study.run import run_within
    from bristle.study.store import opened

    source = provenance(command, axis=axes, reader=fleet.readers)
    with opened(out, fleet, source, FleetStore) as store, progress("beginning") as report:
        try:
            ran = run_within(store, workers=workers, progress=report, simulator=Identifier)
        except KeyboardInterrupt:
            complain(f"{out} keeps the logs that are done; the same command goes on")
            raise
        report(1.0, "writing the report")
        summary = _write(store, command)
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        show_table(parameters_table(summary))
        if (failed := failed_logs_table(summary)) is not None:
            show_table(failed)
        for sentence in fleet_sentences(summary):
            say(sentence)
    tell_lost(ran)
    complain(f"wrote {out}; open {out / 'report.html'} in a browser")
    return 0 if ran.is_whole and OK in summary["statuses"] else NO


def _write(store: FleetStore, command: str) -> dict[str, Any]:
    from bristle.files.results import SUMMARY
    from bristle.files.summary import as_json as json_text
    from bristle.report.fleet import fleet_report, fleet_summary
    from bristle.report.results import REPORT
    from bristle.study.dataset import runs_in

    runs = runs_in(store.folder)
    summary = fleet_summary(runs, provenance=runs.described["provenance"])
    store.grown.write(SUMMARY, json_text(summary))
    store.grown.write(REPORT, fleet_report(runs, summary, command=command))
    return summary
