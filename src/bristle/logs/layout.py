"""How a text file is laid out: where its numbers begin, what separates them, how the columns are called."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bristle.core import units
from bristle.core.errors import InputError
from bristle.logs.cells import COMMENT, Beside, cells_of, is_number, table_beside, why_no_number, without_comments
from bristle.logs.names import distinct, listed, plain_unit
from bristle.logs.table import split_unit

__all__ = ["Layout", "layout_of"]

# Tried in this order; None is any run of blanks. A comma is last but one: it may be a decimal comma.
DELIMITERS = ("\t", ";", ",", None)
# Units that a line below the names may consist of, besides the decimal ones.
USUAL_UNITS = frozenset(
    listed("1/min Grad Hz K LU W bar bool deg deg/s deg/s^2 degC h hex inch kHz kW lbf m/min m/s^2 min mm/min mm/s^2 rad/s^2 rev rev/s rpm")
)
PREAMBLE_LINES, SAMPLE_ROWS = 400, 20
MOST_COLUMNS = 50_000
MOST_CELLS = 300_000  # that are looked at to find where the numbers begin


@dataclass(frozen=True)
class Layout:
    """Where and how the numbers of a text file stand."""

    delimiter: str | None
    decimal_comma: bool
    first: int
    numeric: tuple[bool, ...]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    beside: Beside | None = None


def layout_of(lines: Sequence[str], source: Path) -> Layout:
    """Return the layout that makes most numbers of the first lines of a file."""
    bare = [without_comments(line) for line in lines]
    best, best_score = None, (0.0, 0)
    for delimiter in DELIMITERS:
        rows = _rows(bare, delimiter, source)
        for decimal_comma in (False, True) if delimiter != "," else (False,):
            beside = table_beside(rows, decimal_comma)
            among = [(i, beside.rows.get(i, cells)) for i, cells in rows] if beside else rows
            layout = _rows_of_numbers(among, delimiter, decimal_comma)
            if layout is None:
                continue
            first_row = next(cells for i, cells in among if i == layout.first)
            filled = sum(bool(cell) or is_numeric for cell, is_numeric in zip(first_row, layout.numeric, strict=True))
            score = (sum(layout.numeric) / filled, sum(layout.numeric))
            if score > best_score:
                best, best_score = replace(layout, beside=beside), score
    if best is None:
        message = "holds no rows of numbers, or is truncated before them"
        mend = "Export one row a sample, with cells apart by a comma, a semicolon, a tab or blanks"
        raise InputError(message, path=str(source), mend=mend)
    if best.beside:
        bare = best.beside.lines(bare, best.delimiter)
    _refuse_bad_first_rows(bare, best, source)
    names, units_, notes = _header(lines, best)
    return replace(best, names=names, units=units_, notes=(*notes, *((best.beside.note,) if best.beside else ())))


def _rows(lines: Sequence[str], delimiter: str | None, source: Path) -> list[tuple[int, list[str]]]:
    """Return the lines that have content, with their index, cell by cell."""
    rows: list[tuple[int, list[str]]] = []
    count = 0
    for index, line in enumerate(lines):
        cells = cells_of(line, delimiter) if line.strip() and not line.lstrip().startswith(COMMENT) else []
        if len(cells) > MOST_COLUMNS:
            place, mend = f"{source}: line {index + 1}", "Export one row a sample: are rows and columns exchanged?"
            raise InputError(f"has {len(cells)} cells in a row", path=place, allowed=f"up to {MOST_COLUMNS}", mend=mend)
        if any(cells):
            rows.append((index, cells))
            count += len(cells)
        if count > MOST_CELLS:
            break
    return rows


def _rows_of_numbers(rows: list[tuple[int, list[str]]], delimiter: str | None, decimal_comma: bool) -> Layout | None:
    """Return the layout with the first line from which on rows have numbers in the same columns."""
    # The last line there is may be cut short: the rows themselves are examined when they are read.
    complete = rows[:-1] if len(rows) > 2 else rows
    kinds: list[tuple[np.ndarray, np.ndarray]] = []
    for start in range(len(complete) - 1 + (len(rows) > 2)):
        end = min(start + SAMPLE_ROWS, len(complete))
        if len({len(complete[row][1]) for row in range(start, end)}) != 1:
            continue
        for _, cells in complete[len(kinds) : end]:
            kinds.append((np.array([is_number(cell, decimal_comma) for cell in cells]), np.array([not cell for cell in cells])))
        numbers, blanks = (np.array(flags) for flags in zip(*kinds[start:end], strict=True))
        numeric: np.ndarray = np.any(numbers, axis=0)
        if numeric.any() and np.all(numbers | blanks | ~numeric):
            return Layout(delimiter, decimal_comma, rows[start][0], tuple(bool(is_numeric) for is_numeric in numeric))
    return None


def _refuse_bad_first_rows(lines: Sequence[str], layout: Layout, source: Path) -> None:
    """Refuse a line right before the first that is a row of numbers but for one cell: it is no preamble."""
    above = [(i, cells_of(line, layout.delimiter)) for i, line in enumerate(lines[: layout.first])]
    above = [(i, cells) for i, cells in above if lines[i].strip() and not lines[i].lstrip().startswith(COMMENT)]
    if not above:
        return
    index, cells = above.pop()
    count, place = len(layout.numeric), f"{source}: line {index + 1}"
    rows = [cells_above for _, cells_above in above if len(cells_above) == count]
    kinds = [is_number(cell, layout.decimal_comma) for cell in cells]
    if len(cells) != count:
        if (rows or len(cells) > count) and all(kind or not cell for kind, cell in zip(kinds, cells, strict=True)):
            raise InputError(f"has {len(cells)} cells instead of {count}", path=place, value=lines[index])
    elif rows and any(kinds):
        odd = next(column for column, is_numeric in enumerate(layout.numeric) if is_numeric != kinds[column])
        message, mend = ("is a number, and below it stands text", "") if kinds[odd] else why_no_number(cells[odd])
        named = not any(is_number(cell, layout.decimal_comma) for cell in rows[0]) and rows[0][odd]
        column = repr(split_unit(rows[0][odd])[0]) if named else odd + 1
        raise InputError(message, path=f"{place}, column {column}", value=cells[odd], mend=mend)


def _header(lines: Sequence[str], layout: Layout) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the one or two lines of text right before the numbers."""
    count = len(layout.numeric)
    above = [_header_cells(line, layout) for line in [line for line in lines[: layout.first] if line.strip()][-2:]]
    above = [cells[:count] for cells in above] if layout.beside else above
    headers = [cells for cells in above if len(cells) == count and any(cells)]
    headers = [cells for cells in headers if not any(is_number(cell, layout.decimal_comma) for cell in cells)]
    if not headers:
        return tuple(f"column_{index + 1}" for index in range(count)), ("",) * count, ()
    if len(headers) == 2 and _are_units(headers[1]):
        names, units = headers[0], [cell.strip("[]()") for cell in headers[1]]
    else:
        names, units = map(list, zip(*(_name_and_unit(cell) for cell in headers[-1]), strict=True))
    filled = list(names)
    for index, name in enumerate(names):
        if not name:
            filled[index] = f"column_{index + 1}"
            while filled[index] in names:  # what a person called a column is never another one
                filled[index] += "_"
    names, notes = distinct(filled)
    return tuple(names), tuple("" if unit in ("-", "1") else unit for unit in units), tuple(notes)


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Return name and unit of a header; a unit behind a stroke or the word "in" does not take the name apart."""
    name, unit = split_unit(cell)
    parts = re.split(r"\s+in\s+|/|,\s+", name, maxsplit=1) if not unit else []
    if len(parts) == 2 and parts[0] and not units.is_decimal(plain_unit(parts[0])):
        spelt_unit = plain_unit(parts[1])
        unit = spelt_unit if units.is_decimal(spelt_unit) or spelt_unit in USUAL_UNITS else ""
    return name, unit


def _header_cells(line: str, layout: Layout) -> list[str]:
    """Return the cells of a line above the numbers; empty columns at the end may be missing there."""
    line = line.strip(" ").lstrip(COMMENT + "%").strip(" ")
    if layout.delimiter is None:
        # A unit stands apart from its name by a blank, too.
        words = re.split(r"(?<=\s)(?=[\[(])", line)
        line = "".join([*(word.rstrip() for word in words[:-1]), words[-1]])
    cells = [cell.lstrip(COMMENT + "%").strip() for cell in cells_of(line, layout.delimiter)]
    if len(cells) == len(layout.numeric) + 1 and cells[-1].lower() in ("", "comment"):
        cells.pop()  # of remarks that no row of numbers has, as in files of LabVIEW
    lacking = layout.numeric[len(cells) :]
    return cells if any(lacking) else cells + [""] * len(lacking)


def _are_units(cells: Sequence[str]) -> bool:
    plain = [plain_unit(cell) for cell in cells]
    if any(len(cell) > units.LONGEST_UNIT for cell in plain):
        return False
    spelt = [units.split(f"1 {cell}")[1] for cell in plain if cell]
    return bool(spelt) and all(units.is_decimal(unit) or unit in USUAL_UNITS for unit in spelt)
