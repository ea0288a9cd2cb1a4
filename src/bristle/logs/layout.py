"""How a text file is laid out: where its numbers begin, what separates them, how the columns are called."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bristle.core import units
from bristle.core.errors import InputError
from bristle.logs.table import split_unit

__all__ = ["COMMENT", "Layout", "cells_of", "is_number", "layout_of", "why_no_number"]

COMMENT = "#"
# Tried in this order; None is any run of blanks. A comma is last but one: it may be a decimal comma.
DELIMITERS = ("\t", ";", ",", None)
# Units that a line below the names may consist of, besides the decimal ones.
USUAL_UNITS = frozenset({"deg", "deg/s", "rev", "rev/s", "rpm", "1/min", "min", "lbf", "inch"})
PREAMBLE_LINES, SAMPLE_ROWS = 400, 20
_CLOCK = re.compile(r"(\d{4}-\d\d-\d\d[T ])?\d{1,2}:\d\d(:\d\d([.,]\d+)?)?")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(([.' ]\d{3})+(,\d+)?|([,' ]\d{3})+(\.\d+)?)")
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|nan|inf|infinity|1\.#\w+)", re.IGNORECASE)


@dataclass(frozen=True)
class Layout:
    """Where and how the numbers of a text file stand.

    Parameters
    ----------
    delimiter : str or None
        What separates cells; None is any run of blanks.
    decimal_comma : bool
        Whether decimals follow a comma.
    first : int
        Index of the first line of numbers.
    numeric : tuple of bool
        Which columns hold numbers.
    names, units : tuple of str
        What the header says, one for each column.
    """

    delimiter: str | None
    decimal_comma: bool
    first: int
    numeric: tuple[bool, ...]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line, stripped of blanks and quotes; within quotes nothing separates."""
    if '"' in line and delimiter is not None:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    return [cell.strip().strip('"').strip() for cell in line.split(delimiter)]


def is_number(cell: str, decimal_comma: bool) -> bool:
    """Return whether a cell is a number."""
    if decimal_comma and "." not in cell:
        cell = cell.replace(",", ".", 1)
    return bool(_NUMBER.fullmatch(cell))


def why_no_number(cell: str) -> tuple[str, str]:
    """Return what a cell is that is no number, and what to do about it.

    Examples
    --------
    >>> why_no_number("1.234,5")[0], why_no_number("00:00:01.250")[0]
    ('is a number with thousands separators', 'is a time of day')
    """
    if _CLOCK.fullmatch(cell):
        return "is a time of day", (
            "Export the time in seconds from the start, or leave the column of time out of the axis file and write "
            "sample_time in [timing]"
        )
    if _THOUSANDS.fullmatch(cell):
        return "is a number with thousands separators", "Export numbers without them"
    if _DECIMAL_COMMA.fullmatch(cell):
        return "is a number with a decimal comma", "Export with decimal points, or with semicolons between the cells"
    return "is not a number" if cell else "is empty", ""


def layout_of(lines: Sequence[str], source: Path) -> Layout:
    """Return the layout that makes most numbers of the first lines of a file.

    Raises
    ------
    InputError
        If nowhere rows of numbers follow one another, or a cell in the first of them is no number.
    """
    best, best_score = None, (0.0, 0)
    for delimiter in DELIMITERS:
        for decimal_comma in (False, True) if delimiter != "," else (False,):
            found = _rows_of_numbers(lines, delimiter, decimal_comma)
            if found is None:
                continue
            first_row = cells_of(lines[found.first], delimiter)
            filled = sum(bool(cell) or it for cell, it in zip(first_row, found.numeric, strict=True))
            score = (sum(found.numeric) / filled, sum(found.numeric))
            if score > best_score:
                best, best_score = found, score
    if best is None:
        raise InputError(
            "holds no rows of numbers, or is truncated before them",
            path=str(source),
            mend="Export one row a sample, with cells apart by a comma, a semicolon, a tab or blanks",
        )
    _refuse_bad_first_rows(lines, best, source)
    names, units_ = _header(lines, best)
    return Layout(best.delimiter, best.decimal_comma, best.first, best.numeric, names, units_)


