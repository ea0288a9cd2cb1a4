"""Inspect a log with or without an axis file: its columns, its channels and a proposed axis file."""

from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Self

from bristle.core import SIZE_LIMIT, Axis, Content, InputError, Readable
from bristle.files.proposal import Proposal, propose_axis
from bristle.logs import Log, Passage
from bristle.logs.readers import read_table, with_known
from bristle.logs.summary import Summary, summary_of, summary_of_columns
from bristle.logs.table import Table
from bristle.logs.tables import content_of_log


@dataclass(frozen=True)
class Inspection:
    """Content of a log: plain data, columns, and the log with its passages if the axis is known."""

    summary: dict[str, Any]
    content: Content
    table: Table
    axis: Axis | None
    proposal: Proposal | None
    log: Log | None
    passages: tuple[Passage, ...]

    @classmethod
    def of(cls, log: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT) -> Self:
        """Inspect a log; without an axis, also propose an axis file from its columns."""
        content, proposal = content_of_log(log, limit=size_limit), None
        if axis is None:
            with suppress(InputError):  # a column for the position is missing
                proposal = propose_axis(content, size_limit=size_limit)
        axis = proposal.axis if proposal else axis
        table = (
            proposal.table
            if proposal
            else with_known(
                read_table(content, axis and axis.table, size_limit=size_limit),
                axis,
                size_limit=size_limit,
            )
        )
        if proposal is not None and proposal.joints > 1:
            summary = summary_of_columns(table)
        else:
            summary = _looked_at(table, axis, proposal.unknown if proposal else ())
        return cls(summary.data, content, table, axis, proposal, summary.log, summary.passages)


def _looked_at(table: Table, axis: Axis | None, unknown: Collection[str]) -> Summary:
    """Summarize a table; channels in an unknown unit have no values in SI units."""
    if axis is None or not unknown:
        return summary_of(table, axis)
    usable = {name: column for name, column in axis.columns.items() if name not in unknown}
    if "time" in unknown or "position" in unknown or not {"position", "velocity"} & set(usable):
        return summary_of_columns(table)
    return summary_of(table, replace(axis, columns=usable))
