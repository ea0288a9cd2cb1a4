"""What each log contradicts before anything is fitted: what ``bristle log`` says."""

from __future__ import annotations

from bristle.core.errors import InputError
from bristle.report.log import passage_table
from bristle.server.tasks.errand import Answer, Errand
from bristle.workflow.inspected import inspect_log

__all__ = ["check"]


def check(errand: Errand) -> Answer:
    """Return rates, experiments, diagnostics and problems of every log."""
    axis, logs = errand.axis(), []
    for place, log in enumerate(errand.logs):
        errand.report(place / len(errand.logs), f"reading {log.label}")
        try:
            summary = inspect_log(log.content, axis, size_limit=errand.size_limit).summary
        except InputError as error:
            logs.append({"label": log.label, "role": log.role, "problems": [str(error)]})
            continue
        chosen = ("rate", "duration", "kind", "channels", "notes", "diagnostics", "problems")
        passages = passage_table(summary["passages"], summary["kind"]) if summary["passages"] else None
        facts = {name: summary[name] for name in chosen}
        logs.append({"label": log.label, "role": log.role, **facts, "passages": passages and passages._asdict()})
    problems = sum(len(log["problems"]) for log in logs)
    warnings = sum(entry["severity"] != "info" for log in logs for entry in log.get("diagnostics", ()))
    return {"problems": problems, "warnings": warnings, "ready": not problems}, {"logs": logs}