def _rows_of_numbers(lines: Sequence[str], delimiter: str | None, decimal_comma: bool) -> Layout | None:
    """Return the layout with the first line from which on rows have numbers in the same columns."""
    rows = [(index, cells_of(line, delimiter)) for index, line in enumerate(lines) if _has_content(line)]
    # The last line there is may be cut short: the rows themselves are examined when they are read.
    whole = rows[:-1] if len(rows) > 2 else rows
    for start in range(len(whole) - 1 + (len(rows) > 2)):
        sample = [cells for _, cells in whole[start : start + SAMPLE_ROWS]]
        if len({len(cells) for cells in sample}) == 1:
            columns = list(zip(*sample, strict=True))
            numeric = [any(is_number(cell, decimal_comma) for cell in column) for column in columns]
            if any(numeric) and all(
                not wanted or all(not cell or is_number(cell, decimal_comma) for cell in column)
                for wanted, column in zip(numeric, columns, strict=True)
            ):
                return Layout(delimiter, decimal_comma, rows[start][0], tuple(numeric))
    return None


def _has_content(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(COMMENT)


def _refuse_bad_first_rows(lines: Sequence[str], layout: Layout, source: Path) -> None:
    """Refuse a line right before the first that is a row of numbers but for one cell: it is no preamble."""
    above = [(i, cells_of(lines[i], layout.delimiter)) for i in range(layout.first) if _has_content(lines[i])]
    if not above:
        return
    index, cells = above.pop()
    count, place = len(layout.numeric), f"{source}: line {index + 1}"
    under_a_row = any(len(other) == count for _, other in above)
    if len(cells) != count:
        numbers = all(is_number(cell, layout.decimal_comma) for cell in cells if cell)
        if numbers and (under_a_row or len(cells) > count):
            raise InputError(f"has {len(cells)} cells instead of {count}", path=place, value=lines[index])
        return
    kinds = [is_number(cell, layout.decimal_comma) for cell in cells]
    if under_a_row and any(kinds):
        odd = [column for column, it in enumerate(layout.numeric) if it != kinds[column]]
        said = "is a number, and below it stands text"
        mend = ""
        if not kinds[odd[0]]:
            said, mend = why_no_number(cells[odd[0]])
        heads = next((other for _, other in above if len(other) == count), cells)
        named = not any(is_number(cell, layout.decimal_comma) for cell in heads) and heads[odd[0]]
        column = repr(split_unit(heads[odd[0]])[0]) if named else odd[0] + 1
        raise InputError(said, path=f"{place}, column {column}", value=cells[odd[0]], mend=mend)


def _header(lines: Sequence[str], layout: Layout) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the one or two lines of text right before the numbers."""
    count = len(layout.numeric)
    above = [_header_cells(line, layout) for line in lines[: layout.first] if line.strip()][-2:]
    headers = [cells for cells in above if len(cells) == count and any(cells)]
    headers = [cells for cells in headers if not any(is_number(cell, layout.decimal_comma) for cell in cells)]
    if not headers:
        return tuple(f"column_{index + 1}" for index in range(count)), ("",) * count
    if len(headers) == 2 and _are_units(headers[1]):
        names, found = headers[0], [cell.strip("[]()") for cell in headers[1]]
    else:
        names, found = map(list, zip(*(split_unit(cell) for cell in headers[-1]), strict=True))
    return tuple(_distinct(names)), tuple("" if unit in ("-", "1") else unit for unit in found)


def _header_cells(line: str, layout: Layout) -> list[str]:
    """Return the cells of a line above the numbers; empty columns at the end may be missing there."""
    line = line.strip(" ").lstrip(COMMENT + "%").strip(" ")
    if layout.delimiter is None:
        line = re.sub(r"\s+([\[(])", r"\1", line)
    cells = cells_of(line, layout.delimiter)
    lacking = layout.numeric[len(cells) :]
    return cells if any(lacking) else cells + [""] * len(lacking)


def _are_units(cells: Sequence[str]) -> bool:
    plain = [cell.strip("[]()") for cell in cells]
    spelt = [units.split(f"1 {cell}")[1] for cell in plain if cell not in ("", "-")]
    return bool(spelt) and all(unit in units.DECIMAL_UNITS or unit in USUAL_UNITS for unit in spelt)


def _distinct(names: Sequence[str]) -> list[str]:
    distinct: list[str] = []
    for index, name in enumerate(names):
        plain = name or f"column_{index + 1}"
        again = distinct.count(plain) + sum(one.startswith(f"{plain}_") for one in distinct if plain in distinct)
        distinct.append(f"{plain}_{again + 1}" if plain in distinct else plain)
    return distinct
