"""How a text file is laid out: where its numbers begin, what separates them, how the columns are called."""

from __future__ import annotations

import csv
import re
from collections.abc import Container, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bristle.core import units
from bristle.core.errors import InputError
from bristle.logs.names import distinct
from bristle.logs.table import split_unit
from bristle.logs.words import plain_unit

__all__ = [
    "COMMENTS",
    "Layout",
    "cells_of",
    "is_number",
    "layout_of",
    "numbers_in",
    "why_no_number",
    "without_comments",
]

COMMENT = "#"
COMMENTS = r'(?m)^[ \t]*#.*$|[ \t]#[^"\n]*$'
"""What follows a `COMMENT` at the start of a line or behind a blank: one within a cell is part of it."""
# Tried in this order; None is any run of blanks. A comma is last but one: it may be a decimal comma.
DELIMITERS = ("\t", ";", ",", None)
# Units that a line below the names may consist of, besides the decimal ones.
USUAL_UNITS = frozenset(
    {"deg", "deg/s", "deg/s^2", "rev", "rev/s", "rpm", "1/min", "min", "h", "lbf", "inch", "mm/min", "m/min", "m/s^2",
     "mm/s^2", "rad/s^2", "degC", "K", "bar", "W", "kW", "Hz", "kHz", "LU", "Grad", "bool", "hex"}
)  # fmt: skip
PREAMBLE_LINES, SAMPLE_ROWS = 400, 20
MOST_COLUMNS = 50_000
MOST_CELLS = 300_000  # that are looked at to find where the numbers begin
LONGEST_CELL = 131_072  # what the reader of quoted cells takes
TRUTH = {"true": "1", "false": "0", "wahr": "1", "falsch": "0", "on": "1", "off": "0"}
CLOCK = re.compile(r"(\d{4}[-/]\d\d[-/]\d\d[T ])?\d{1,2}:\d\d(:\d\d([.,]\d+)?)?Z?", re.ASCII)
"""A date with a time, or a time of day."""
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(([.' ]\d{3})+(,\d+)?|([,' ]\d{3})+(\.\d+)?)", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?", re.ASCII)
_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|nan|inf|infinity|1\.#\w+)", re.IGNORECASE | re.ASCII)


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
    notes : tuple of str
        What had to be called otherwise.
    """

    delimiter: str | None
    decimal_comma: bool
    first: int
    numeric: tuple[bool, ...]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line, stripped of blanks and quotes; within quotes nothing separates.

    Raises
    ------
    InputError
        If a quoted cell is longer than any.
    """
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    if delimiter is None:
        return [cell.strip().strip('"').strip() for cell in line.split()]
    if len(line) > LONGEST_CELL and max(map(len, line.split(delimiter))) > LONGEST_CELL:
        raise InputError("has a cell that is too long", value=line, allowed=f"up to {LONGEST_CELL} characters",
                         mend="Is it the right file?")  # fmt: skip
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
    """Return what a cell is that is no number, and what to do about it.

    Examples
    --------
    >>> why_no_number("1.234,5")[0], why_no_number("00:00:01.250")[0]
    ('is a number with thousands separators', 'is a time of day')
    """
    if CLOCK.fullmatch(cell):
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
    bare = [without_comments(line) for line in lines]
    for delimiter in DELIMITERS:
        rows = _rows(bare, delimiter, source)
        for decimal_comma in (False, True) if delimiter != "," else (False,):
            layout = _rows_of_numbers(rows, delimiter, decimal_comma)
            if layout is None:
                continue
            first_row = cells_of(bare[layout.first], delimiter)
            filled = sum(bool(cell) or is_numeric for cell, is_numeric in zip(first_row, layout.numeric, strict=True))
            score = (sum(layout.numeric) / filled, sum(layout.numeric))
            if score > best_score:
                best, best_score = layout, score
    if best is None:
        raise InputError(
            "holds no rows of numbers, or is truncated before them",
            path=str(source),
            mend="Export one row a sample, with cells apart by a comma, a semicolon, a tab or blanks",
        )
    _refuse_bad_first_rows(bare, best, source)
    names, units_, notes = _header(lines, best)
    return Layout(best.delimiter, best.decimal_comma, best.first, best.numeric, names, units_, notes)


def _rows(lines: Sequence[str], delimiter: str | None, source: Path) -> list[tuple[int, list[str]]]:
    """Return the lines that have content, with their index, cell by cell."""
    rows: list[tuple[int, list[str]]] = []
    count = 0
    for index, line in enumerate(lines):
        if not _has_content(line):
            continue
        cells = cells_of(line, delimiter)
        if not any(cells):
            continue
        if len(cells) > MOST_COLUMNS:
            raise InputError(
                f"has {len(cells)} cells in a row", path=f"{source}: line {index + 1}",
                allowed=f"up to {MOST_COLUMNS}", mend="Export one row a sample: are rows and columns exchanged?",
            )  # fmt: skip
        rows.append((index, cells))
        count += len(cells)
        if count > MOST_CELLS:
            break
    return rows


