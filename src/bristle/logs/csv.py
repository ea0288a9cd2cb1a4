"""Logs as text: CSV in its many dialects, with the preambles that drives and LabVIEW write."""

import codecs
import io
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import accumulate
from pathlib import Path

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs import stamped_text
from bristle.logs.layout import (
    COMMENTS,
    HEAD_LINES,
    Layout,
    cells_of,
    is_number,
    layout_of,
    why_no_number,
    without_comments,
)
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import note_of_text
from bristle.logs.words import is_time

HEAD_BYTES = 2**17
LONGEST_LINE = 4 * 2**20
_QUOTED_COMMA = re.compile(rb'"([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)"')  # decimal commas between commas
PIECE = 2**20
BEFORE = 1001  # lines compared with a last line without a line break


def read_csv(data: bytes, request: Request) -> Table:
    """Return the columns of a text file, separated by comma, semicolon, tab or blanks."""
    # The reader skips text above the header, which may be missing, rows of empty cells, and comments after a ``#`` at the
    # start of a line or after a blank. It accepts a decimal comma unless commas separate cells, and numbers such as
    # ``1.5D-3`` and ``-1.#IND``.
    data, encoding = _decodable(data, request.source)
    head = data[:HEAD_BYTES].decode(encoding, "replace").split("\n")
    refuse_frames(head, request.source)
    if (scope := stamped_text.head_of(head)) is not None:  # channels with separate times
        return stamped_text.read_scope(data.decode(encoding).split("\n"), scope, request)
    if stamped_text.is_archive(head):
        return stamped_text.read_archive(data.decode(encoding).split("\n"), request)
    starts = _starts_of_lines(data, HEAD_LINES, request.source)
    last = data.find(b"\n", starts[-1]) % (len(data) + 1)
    lines = [
        data[a : b - 1].decode(encoding)
        for a, b in zip(starts, [*starts[1:], last + 1], strict=True)
    ]
    layout = layout_of(lines[:HEAD_LINES], request.source)
    body, facts = data[starts[layout.first] :], stamped_text.facts_above(lines, layout)
    body, notes = _without_open_end(body, layout, request.source, encoding)
    # The first rows may have no decimals.
    has_commas = (
        layout.delimiter != ","
        and re.search(rb"\d,\d", body) is not None
        and re.search(rb"\d\.\d", body) is None
    )
    layout = replace(layout, decimal_comma=layout.decimal_comma or has_commas)
    words = stamped_text.words_in(body, layout, encoding)
    late = {
        i
        for i, column in words.items()
        if is_number(next(filter(None, column), ""), layout.decimal_comma)
    }
    layout = replace(
        layout, numeric=tuple(numeric or i in late for i, numeric in enumerate(layout.numeric))
    )
    layout = replace(
        layout,
        units=tuple(
            map(stamped_text.units_of_labview(lines, layout).get, layout.names, layout.units)
        ),
    )
    # A signal of a SINUMERIK has an address, which names its column.
    program = (
        "SINUMERIK trace, CSV"
        if any(re.match(r"\+?/(Nck|DriveVsa|Channel|Bag|Plc)/", name) for name in layout.names)
        else ""
    )
    dates = stamped_text.stamps_in(body, layout, encoding)
    words = {i: column for i, column in words.items() if i not in late and i not in dates}
    columns = _irregular(body, layout, request, encoding, has_words=any(map(all, words.values())))
    apart = (
        None
        if columns is None
        else stamped_text.signals_of_rows(words, dates, columns, layout, request, notes)
    )
    notes += note_of_text([layout.names[i] for i in words])
    if columns is not None:
        named = replace(layout, names=stamped_text.names_beside_times(layout.names))
        apart = apart or stamped_text.with_own_times(
            columns, named, request, [*layout.notes, *notes]
        )
    if apart is not None:
        return replace(apart, facts=facts, format=program or apart.format)
    chosen = [
        i
        for i, numeric in enumerate(layout.numeric)
        if numeric and request.choice(layout.names[i], i + 1)
    ]
    values = (
        _numbers(body, layout, request, chosen, encoding)
        if columns is None
        else [columns[i] for i in chosen]
    )
    read = {layout.names[i]: column for i, column in zip(chosen, values, strict=True)}
    read |= {
        layout.names[i]: stamps for i, stamps in dates.items() if request.choice(layout.names[i])
    }
    texts = {}
    for i, column in words.items():
        message, mend = why_no_number(column[0])  # for a caller that needs this column
        texts[layout.names[i]] = InputError(
            message,
            path=f"{request.source}: line {layout.first + 1}, column {layout.names[i]!r}",
            value=column[0],
            mend=mend,
        )
    names = [name for i, name in enumerate(layout.names) if i not in words]
    units = {
        layout.names[i]: unit for i, unit in enumerate(layout.units) if unit and layout.numeric[i]
    }
    return Table(
        read,
        units | {layout.names[i]: "s" for i in dates},
        texts=texts,
        notes=(*layout.notes, *notes),
        format=program or "text",
        names=tuple(names),
        facts=facts,
        numbers={f"column_{i + 1}": name for i, name in enumerate(layout.names)},
    )


