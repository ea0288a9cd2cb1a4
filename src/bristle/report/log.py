"""The report of a log: what is in it, which experiments it contains, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.report.fronts.log import log_front
from bristle.report.log_facts import log_facts
from bristle.report.page import Picture, picture, render
from bristle.report.passages import passage_table

if TYPE_CHECKING:
    from bristle.logs.log import Log
    from bristle.logs.passage import Passage

__all__ = ["log_report", "passages_picture"]

SHADED = "Shaded: what kind of experiment each part of the log is."
LOOPS = (
    "Below, effort over position where friction turns slowly: loops that lie inside one another tell models of "
    "friction apart; loops of one amplitude do not."
)


def passages_picture(log: Log, segments: Sequence[Passage]) -> Picture:
    """Return the figure of what a log contains; its caption tells of loops where it has any."""
    from bristle import figures

    has_loops = log.effort is not None and any(segment.kind in ("loops", "break_away") for segment in segments)
    alternative = f"Position over time{', and effort over position of its loops' if has_loops else ''}"
    caption = f"{SHADED} {LOOPS}" if has_loops else SHADED
    return picture("passages", lambda: figures.passages(log, segments), alternative, caption)


def log_report(
    log: Log, segments: Sequence[Passage], *, name: str, command: str, provenance: Mapping[str, str],
    diagnostics: Sequence[Mapping[str, Any]] = (),
) -> str:  # fmt: skip
    """Return the report of a log as one HTML page.

    Parameters
    ----------
    log : Log
        The log.
    segments : sequence of Passage
        What it contains.
    name : str
        What people call the axis or the log.
    command : str
        The command that repeats it.
    provenance : mapping of str to str
        Versions, files, checksums.
    diagnostics : sequence of mapping
        What the log contradicts, and what it cannot tell: ``code``, ``severity`` and ``message`` of each.
    """
    drawn = passages_picture(log, segments)
    return render(
        "log.html", provenance=provenance, command=command, banner=None, name=name,
        front=log_front(log, segments, diagnostics, name, drawn), facts=log_facts(log), notes=log.notes,
        found=[diagnostic["message"] for diagnostic in diagnostics],
        passages=passage_table([segment.as_data() for segment in segments], log.kind),
    )  # fmt: skip
