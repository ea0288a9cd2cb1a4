"""The report of a log: what is in it, which experiments it contains, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.report.fronts.log import log_front
from bristle.report.log_facts import log_facts
from bristle.report.page import render
from bristle.report.passages import passage_table
from bristle.report.pictures import pictures_on

if TYPE_CHECKING:
    from bristle.logs.log import Log
    from bristle.logs.passages import Passage

__all__ = ["log_report"]


def log_report(
    log: Log,
    segments: Sequence[Passage],
    *,
    name: str,
    command: str,
    provenance: Mapping[str, str],
    diagnostics: Sequence[Mapping[str, Any]] = (),
) -> str:
    """Return the report of a log as one HTML page."""
    (figure,) = pictures_on("log", {"log": log, "passages": segments})["front"]
    return render(
        "log.html",
        provenance=provenance,
        command=command,
        banner=None,
        name=name,
        front=log_front(log, segments, diagnostics, name, figure),
        facts=log_facts(log),
        notes=log.notes,
        found=[diagnostic["message"] for diagnostic in diagnostics],
        passages=passage_table([segment.as_data() for segment in segments], log.kind),
    )
