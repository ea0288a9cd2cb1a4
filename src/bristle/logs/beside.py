"""A table of its own beside the first rows of numbers, such as parameters: it is told apart, and no row is lost."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from bristle.core.typography import printable
from bristle.logs.cells import is_number

__all__ = ["Beside", "table_beside"]

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
        return [_line(self.rows[i], delimiter) if i in self.rows else line for i, line in enumerate(of_file)]


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
    recorded = list(_rows_of_numbers(complete, numeric, decimal_comma))
    start = _first_of_text([cells for _, cells in recorded], count, decimal_comma)
    if start is None:
        return None
    aside = [row for row in recorded if any(row[1][start:])]
    early = max((k + 1 for _, cells in recorded for k in range(count, start) if any(cells[k : k + 1])), default=0)
    width = max(len(below[-1]), early)
    keep = min(start, width)
    left = {index: [*cells[:keep], *[""] * (width - keep)] for index, cells in recorded if any(cells[start:]) or len(cells) > width}
    pairs = ([cell for cell in cells[start:] if cell] for _, cells in aside)
    facts = {name: " ".join(values) for name, *values in pairs if values}
    return Beside(left, facts, _note(aside, start, recorded))


def _rows_of_numbers(rows: Sequence[Row], numeric: Sequence[int], decimal_comma: bool) -> Iterable[Row]:
    """Yield rows from the last one upwards, as far as most cells are numbers where they are below."""
    for index, cells in reversed(rows):
        numbers = sum(k < len(cells) and is_number(cells[k], decimal_comma) for k in numeric)
        if 2 * numbers < len(numeric):
            return
        yield index, cells


def _first_of_text(rows: Sequence[list[str]], count: int, decimal_comma: bool) -> int | None:
    """Return the first column from `count` on that holds text for the most part."""
    for k in range(count, max(map(len, rows), default=0)):
        filled = [cells[k] for cells in rows if k < len(cells) and cells[k]]
        if filled and 2 * sum(is_number(cell, decimal_comma) for cell in filled) < len(filled):
            return k
    return None


def _line(cells: Iterable[str], delimiter: str | None) -> str:
    if delimiter is None:
        return " ".join(cells).rstrip()
    return delimiter.join(f'"{cell}"' if delimiter in cell else cell for cell in cells)


def _note(aside: Sequence[Row], start: int, recorded: Sequence[Row]) -> str:
    cells = [cell for _, row in reversed(aside) for cell in row[start:] if cell]
    more = " and others" if len(cells) > MOST_SHOWN else ""
    rows = sum(index <= aside[0][0] for index, _ in recorded)
    first = f"first {rows} rows" if rows > 1 else "first row"
    return f"what stands beside the {first} was left out: {printable(', '.join(cells[:MOST_SHOWN]))}{more}"
