"""Models identified from the logs: the work, the results and the report of ``bristle identify``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.friction import DEFAULT_MODELS
from bristle.server.tasks.errand import Answer, Errand, command, zipped
from bristle.server.tasks.thinned import thinned

if TYPE_CHECKING:
    from bristle.report.table import Table
    from bristle.workflow import Identified, Outcome

__all__ = ["ARCHIVE", "RESULTS", "identify"]

RESULTS, ARCHIVE = "results", "results.zip"
DRAWS = 100


def identify(errand: Errand) -> Answer:
    """Return the verdict of an identification, and leave its results."""
    import bristle
    from bristle.files.results import results_folder

    axis, axis_file = errand.axis(), errand.axis_file
    logs = [bristle.read_log(log.content, axis, size_limit=errand.size_limit) for log in errand.fitted]
    models, options = _options(errand)
    with errand.interruptible():
        identified = bristle.identify(logs, models, axis=[axis] * len(logs), progress=errand.report, **options)
    outcome = identified.outcome_with(command=_command(errand), axis_name=axis.name, progress=errand.report, files={"axis": [axis_file]})
    with results_folder(errand.folder / RESULTS) as folder:
        outcome.write(folder)
    zipped(errand.folder / RESULTS, errand.folder / ARCHIVE)
    verdict = outcome.summary["verdict"]
    facts = {"level": verdict["level"], "model": identified.best.name, "unfinished": identified.unfinished}
    return facts, _findings(identified, outcome)


def _options(errand: Errand) -> tuple[list[str], dict[str, Any]]:
    models = [name.strip() for name in errand.text("models", DEFAULT_MODELS).split(",")]
    return models, {"draws": errand.count("draws", DRAWS), "cutoff": errand.text("cutoff") or None}


def _command(errand: Errand) -> str:
    """Return the command line that gives the same."""
    words = ["identify", *(log.label for log in errand.fitted), "--axis", errand.axis_label]
    models, options = _options(errand)
    words += ["--model", ",".join(models)]
    words += ["--draws", str(options["draws"])] if options["draws"] != DRAWS else []
    words += ["--cutoff", options["cutoff"]] if options["cutoff"] else []
    return command(*words, "--out", RESULTS)


def _findings(identified: Identified, outcome: Outcome) -> dict[str, Any]:
    """Return what the page shows: the verdict, the models, what to type in."""
    from bristle.report.identification import answers
    from bristle.report.judgement import judged
    from bristle.report.messages import warnings_of
    from bristle.report.model_tables import comparison_table, drive_rows, parameter_table

    best, kind = identified.best, identified.best.plant.kind
    judgement = judged(best, identified.settings, outcome.following)
    front = answers(identified, outcome.simulation, outcome.following, outcome.axis, usable=judgement.level != "measure_again")
    traces = best.traces
    return {
        "verdict": judgement.as_data(),
        "answers": front,
        "command": outcome.command,
        "kind": kind,
        "unfinished": identified.unfinished,
        "parameters": _table(parameter_table(best, outcome.axis)),
        "comparison": _table(comparison_table(identified)) if len(identified.fits) > 1 else None,
        "warnings": warnings_of(best),
        "notes": identified.notes,
        "drive": _table(drive_rows(outcome.table, kind, outcome.axis)) if outcome.table else None,
        "time": thinned(traces.time, traces.measured, traces.predicted),
        "velocity": thinned(traces.velocity, traces.friction, traces.friction - traces.residual),
    }


def _table(table: Table) -> dict[str, Any]:
    trimmed = table.without_empty_columns()
    numbers = [trimmed.is_number(column) for column in range(len(trimmed.heads))]
    return trimmed._asdict() | {"numbers": numbers}
