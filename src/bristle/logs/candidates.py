"""The columns of a file as candidates for channels: their numbers, their units, and what their names mean."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bristle.core import units
from bristle.logs.table import Table, axis_in
from bristle.logs.words import Meaning, is_time, meaning_of, unit_in_name

__all__ = ["Candidate", "candidate_of", "time_among"]

FEWEST = 20  # samples
OF_STAMPS = 0.02  # of the steps of a time that rise: fewer are no stamps of samples


@dataclass(frozen=True, eq=False)
class Candidate:
    """A column that may be a channel."""

    name: str
    values: np.ndarray
    unit: str
    told_by: str
    meaning: Meaning
    axis: tuple[str, str] | None = None
    unknown: str = ""

    def is_one_of(self, bases: Iterable[str]) -> bool:
        """Return whether its unit is one of several quantities."""
        return bool(self.unit) and any(units.compatible(self.unit, base) for base in bases)

    def fits(self, role: str, bases: Iterable[str]) -> bool:
        """Return whether the column may play a role: by its unit where it has one, else by its name."""
        if self.unit:
            return self.is_one_of(bases) and self.meaning.role in ("", role, "status")
        return self.meaning.role == role


def candidate_of(table: Table, name: str, is_nameless: bool) -> Candidate | None:
    """Return a column as a candidate; None for times of other columns and for what is too short or no numbers."""
    values = table.columns[name]
    if name in table.stamps.values() or values.size < FEWEST:
        return None
    finite = np.isfinite(values)
    if not finite.any():
        return None
    filled = values if finite.all() else np.where(finite, values, np.median(values[finite]))
    unit, told_by, unknown = table.units.get(name, ""), "header", table.unknown_unit(name)
    if not unit or unknown:
        unit, told_by = unit_in_name(name), "name"
    about = table.about.get(name, "")
    meaning = Meaning() if is_nameless else meaning_of(name, about)
    return Candidate(name, filled, unit, told_by if unit else "", meaning, axis_in(name) or axis_in(about), unknown)


def time_among(table: Table, columns: list[Candidate]) -> tuple[Candidate, str] | None:
    """Return the column of time, and why it is one; None where there is none, or each column brings its own."""
    if table.stamps:
        return None
    rising = [column for column in columns if np.mean(np.diff(column.values) > 0) > 0.5 and _advances(column)]
    called = [column for column in columns if column.meaning.role == "time" and is_time(column.name)]
    called = [column for column in called if column in rising or _halts(column)]
    named = [column for column in called if not column.unit or column.is_one_of(("s",))]
    named += [column for column in rising if column.is_one_of(("s",)) and column not in named]
    if not named and table.sample_time is None:
        named = [column for column in rising if _is_nameless_time(column, first=column is columns[0])]
    return (named[0], "its name" if named[0] in called else "it rises evenly") if named else None


def _halts(column: Candidate) -> bool:
    """Return whether a column rises with halts, as the stamps of a host that repeat."""
    steps = np.diff(column.values)
    return bool(np.all(steps >= 0.0) and np.mean(steps > 0.0) >= OF_STAMPS)


def _is_nameless_time(column: Candidate, *, first: bool) -> bool:
    """Return whether a column that no name tells rises evenly; without a halt, if it is not the first."""
    if column.unit or column.unknown or _counts_rows(column.values) or not _even(column.values):
        return False
    if first:
        return column.meaning.role in ("", "status")
    return not column.meaning.role and bool(np.all(np.diff(column.values) > 0.0))


def _counts_rows(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) == 1.0))


def _advances(column: Candidate) -> bool:
    return bool(column.values[-1] > column.values[0])


def _even(values: np.ndarray) -> bool:
    steps = np.diff(values)
    return bool(np.quantile(np.abs(steps - np.median(steps)), 0.95) <= 0.05 * np.median(steps))
