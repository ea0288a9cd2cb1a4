"""Layout of a text file: first row of numbers, separator, and names of the columns."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle.core import InputError, units
from bristle.logs.table import split_unit
from bristle.logs.words import distinct, is_time, listed, plain_unit

COMMENT = "#"
COMMENTS = r'(?m)^[ \t]*#.*$|[ \t]#[^"\n]*$'
"""A `COMMENT` at the start of a line or after a blank, with the rest of the line; inside a cell it is content."""
LONGEST_CELL = 131_072  # limit of the reader of quoted cells
TRUTH = {"true": "1", "false": "0", "wahr": "1", "falsch": "0", "on": "1", "off": "0"}
# A date with a time, or a time of day.
CLOCK = re.compile(r"(\d{4}[-/]\d\d[-/]\d\d[T ])?\d{1,2}:\d\d(:\d\d([.,]\d+)?)?Z?", re.ASCII)
_NUMBER = re.compile(
    r"[+-]?((\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|nan|inf|infinity|1\.#\w+)", re.IGNORECASE | re.ASCII
)


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line, without blanks and quotes; delimiters inside quotes do not separate."""
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    if delimiter is None:
        return [cell.strip().strip('"').strip() for cell in line.split()]
    if len(line) > LONGEST_CELL and max(map(len, line.split(delimiter))) > LONGEST_CELL:
        raise InputError(
            "has a cell that is too long",
            value=line,
            allowed=f"up to {LONGEST_CELL} characters",
            mend="Check that this is the right file",
        )
    return [
        cell.strip()
        for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    ]


def without_comments(text: str) -> str:
    """Return lines without the comments after their cells."""
    return re.sub(COMMENTS, "", text) if COMMENT in text else text


def is_number(cell: str, decimal_comma: bool) -> bool:
    """Return whether a cell is a number."""
    if decimal_comma and "." not in cell and not cell.endswith(","):
        cell = cell.replace(",", ".", 1)
    if cell[:1] not in "+-.0123456789niNI":  # most words
        return False
    try:
        float(cell)
    except ValueError:
        return bool(_NUMBER.fullmatch(cell))
    # Python also reads digits of other scripts, and 1_000.
    return cell.isascii() and "_" not in cell