def _rows_of_numbers(rows: list[tuple[int, list[str]]], delimiter: str | None, decimal_comma: bool) -> Layout | None:
    """Return the layout with the first line from which on rows have numbers in the same columns."""
    # The last line there is may be cut short: the rows themselves are examined when they are read.
    complete = rows[:-1] if len(rows) > 2 else rows
    known_kinds: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def kinds(row: int) -> tuple[np.ndarray, np.ndarray]:
        if row not in known_kinds:
            cells = complete[row][1]
            known_kinds[row] = (
                np.array([is_number(cell, decimal_comma) for cell in cells]),
                np.array([not c for c in cells]),
            )
        return known_kinds[row]

    for start in range(len(complete) - 1 + (len(rows) > 2)):
        end = min(start + SAMPLE_ROWS, len(complete))
        if len({len(complete[row][1]) for row in range(start, end)}) != 1:
            continue
        numbers, blanks = (np.array(flags) for flags in zip(*map(kinds, range(start, end)), strict=True))
        numeric: np.ndarray = np.any(numbers, axis=0)
        if numeric.any() and np.all(numbers | blanks | ~numeric):
            return Layout(delimiter, decimal_comma, rows[start][0], tuple(bool(is_numeric) for is_numeric in numeric))
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
    under_a_row = any(len(cells_above) == count for _, cells_above in above)
    if len(cells) != count:
        numbers = all(is_number(cell, layout.decimal_comma) for cell in cells if cell)
        if numbers and (under_a_row or len(cells) > count):
            raise InputError(f"has {len(cells)} cells instead of {count}", path=place, value=lines[index])
        return
    kinds = [is_number(cell, layout.decimal_comma) for cell in cells]
    if under_a_row and any(kinds):
        odd = [column for column, is_numeric in enumerate(layout.numeric) if is_numeric != kinds[column]]
        message = "is a number, and below it stands text"
        mend = ""
        if not kinds[odd[0]]:
            message, mend = why_no_number(cells[odd[0]])
        heads = next((cells_above for _, cells_above in above if len(cells_above) == count), cells)
        named = not any(is_number(cell, layout.decimal_comma) for cell in heads) and heads[odd[0]]
        column = repr(split_unit(heads[odd[0]])[0]) if named else odd[0] + 1
        raise InputError(message, path=f"{place}, column {column}", value=cells[odd[0]], mend=mend)


def _header(lines: Sequence[str], layout: Layout) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the one or two lines of text right before the numbers."""
    count = len(layout.numeric)
    unnamed = [f"column_{index + 1}" for index in range(count)]
    above = [_header_cells(line, layout) for line in [line for line in lines[: layout.first] if line.strip()][-2:]]
    headers = [cells for cells in above if len(cells) == count and any(cells)]
    headers = [cells for cells in headers if not any(is_number(cell, layout.decimal_comma) for cell in cells)]
    if not headers:
        return tuple(unnamed), ("",) * count, ()
    if len(headers) == 2 and _are_units(headers[1]):
        names, units = headers[0], [cell.strip("[]()") for cell in headers[1]]
    else:
        names, units = map(list, zip(*(_name_and_unit(cell) for cell in headers[-1]), strict=True))
    own = set(names)
    names, notes = distinct(name or _unlike(own, called) for name, called in zip(names, unnamed, strict=True))
    return tuple(names), tuple("" if unit in ("-", "1") else unit for unit in units), tuple(notes)


def _unlike(names: Container[str], name: str) -> str:
    """Return a name that none of the others is: what a person called a column is never another one."""
    while name in names:
        name += "_"
    return name


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Return name and unit of a header; a unit behind a stroke or the word "in" does not take the name apart."""
    name, unit = split_unit(cell)
    parts = re.split(r"\s+in\s+|/|,\s+", name, maxsplit=1) if not unit else []
    if len(parts) == 2 and parts[0] and plain_unit(parts[0]) not in units.DECIMAL_UNITS:
        spelt_unit = plain_unit(parts[1])
        unit = spelt_unit if spelt_unit in units.DECIMAL_UNITS or spelt_unit in USUAL_UNITS else ""
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
    return bool(spelt) and all(unit in units.DECIMAL_UNITS or unit in USUAL_UNITS for unit in spelt)
