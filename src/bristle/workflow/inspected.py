"""`inspect_log`: what is in a log, with the axis file that it speaks of where none describes it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Content, Readable
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.files.proposal import Proposal, propose_axis
from bristle.logs.readers import read_table
from bristle.logs.summary import Summary, summary_of, summary_of_columns
from bristle.logs.tables import content_of_log

if TYPE_CHECKING:
    from bristle.files.results import Results
    from bristle.logs.log import Log
    from bristle.logs.passages import Passage
    from bristle.logs.table import Table

__all__ = ["Inspected", "inspect_log"]


class Inspected(NamedTuple):
    """What is in a log."""

    summary: dict[str, Any]
    content: Content
    table: Table
    axis: Axis | None
    proposal: Proposal | None
    log: Log | None
    passages: tuple[Passage, ...]

    def write(self, folder: Results, command: str) -> None:
        """Write the numbers, and the report of a log that can be used, into a folder of results."""
        from bristle.files.results import SUMMARY
        from bristle.files.summary import as_json
        from bristle.report.log import log_report
        from bristle.report.results import write_report

        if self.log is None:
            folder.write(SUMMARY, as_json(self.summary))
            return
        page = log_report(
            self.log,
            self.passages,
            name=self.axis.name if self.axis else Path(self.summary["file"]).stem,
            command=command,
            provenance=self.summary["provenance"],
            diagnostics=self.summary["diagnostics"],
        )
        write_report(folder, page, self.summary)


def inspect_log(log: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT) -> Inspected:
    """Return what is in a log."""
    content = content_of_log(log, limit=size_limit)
    proposal = _proposal(content, size_limit) if axis is None else None
    used = proposal.axis if proposal else axis
    table = proposal.table if proposal else read_table(content, used and used.table, size_limit=size_limit)
    looked_at = _looked_at(table, used, proposal.unknown if proposal else ())
    summary = _with_messages(looked_at.data)
    summary["proposal"] = {"text": None, "missing": []}
    if proposal is not None:
        summary["proposal"] = {"text": proposal.text, "missing": list(proposal.missing)}
        summary["notes"] = [*proposal.notes, *summary["notes"]]
        if {"columns.position.unit", "columns.velocity.unit"} & set(proposal.missing):
            # Of a size that nobody knows nothing can be said.
            summary["diagnostics"] = [entry for entry in summary["diagnostics"] if entry["code"] != "unit_suspect"]
    return Inspected(summary, content, table, used, proposal, looked_at.log, looked_at.passages)


def _looked_at(table: Table, axis: Axis | None, unknown: Collection[str]) -> Summary:
    """Return what is in a table; of channels in a unit that is not known nothing is said in SI."""
    if axis is None or not unknown:
        return summary_of(table, axis)
    usable = {name: column for name, column in axis.columns.items() if name not in unknown}
    if "time" in unknown or "position" in unknown or not {"position", "velocity"} & set(usable):
        return summary_of_columns(table)
    return summary_of(table, replace(axis, columns=usable))


def _proposal(content: Content, limit: int) -> Proposal | None:
    """Return the axis file that a log speaks of; None where no column can be the position."""
    try:
        return propose_axis(content, size_limit=limit)
    except InputError:
        return None


def _with_messages(summary: dict[str, Any]) -> dict[str, Any]:
    """Return what is in a log with a sentence for each diagnostic."""
    from bristle.report.messages import as_data

    diagnostics = [Diagnostic(**entry, kind=summary["kind"]) for entry in summary["diagnostics"]]
    return summary | {"diagnostics": as_data(diagnostics)}