def numbers_in(cells: Sequence[str], decimal_comma: bool) -> np.ndarray | None:
    """Return cells as numbers, booleans as 1 and 0; None if any cell is something else.

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
    """Return the reason why a cell is not a number, and advice."""
    if CLOCK.fullmatch(cell):
        return "is a time of day", (
            "Export the time in seconds from the start, or leave the column of time out of the axis file and write sample_time in [timing]"
        )
    if re.fullmatch(r"[+-]?\d{1,3}(([.' ]\d{3})+(,\d+)?|([,' ]\d{3})+(\.\d+)?)", cell, re.ASCII):
        return "is a number with thousands separators", "Export numbers without these separators"
    if re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", cell, re.ASCII):
        return (
            "is a number with a decimal comma",
            "Export with decimal points, or with semicolons between the cells",
        )
    return "is not a number" if cell else "is empty", ""


# Tried in this order; None is a run of blanks. The comma comes last but one, because it can be a decimal comma.
# Units in a row below the names, in addition to the decimal ones.
USUAL_UNITS = frozenset(
    listed(
        "1/min Grad Hz K LU W bar bool deg deg/s deg/s^2 degC h hex inch kHz kW lbf m/min m/s^2 min mm/min mm/s^2 rad/s^2 rev rev/s rpm"
    )
)
# Signs that a word in a file with this separator does not contain.
STRONGER = {"\t": "", ";": "\t", ",": ";\t", None: ";\t,"}
HEAD_LINES, SAMPLE_ROWS = 420, 20  # lines searched for the first numbers, including the first rows
MOST_COLUMNS = 50_000


@dataclass(frozen=True)
class Layout:
    """Position and format of the numbers in a text file."""

    delimiter: str | None
    decimal_comma: bool
    first: int
    numeric: tuple[bool, ...]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def is_row(self, cells: Sequence[str]) -> bool:
        """Return whether cells are a row: only cells of words at its end may be missing."""
        return len(cells) <= len(self.numeric) and not any(self.numeric[len(cells) :])


def layout_of(lines: Sequence[str], source: Path) -> Layout:
    """Return the layout that reads most numbers from the first lines of a file."""
    bare = [without_comments(line) for line in lines]
    best, best_score = None, (0.0,)
    for delimiter in ("\t", ";", ",", None):
        if (
            delimiter is None
            and best is not None
            and best.delimiter == "\t"
            and best_score[0] == 1.0
        ):
            break  # blanks between tabs are parts of words
        rows = _rows(bare, delimiter, source)
        for decimal_comma in (False, True) if delimiter != "," else (False,):
            layout = _rows_of_numbers(rows, delimiter, decimal_comma)
            if layout is not None and (score := _score(rows, layout)) > best_score:
                best, best_score = layout, score
    if best is None:
        raise InputError(
            "holds no rows of numbers, or is truncated before them",
            path=str(source),
            mend="Export one row per sample, with cells separated by a comma, a semicolon, a tab or blanks",
        )
    _refuse_bad_first_rows(bare, best, source)
    names, units_, notes = _header(lines, best)
    return replace(best, names=names, units=units_, notes=notes)


def _rows(lines: Sequence[str], delimiter: str | None, source: Path) -> list[tuple[int, list[str]]]:
    """Return the non-empty lines, with their index, cell by cell."""
    rows: list[tuple[int, list[str]]] = []
    count = 0
    for index, line in enumerate(lines):
        cells = (
            cells_of(line, delimiter)
            if line.strip() and not line.lstrip().startswith(COMMENT)
            else []
        )
        if len(cells) > MOST_COLUMNS:
            raise InputError(
                f"has {len(cells)} cells in a row",
                path=f"{source}: line {index + 1}",
                allowed=f"up to {MOST_COLUMNS}",
                mend="Export one row per sample and one column per channel",
            )
        if any(cells):
            rows.append((index, cells))
            count += len(cells)
        if count > 300_000:  # searched for the first row of numbers
            break
    return rows


class _Columns(NamedTuple):
    """The columns in which a row has a number, and those in which it has another word."""

    numbers: frozenset[int]
    words: frozenset[int]


def _columns_of(cells: Sequence[str], decimal_comma: bool) -> _Columns:
    filled = frozenset(compress(range(len(cells)), cells))
    if _are_numbers(cells):
        return _Columns(filled, frozenset())
    numbers = frozenset(column for column in filled if is_number(cells[column], decimal_comma))
    return _Columns(numbers, filled - numbers)


def _are_numbers(cells: Sequence[str]) -> bool:
    """Return whether `is_number` holds for each cell, in one pass; False if that is not certain."""
    text = "".join(cells)
    try:
        list(map(float, cells))
    except ValueError:
        return False
    return text.isascii() and "_" not in text


def _rows_of_numbers(
    rows: list[tuple[int, list[str]]], delimiter: str | None, decimal_comma: bool
) -> Layout | None:
    """Return the layout with the first line after which rows have numbers in the same columns."""
    # The last line may be cut short: the rows are checked when they are read.
    complete = rows[:-1] if len(rows) > 2 else rows
    columns: list[_Columns] = []
    for start in range(len(complete) - 1 + (len(rows) > 2)):
        end = min(start + SAMPLE_ROWS, len(complete))
        for _, cells in complete[len(columns) : end]:
            columns.append(_columns_of(cells, decimal_comma))
        numeric = frozenset().union(*(row.numbers for row in columns[start:end]))
        if not columns[start].numbers or any(numeric & row.words for row in columns[start:end]):
            continue
        widths = [len(cells) for _, cells in complete[start:end]]
        if min(widths) > max(numeric):  # cells of words at the end of a row may be missing
            above = [
                row.words
                for row in columns[max(start - 2, 0) : start]
                if delimiter and not row.numbers
            ]
            width = max(*widths, 1 + max(frozenset().union(*above), default=-1))
            return Layout(
                delimiter,
                decimal_comma,
                rows[start][0],
                tuple(column in numeric for column in range(width)),
            )
    return None


def _score(rows: list[tuple[int, list[str]]], layout: Layout) -> tuple[float, ...]:
    """Return how well a layout explains its usual row: a word in a single row does not count."""
    above = next((len(cells) for index, cells in reversed(rows) if index < layout.first), 0)
    counts, is_headed = [], above == len(layout.numeric)
    for cells in [cells for index, cells in rows if index >= layout.first][:SAMPLE_ROWS]:
        numbers = sum(compress(layout.numeric, cells))
        words = [
            cell
            for cell, is_numeric in zip(cells, layout.numeric, strict=False)
            if cell and not is_numeric
        ]
        parted = [
            sum(any(sign in word for sign in signs) for word in words)
            for signs in (STRONGER[layout.delimiter], ";, ")
        ]
        parted[0] += sum(
            all(is_number(part, layout.decimal_comma) for part in word.split()) for word in words
        )
        counts.append(
            (
                numbers / (numbers + parted[0]),
                is_headed,
                numbers / (numbers + len(words)),
                numbers,
                -parted[1],
            )
        )
    return (*np.median(counts, axis=0).tolist(), -layout.first)


def _refuse_bad_first_rows(lines: Sequence[str], layout: Layout, source: Path) -> None:
    """Refuse a line directly before the first row of numbers that differs from it in one cell: it is no preamble."""
    above = [(i, cells_of(line, layout.delimiter)) for i, line in enumerate(lines[: layout.first])]
    above = [
        (i, cells)
        for i, cells in above
        if lines[i].strip() and not lines[i].lstrip().startswith(COMMENT)
    ]
    if not above:
        return
    index, cells = above.pop()
    count, place = len(layout.numeric), f"{source}: line {index + 1}"
    rows = [cells_above for _, cells_above in above if len(cells_above) == count]
    kinds = [is_number(cell, layout.decimal_comma) for cell in cells]
    numbered = np.flatnonzero(layout.numeric).tolist()
    is_row = numbered[-1] < len(cells) and all(kinds[k] for k in numbered)
    mend = "Delete the additional cells in this row"
    if len(cells) != count:
        if is_row or (
            (rows or len(cells) > count)
            and all(kind or not cell for kind, cell in zip(kinds, cells, strict=True))
        ):
            raise InputError(
                f"has {len(cells)} cells instead of {count}",
                path=place,
                value=lines[index],
                mend=mend if is_row else "",
            )
        return
    odd = next(
        (column for column, is_numeric in enumerate(layout.numeric) if is_numeric != kinds[column]),
        None,
    )
    if rows and any(kinds) and odd is not None:
        message, mend = (
            ("is a number, but the cells below it are text", mend)
            if kinds[odd]
            else why_no_number(cells[odd])
        )
        named = not any(is_number(cell, layout.decimal_comma) for cell in rows[0]) and rows[0][odd]
        column = repr(split_unit(rows[0][odd])[0]) if named else odd + 1
        raise InputError(message, path=f"{place}, column {column}", value=cells[odd], mend=mend)
    if is_row:
        raise InputError(
            "is a row of numbers with text in other columns than the rows below it",
            path=place,
            value=lines[index],
            mend=mend,
        )


def _header(
    lines: Sequence[str], layout: Layout
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the one or two lines of text directly before the numbers."""
    count = len(layout.numeric)
    above = [
        _header_cells(line, layout)
        for line in [line for line in lines[: layout.first] if line.strip()][-2:]
    ]
    headers = [cells for cells in above if len(cells) == count and any(cells)]
    headers = [
        cells
        for cells in headers
        if not any(is_number(cell, layout.decimal_comma) for cell in cells)
    ]
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
            while filled[index] in names:  # the name in the file wins over a default name
                filled[index] += "_"
    names, notes = distinct(filled)
    return tuple(names), tuple("" if unit in ("-", "1") else unit for unit in units), tuple(notes)


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Return name and unit of a header; a unit after a slash or the word "in" stays part of the name."""
    name, unit = split_unit(cell)
    parts = re.split(r"\s+in\s+|/|,\s+", name, maxsplit=1) if not unit else []
    if len(parts) == 2 and parts[0] and not units.is_decimal(plain_unit(parts[0])):
        spelt_unit = plain_unit(parts[1])
        unit = spelt_unit if units.is_decimal(spelt_unit) or spelt_unit in USUAL_UNITS else ""
    return name, unit


def _header_cells(line: str, layout: Layout) -> list[str]:
    """Return the cells of a line above the numbers; empty columns at the end may be missing."""
    line = line.strip(" ").lstrip(COMMENT + "%").strip(" ")
    if layout.delimiter is None:
        # A blank can separate a unit from its name, too.
        words = re.split(r"(?<=\s)(?=[\[(])", line)
        line = "".join([*(word.rstrip() for word in words[:-1]), words[-1]])
    cells = [cell.lstrip(COMMENT + "%").strip() for cell in cells_of(line, layout.delimiter)]
    if len(cells) == len(layout.numeric) + 1 and cells[-1].lower() in ("", "comment"):
        cells.pop()  # a column of remarks without numbers, as in files of LabVIEW
    lacking = layout.numeric[len(cells) :]
    return cells if any(lacking) and not any(map(is_time, cells)) else cells + [""] * len(lacking)


def _are_units(cells: Sequence[str]) -> bool:
    plain = [plain_unit(cell) for cell in cells]
    if any(len(cell) > units.LONGEST_UNIT for cell in plain):
        return False
    spelt = [units.split(f"1 {cell}")[1] for cell in plain if cell]
    return bool(spelt) and all(units.is_decimal(unit) or unit in USUAL_UNITS for unit in spelt)
