"""The certificates of a model as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.typography import with_unit
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.certificates import Certificate

__all__ = ["certificate_table"]

VERDICTS = {True: "passed", False: "FAILED", None: "does not apply"}


def certificate_table(name: str, found: Mapping[str, Certificate]) -> Table:
    """Return whether a model is fit to be used, question by question, and what would make it so."""
    rows = [
        (key, VERDICTS[one.passed], _told(one.value, one.unit), _told(one.threshold, one.unit), one.advice)
        for key, one in found.items()
    ]
    heads = ("Certificate", "Verdict", "Found", "Limit", "What it means, what to do")
    return Table(f"Is it fit to be used: {name}", heads, rows)


def _told(value: float | None, unit: str) -> str:
    return "" if value is None else with_unit(value, unit)