def _irregular(
    body: bytes, layout: Layout, request: Request, encoding: str, *, has_words: bool
) -> dict[int, np.ndarray] | None:
    """Return all columns of a file with empty cells, with several columns of time, or with words that may name the rows."""
    separator = (layout.delimiter or "").encode()
    gaps = bool(separator) and (
        separator * 2 in body
        or separator + b"\n" in body
        or b"\n" + separator in body
        or body[:1] == separator
    )
    is_short = bool(separator) and body.count(separator) != body.count(b"\n") * (
        len(layout.numeric) - 1
    )
    columns = stamped_text.partly_empty(body, layout, encoding) if gaps or is_short else None
    times = sum(is_time(name) or name.startswith("column_") for name in layout.names)
    has_clocks = (
        times > 1
        and times < len(layout.names)
        and any(not name.startswith("column_") for name in layout.names)
    )
    numeric = [i for i, is_numeric in enumerate(layout.numeric) if is_numeric]
    if columns is None and has_clocks:
        return dict(zip(numeric, _numbers(body, layout, request, numeric, encoding), strict=True))
    with suppress(InputError):  # a column that is not needed may hold anything
        if columns is None and has_words:
            return dict(
                zip(numeric, _numbers(body, layout, request, numeric, encoding), strict=True)
            )
        return columns
    return None


