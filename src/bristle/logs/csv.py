"""Logs as text: CSV in its many dialects, with the preambles that drives and LabVIEW write."""

from __future__ import annotations

import codecs
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.layout import (
    COMMENT,
    PREAMBLE_LINES,
    SAMPLE_ROWS,
    Layout,
    cells_of,
    is_number,
    layout_of,
    why_no_number,
)
from bristle.logs.table import Table

__all__ = ["read_csv"]

TAIL_ROWS = 1000


def read_csv(data: bytes, source: Path) -> Table:
    """Return the columns of a text file.

    Cells are separated by comma, semicolon, tab or blanks; lines that start with ``#`` and what stands before
    the header are skipped; the header may be missing; a decimal comma is understood unless commas separate.

    Raises
    ------
    InputError
        If a cell is no number, a row has another number of cells, or the file ends within a row.
    """
    text = _decoded(data, source)
    lines = text.split("\n", PREAMBLE_LINES + SAMPLE_ROWS)
    layout = layout_of(lines[: PREAMBLE_LINES + SAMPLE_ROWS], source)
    body = text[sum(len(line) + 1 for line in lines[: layout.first]) :]
    body, notes = _without_open_end(body, layout, source)
    values = _numbers(body, layout, source)
    kept = [index for index, numeric in enumerate(layout.numeric) if numeric]
    left_out = [name for name, numeric in zip(layout.names, layout.numeric, strict=True) if not numeric]
    if left_out:
        notes.append(f"text was left out: {', '.join(left_out)}")
    texts = {name: _text_in(name, lines, layout, source) for name in left_out}
    columns = {layout.names[index]: np.ascontiguousarray(column) for index, column in zip(kept, values.T, strict=True)}
    units = {layout.names[index]: layout.units[index] for index in kept if layout.units[index]}
    return Table(columns, units, texts=texts, notes=tuple(notes), format="text")


def _text_in(name: str, lines: Sequence[str], layout: Layout, source: Path) -> InputError:
    """Return why a column was left out, for those who ask for it."""
    cell = cells_of(lines[layout.first], layout.delimiter)[layout.names.index(name)]
    said, mend = why_no_number(cell)
    return InputError(said, path=f"{source}: line {layout.first + 1}, column {name!r}", value=cell, mend=mend)


def _decoded(data: bytes, source: Path) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ["utf-16"]
    elif b"\0" in data:
        raise InputError("is neither text nor a log of a known kind", path=str(source), mend="Export it as CSV")
    else:
        encodings = ["utf-8-sig", "latin-1"]
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        return text.replace("\r\n", "\n").replace("\r", "\n")
    raise InputError("is truncated: it ends within a character", path=str(source), mend="Copy or export it again")


def _without_open_end(body: str, layout: Layout, source: Path) -> tuple[str, list[str]]:
    """Leave out a last line that no line break ends: its last cell may be cut, and nothing tells."""
    if body.endswith("\n"):
        return body, []
    whole, _, last = body.rpartition("\n")
    cells = cells_of(last, layout.delimiter)
    before = [cells_of(line, layout.delimiter)[-1] for line in whole.split("\n")[-TAIL_ROWS:] if line.strip()]
    cut = len(cells) != len(layout.numeric) or len(cells[-1]) < min(map(len, before), default=0)
    if layout.numeric[-1]:
        cut = cut or not (is_number(cells[-1], layout.decimal_comma) or cells[-1] in before)
    if cut:
        raise InputError(
            "is truncated: it ends within a row",
            path=f"{source}: line {layout.first + body.count(chr(10)) + 1}",
            value=last,
            mend="Copy or export the log again, or delete this row",
        )
    return f"{whole}\n", ["the file does not end with a line break: its last row may be cut and was left out"]


def _numbers(body: str, layout: Layout, source: Path) -> np.ndarray:
    plain = body.replace(",", ".") if layout.decimal_comma else body
    kept = [index for index, numeric in enumerate(layout.numeric) if numeric]
    try:
        values = np.loadtxt(
            io.StringIO(plain),
            delimiter=layout.delimiter,
            comments=COMMENT,
            quotechar='"' if '"' in plain else None,
            usecols=None if all(layout.numeric) else kept,
            ndmin=2,
        )
    except ValueError as error:
        raise _bad_row(body.split("\n"), layout, source) or InputError(str(error), path=str(source)) from None
    expected = len(values) * (len(layout.numeric) - 1)
    if layout.delimiter and body.count(layout.delimiter) != expected:
        bad = _bad_row(body.split("\n"), layout, source)
        if bad:
            raise bad
    return values


def _bad_row(rows: Sequence[str], layout: Layout, source: Path) -> InputError | None:
    """Return the error that names the first row and cell that cannot be read."""
    for index, row in enumerate(rows):
        cells = cells_of(row.partition(COMMENT)[0], layout.delimiter)
        if not any(cells):
            continue
        place = f"{source}: line {layout.first + index + 1}"
        if len(cells) != len(layout.numeric):
            return InputError(
                f"has {len(cells)} cells instead of {len(layout.numeric)}",
                path=place,
                value=row,
                mend="Mend or delete this row; if it is the last, the file is truncated",
            )
        for column, cell in enumerate(cells):
            if layout.numeric[column] and not is_number(cell, layout.decimal_comma):
                said, mend = why_no_number(cell)
                return InputError(
                    said,
                    path=f"{place}, column {layout.names[column]!r}",
                    value=cell,
                    mend=mend or "Repair the sample or delete its row: a gap in time is understood",
                )
    return None
