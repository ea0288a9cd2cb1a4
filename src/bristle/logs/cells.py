"""The cells of a line of text: what separates them, which of them are numbers, and what the others are."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

import numpy as np

from bristle.core.errors import InputError

__all__ = ["CLOCK", "COMMENT", "COMMENTS", "cells_of", "has_content", "is_number", "numbers_in", "why_no_number", "without_comments"]

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
    """Return what a cell is that is no number, and what to do about it.

    Examples
    --------
    >>> why_no_number("1.234,5")[0], why_no_number("00:00:01.250")[0]
    ('is a number with thousands separators', 'is a time of day')
    """
    if CLOCK.fullmatch(cell):
        return "is a time of day", (
            "Export the time in seconds from the start, or leave the column of time out of the axis file and write sample_time in [timing]"
        )
    if _THOUSANDS.fullmatch(cell):
        return "is a number with thousands separators", "Export numbers without them"
    if _DECIMAL_COMMA.fullmatch(cell):
        return "is a number with a decimal comma", "Export with decimal points, or with semicolons between the cells"
    return "is not a number" if cell else "is empty", ""


def has_content(line: str) -> bool:
    """Return whether a line is more than blanks and a remark."""
    return bool(line.strip()) and not line.lstrip().startswith(COMMENT)