def _decodable(data: bytes, source: Path) -> tuple[bytes, str]:
    """Return text with uniform line ends, and its encoding, in which each separator is one byte."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            data = data.decode("utf-16").encode("utf-8", "replace")
        except UnicodeDecodeError:
            raise InputError(
                "is truncated: it ends within a character",
                path=str(source),
                mend="Copy or export it again",
            ) from None
    elif b"\0" in data:
        raise InputError(
            "is neither text nor a log in a known format",
            path=str(source),
            mend="Export it as CSV, in UTF-8",
        )
    data = data.removeprefix(codecs.BOM_UTF8)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if _QUOTED_COMMA.search(data[:HEAD_BYTES]):
        data = _QUOTED_COMMA.sub(rb"\1.\2", data)
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        for at in range(0, len(data), PIECE):
            decoder.decode(data[at : at + PIECE])
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:  # the code page of Windows has signs such as ‰ that Latin-1 lacks
        return data, "latin-1" if any(
            sign in data for sign in (b"\x81", b"\x8d", b"\x8f", b"\x90", b"\x9d")
        ) else "cp1252"
    return data, "utf-8"


def _starts_of_lines(data: bytes, most: int, source: Path) -> list[int]:
    """Return the starts of the first lines."""
    lines = data.split(b"\n", most)
    for number, line in enumerate(lines[:most], 1):
        if len(line) > LONGEST_LINE:
            raise InputError(
                f"has a line of more than {LONGEST_LINE} characters",
                path=f"{source}: line {number}",
                mend="Export one row per sample",
            )
    return [0, *accumulate(len(line) + 1 for line in lines[:-1])]


def _without_open_end(
    body: bytes, layout: Layout, source: Path, encoding: str
) -> tuple[bytes, list[str]]:
    """Leave out a last line without a line break: its last cell may be cut."""
    if body.endswith(b"\n"):
        return body, []
    end = body.rfind(b"\n") + 1
    last = body[end:][:LONGEST_LINE].decode(encoding, "replace")
    cells, lines = cells_of(last, layout.delimiter), body[:end].rsplit(b"\n", BEFORE)[-BEFORE:]
    before = [
        cells_of(line.decode(encoding), layout.delimiter)[-1] for line in lines if line.strip()
    ]
    cut = not layout.is_row(cells) or len(cells[-1]) < min(map(len, before), default=0)
    if layout.numeric[-1]:
        cut = cut or not (is_number(cells[-1], layout.decimal_comma) or cells[-1] in before)
    if cut:
        raise InputError(
            "is incomplete: the file ends within this row",
            path=f"{source}: line {layout.first + body.count(10) + 1}",
            value=last,
            mend="Copy or export the log again, or delete this row",
        )
    return body[:end], [
        "the file does not end with a line break: bristle ignores its last row, which may be incomplete"
    ]


def _numbers(
    body: bytes, layout: Layout, request: Request, chosen: list[int], encoding: str
) -> list[np.ndarray]:
    """Return the chosen columns."""
    source = request.source
    # A run of blanks does not show which cell is missing: read all columns, so that rows have the same length.
    read = (
        [index for index, is_numeric in enumerate(layout.numeric) if is_numeric]
        if layout.delimiter is None
        else chosen
    )
    refuse_larger(body.count(b"\n") * len(read) * NUMBER_BYTES, request.limit, source)
    if not chosen:
        return []
    plain = _plain(body, layout)
    try:
        values = np.loadtxt(
            io.TextIOWrapper(io.BytesIO(plain), encoding=encoding, newline="\n"),
            delimiter=layout.delimiter,
            comments=None,
            quotechar='"' if b'"' in plain else None,
            usecols=None if len(read) == len(layout.numeric) else read,
            ndmin=2,
        )
    except ValueError as error:
        message, mend = (
            f"holds a row that cannot be read ({error})",
            "Export the log again, with a number in each cell",
        )
        raise _bad_row(body, layout, source, encoding) or InputError(
            message, path=str(source), mend=mend
        ) from None
    expected = len(values) * (len(layout.numeric) - 1)
    if (
        layout.delimiter
        and body.count(layout.delimiter.encode()) != expected
        and (bad := _bad_row(body, layout, source, encoding))
    ):
        raise bad
    columns = dict(zip(read, values.T, strict=True))
    return [np.ascontiguousarray(columns[index]) for index in chosen]


def _plain(body: bytes, layout: Layout) -> bytes:
    """Return rows without comments, with numbers in the usual spelling."""
    if b".#" in body:
        # Spelling of the C library of Windows until 2015.
        body = re.sub(
            rb"(?<![\d.])1\.#([A-Za-z]+)\w*",
            lambda match: b"inf" if match[1].upper() == b"INF" else b"nan",
            body,
        )
    if b"#" in body:
        body = re.sub(COMMENTS.encode(), b"", body)
    if b"D" in body or b"d" in body:
        body = re.sub(rb"(?<=[\d.])[dD](?=[+-]?\d)", b"e", body)
    separator = (layout.delimiter or "").encode()
    if separator and (b"\n" + separator in body or body.startswith(separator)):
        body = re.sub(rb"(?m)^" + separator + rb"[" + separator + rb"\t ]*$", b"", body)
    return body.replace(b",", b".") if layout.decimal_comma else body


def _bad_row(body: bytes, layout: Layout, source: Path, encoding: str) -> InputError | None:
    """Return the error that names the first unreadable row and cell."""
    for index, row in enumerate(
        io.TextIOWrapper(io.BytesIO(body), encoding=encoding, newline="\n")
    ):
        cells = cells_of(without_comments(row), layout.delimiter)
        place = f"{source}: line {layout.first + index + 1}"
        if any(cells) and not layout.is_row(cells):
            mend = "Correct or delete this row. If it is the last row, the file is truncated: copy it again"
            return InputError(
                f"has {len(cells)} cells instead of {len(layout.numeric)}",
                path=place,
                value=row,
                mend=mend,
            )
        for column, cell in enumerate(cells if any(cells) else ()):
            if layout.numeric[column] and not is_number(cell, layout.decimal_comma):
                message, mend = why_no_number(cell)
                mend = (
                    mend
                    or "Correct the sample or delete its row: bristle splits the log at the gap"
                )
                return InputError(
                    message, path=f"{place}, column {layout.names[column]!r}", value=cell, mend=mend
                )
    return None


# ``(1436509052.249713) vcan0 044#2A366C2BBA``, as written by -L, and ``vcan0  123   [8]  11 22 ...``, as displayed.
_FRAME = re.compile(
    r"\s*(?:\((?:\d{4}-\d\d-\d\d[ T])?[\d:.]+\)\s+)?\w+\s+(?:(?:RX|TX)\s+(?:[-\w]+\s+)*)?"
    r"[0-9A-Fa-f]{3,8}(?:#[0-9A-Fa-fR]*|##[0-9A-Fa-f]+|\s+\[\d+\](?:\s+[0-9A-Fa-f]{2})*.*)(?:\s+[RT])?\s*"
)


def refuse_frames(lines: Sequence[str], source: Path) -> None:
    """Refuse a log of a CAN bus: the meaning of its bytes is in a separate file."""
    filled = [line for line in lines if line.strip()][:20]
    # Of the lines looked at.
    if filled and sum(bool(_FRAME.fullmatch(line)) for line in filled) >= 0.8 * len(filled):
        raise InputError(
            "is a log of a CAN bus (candump), with raw frames instead of signals",
            path=str(source),
            mend="Decode it with the DBC file of the bus, and export position and effort as CSV or MF4, "
            "for example with cantools or asammdf",
        )
