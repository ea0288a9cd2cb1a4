"""The report of a log: what is in it, which experiments it contains, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bristle.report.log_facts import log_facts
from bristle.report.page import picture, render
from bristle.report.passages import passage_table

if TYPE_CHECKING:
    from bristle.logs.log import Log
    from bristle.logs.passage import Passage

__all__ = ["PASSAGES_CAPTION", "log_report"]

PASSAGES_CAPTION = (
    "Position over time, and effort over position of its loops",
    "Shaded: what kind of experiment each part of the log is. Below, effort over position where friction turns slowly: "
    "loops that lie inside one another tell models of friction apart; loops of one amplitude do not.",
)


def log_report(
    log: Log, segments: Sequence[Passage], *, name: str, command: str, provenance: Mapping[str, str],
    found: Sequence[str] = (),
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
    found : sequence of str
        What the log contradicts, and what it cannot tell, in sentences.
    """
    from bristle import figures

    return render(
        "log.html", provenance=provenance, command=command, banner=None, name=name,
        facts=log_facts(log), notes=log.notes, found=found,
        passages=passage_table([segment.as_data() for segment in segments], log.kind),
        picture=picture("passages", lambda: figures.passages(log, segments), *PASSAGES_CAPTION),
    )  # fmt: skip
