"""The cells of a line of text: what separates them, which of them are numbers, and what the others are."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle.core.errors import InputError
from bristle.core.typography import printable

__all__ = [
    "CLOCK",
    "COMMENT",
    "COMMENTS",
    "Beside",
    "cells_of",
    "is_number",
    "numbers_in",
    "table_beside",
    "why_no_number",
    "without_comments",
]

COMMENT = "#"
COMMENTS = r'(?m)^[ \t]*#.*$|[ \t]#[^"\n]*$'
"""What follows a `COMMENT` at the start of a line or behind a blank: one within a cell is part of it."""
LONGEST_CELL = 131_072  # what the reader of quoted cells takes
TRUTH = {"true": "1", "false": "0", "wahr": "1", "falsch": "0", "on": "1", "off": "0"}
CLOCK = re.compile(r"(\d{4}[-/]\d\d[-/]\d\d[T ])?\d{1,2}:\d\d(:\d\d([.,]\d+)?)?Z?", re.ASCII)
"""A date with a time, or a time of day."""
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(([.' ]\d{3})+(,\d+)?|([,' ]\d{3})+(\.\d+)?)", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?", re.ASCII)
_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|nan|inf|infinity|1\.#\w+)", re.IGNORECASE | re.ASCII)


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line, stripped of blanks and quotes; within quotes nothing separates."""
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    if delimiter is None:
        return [cell.strip().strip('"').strip() for cell in line.split()]
    if len(line) > LONGEST_CELL and max(map(len, line.split(delimiter))) > LONGEST_CELL:
        raise InputError(
            "has a cell that is too long", value=line, allowed=f"up to {LONGEST_CELL} characters", mend="Is it the right file?"
        )
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def without_comments(text: str) -> str:
    """Return lines without what is said behind their cells."""
    return re.sub(COMMENTS, "", text) if COMMENT in text else text


def is_number(cell: str, decimal_comma: bool) -> bool:
    """Return whether a cell is a number."""
    if decimal_comma and "." not in cell:
        cell = cell.replace(",", ".", 1)
    return bool(_NUMBER.fullmatch(cell))


def numbers_in(cells: Sequence[str], decimal_comma: bool) -> np.ndarray | None:
    """Return cells as numbers, truth values as 1 and 0; None where one of them is something else.

    Examples
    --------
    >>> numbers_in(["1,5", "-2"], True), numbers_in(["TRUE"], False), numbers_in(["x"], False)
    (array([ 1.5, -2. ]), array([1.]), None)
    """
    plain = [cell.replace(",", ".") for cell in cells] if decimal_comma else list(cells)
    try:
        return np.array(plain, dtype=float)
    except ValueError:
        plain = [TRUTH.get(cell.lower(), cell) for cell in plain]
    return np.array(plain, dtype=float) if all(is_number(cell, False) for cell in plain) else None


def why_no_number(cell: str) -> tuple[str, str]:
    """Return what a cell is that is no number, and what to do about it."""
    if CLOCK.fullmatch(cell):
        return "is a time of day", (
            "Export the time in seconds from the start, or leave the column of time out of the axis file and write sample_time in [timing]"
        )
    if _THOUSANDS.fullmatch(cell):
        return "is a number with thousands separators", "Export numbers without them"
    if _DECIMAL_COMMA.fullmatch(cell):
        return "is a number with a decimal comma", "Export with decimal points, or with semicolons between the cells"
    return "is not a number" if cell else "is empty", ""


LAST_ROWS = 3  # in which nothing stands beside the numbers
MOST_SHOWN = 6  # cells

Row = tuple[int, list[str]]
"""The index of a line, and its cells."""


@dataclass(frozen=True)
class Beside:
    """What stood beside the first rows of numbers."""

    rows: dict[int, list[str]]
    facts: dict[str, str]
    note: str

    def lines(self, of_file: Sequence[str], delimiter: str | None) -> list[str]:
        """Return the lines of a file without these cells."""
        lines = list(of_file)
        for i, cells in self.rows.items():
            quoted = (f'"{cell}"' if delimiter and delimiter in cell else cell for cell in cells)
            lines[i] = delimiter.join(quoted) if delimiter else " ".join(cells).rstrip()
        return lines


def table_beside(rows: Sequence[Row], decimal_comma: bool) -> Beside | None:
    """Return what stands beside the first rows of numbers: columns of text that end while the rows go on.

    Columns of numbers that end early are no such table: they were recorded less long.
    """
    complete = rows[:-1] if len(rows) > 2 else rows  # the last line there is may be cut short
    below = [cells for _, cells in complete[-LAST_ROWS:]]
    count = max((k + 1 for cells in below for k, cell in enumerate(cells) if cell), default=0)
    if not any(any(cells[count:]) for _, cells in complete):
        return None
    numeric = [k for k in range(count) if any(is_number(cells[k], decimal_comma) for cells in below if k < len(cells))]
    recorded: list[Row] = []
    for index, cells in reversed(complete):  # as far as most cells are numbers where they are below
        if 2 * sum(k < len(cells) and is_number(cells[k], decimal_comma) for k in numeric) < len(numeric):
            break
        recorded.append((index, cells))
    width = max((len(cells) for _, cells in recorded), default=0)
    start = next((k for k in range(count, width) if _is_text([row[k] for _, row in recorded if row[k : k + 1]], decimal_comma)), None)
    if start is None:
        return None
    aside = [row for row in recorded if any(row[1][start:])]
    early = max((k + 1 for _, cells in recorded for k in range(count, start) if any(cells[k : k + 1])), default=0)
    width = max(len(below[-1]), early)
    keep = min(start, width)
    left = {index: [*cells[:keep], *[""] * (width - keep)] for index, cells in recorded if any(cells[start:]) or len(cells) > width}
    pairs = ([cell for cell in cells[start:] if cell] for _, cells in aside)
    facts = {name: " ".join(values) for name, *values in pairs if values}
    said = [cell for _, row in reversed(aside) for cell in row[start:] if cell]
    count_above = sum(index <= aside[0][0] for index, _ in recorded)
    first = f"first {count_above} rows" if count_above > 1 else "first row"
    shown = printable(", ".join(said[:MOST_SHOWN])) + (" and others" if len(said) > MOST_SHOWN else "")
    return Beside(left, facts, f"what stands beside the {first} was left out: {shown}")


def _is_text(cells: Sequence[str], decimal_comma: bool) -> bool:
    """Return whether those of several cells that are filled are text for the most part."""
    filled = [cell for cell in cells if cell]
    return bool(filled) and 2 * sum(is_number(cell, decimal_comma) for cell in filled) < len(filled)
