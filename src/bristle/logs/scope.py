"""Traces of TwinCAT Scope, exported as text: every channel with a column of its time, or groups of them with one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import zip_longest
from pathlib import Path

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.layout import cells_of, numbers_in, why_no_number
from bristle.logs.names import distinct, listed
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, table_of_series

NAME = "name"
# What stands in the first column of the rows below the names, as far as the export was asked for them.
KEYS = frozenset(
    listed(
        "bitmask | data-type | indexgroup | indexoffset | netid | offset | port | sampletime[ms] | scalefactor | symbolbased | "
        "symbolcomment | symbolname | unit | unit offset | unit scalefactor | variablesize"
    )
)
NO_UNIT = ("", "(none)", "none", "-", "1")
END = "eof"


@dataclass(frozen=True)
class Head:
    """What stands above the numbers of a trace."""

    delimiter: str
    first: int
    names: tuple[str, ...]
    rows: Mapping[str, Sequence[str]] = field(default_factory=dict)
    facts: Mapping[str, str] = field(default_factory=dict)

    def of(self, key: str, column: int) -> str:
        """Return what a row says of a column; empty where there is no such row."""
        cells = self.rows.get(key, ())
        return cells[column] if column < len(cells) else ""


def head_of(lines: Sequence[str]) -> Head | None:
    """Return the head of a trace of TwinCAT Scope; None where these lines are something else."""
    for delimiter in ("\t", ";", ",", "|"):
        rows = [cells_of(line, delimiter) for line in lines[:120]]
        filled = [index for index, cells in enumerate(rows) if any(cells)]
        for place, index in enumerate(filled[:-1]):
            below = rows[filled[place + 1]][0].lower()
            is_count = below.replace(",", ".").replace(".", "", 1).lstrip("-").isdigit()
            if rows[index][0].lower() == NAME and len(rows[index]) > 1 and (below in KEYS or is_count):
                return _head(rows, delimiter, index, filled[place + 1 :], filled[:place])
    return None


def _head(rows: list[list[str]], delimiter: str, index: int, below: list[int], above: list[int]) -> Head:
    first, described = below[-1] + 1, {}
    for line in below:
        key = rows[line][0].lower()
        if key not in KEYS:
            first = line
            break
        described[key] = tuple(rows[line])
    facts = {rows[line][0]: " ".join(cell for cell in rows[line][1:] if cell) for line in above if len(rows[line]) > 1}
    return Head(delimiter, first, tuple("" if cell.lower() == NAME else cell for cell in rows[index]), described, facts)


def read_scope(lines: Sequence[str], head: Head, request: Request) -> Table:
    """Return the channels of a trace, each with its time."""
    body = [line for line in lines[head.first :] if line.strip() and line.strip().lower() != END]
    cut = lines[-1].strip() != "" and lines[-1].strip().lower() != END
    body = body[:-1] if cut else body
    refuse_larger(len(body) * len(head.names) * NUMBER_BYTES, request.limit, request.source)
    columns = [
        [cell.strip().strip('"') for cell in column] for column in zip_longest(*(line.split(head.delimiter) for line in body), fillvalue="")
    ]
    if len(columns) == sum(map(bool, head.names)) < len(head.names):  # an export without times has no cells below the keys
        values = iter(columns)
        columns = [next(values) if name else [""] * len(columns[0]) for name in head.names]
    firsts = (next(filter(None, column), "") for column, name in zip(columns, head.names, strict=False) if not name)
    earliest = min((int(first) for first in firsts if first.isdigit()), default=0)
    places = [place for place, name in enumerate(head.names) if name and place < len(columns)]
    called, notes = distinct(head.names[place] for place in places)
    series, texts = [], {}
    for name, place in zip(called, places, strict=True):
        filled = [cell for cell in columns[place] if cell]
        values = numbers_in(filled, head.delimiter != ",")
        if values is None:
            odd = next(cell for cell in filled if numbers_in([cell], head.delimiter != ",") is None)
            message, mend = why_no_number(odd)
            texts[name] = InputError(message, path=f"{request.source}: column {name!r}", value=odd, mend=mend)
        elif values.size:
            read = (values, _times_of(columns, place, head, earliest, request.source)) if request.choice(name) else (None, None)
            unit = head.of("unit", place)
            about = filter(None, (head.of(key, place) for key in ("symbolname", "symbolcomment", "data-type")))
            series.append(Series(name, *read, "" if unit.lower() in NO_UNIT else unit.strip("()[]"), " ".join(about)))
    scaled = [name for name, place in zip(called, places, strict=True) if head.of("scalefactor", place) not in ("", "1")]
    if scaled:
        notes.append(f"the ScaleFactor of {', '.join(scaled)} is not applied: the export may have done so")
    if cut:
        notes.append("the file does not end with a line break: its last row may be cut and was left out")
    return table_of_series(series, request, "TwinCAT Scope", time_unit="ms", notes=notes, texts=texts, facts=dict(head.facts))


def _times_of(columns: list[list[str]], place: int, head: Head, earliest: int, source: Path) -> np.ndarray | None:
    """Return the times of a channel [ms]; None where the file tells none."""
    left = next((before for before in range(place - 1, -1, -1) if not head.names[before]), None)
    cells = [time for time, value in zip(columns[left], columns[place], strict=True) if value] if left is not None else []
    if not any(cells):
        period = numbers_in([head.of("sampletime[ms]", place) or "x"], True)
        return None if period is None else period[0] * np.arange(sum(map(bool, columns[place])))
    if len(cells[0]) >= 16 and cells[0].isdigit():  # of counts of 100 ns since 1601; milliseconds since the start have fewer
        return (np.array(cells, dtype=np.int64) - earliest) / 1e4
    times = numbers_in(cells, head.delimiter != ",")
    if times is None:
        place_told, mend = f"{source}: column {head.names[place]!r}", "Export it with a column of time for each channel"
        raise InputError("has no time for each of its samples", path=place_told, mend=mend)
    return times


_DATE = r"\d{4}[-/]\d\d[-/]\d\d[T ,;\t]+\d\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?"
_SECONDS = r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
# Name first, or time first; what follows the value is its state.
_NAMED = re.compile(rf'\s*"?([A-Za-z_][\w:.\-/<>\[\]]*)"?[\s,;]+"?({_DATE}|{_SECONDS})"?[\s,;]+({_NUMBER})(?:[\s,;].*)?')
_TIMED = re.compile(rf'\s*"?({_DATE}|{_SECONDS})"?[\s,;]+"?([A-Za-z_][\w:.\-/<>\[\]]*)"?[\s,;]+({_NUMBER})(?:[\s,;].*)?')
MOST_SIGNALS = 1000


def pattern_of(lines: Sequence[str]) -> re.Pattern[str] | None:
    """Return the pattern of lines that are values of named signals, one each; None where they are something else."""
    filled = [line for line in lines[:60] if line.strip() and not line.lstrip().startswith("#")]
    for pattern in (_NAMED, _TIMED):
        if len(filled) >= 10 and sum(bool(pattern.fullmatch(line)) for line in filled) >= 0.8 * len(filled):  # of the lines looked at
            return pattern
    return None


def read_archive(lines: Sequence[str], pattern: re.Pattern[str], request: Request) -> Table:
    """Return the signals of an archive, each with its own times."""
    refuse_larger(len(lines) * 2 * NUMBER_BYTES, request.limit, request.source)
    name_at, time_at = (1, 2) if pattern is _NAMED else (2, 1)
    signals: dict[str, tuple[list[str], list[float]]] = {}
    unreadable = 0
    for line in lines:
        match = pattern.fullmatch(line)
        if match is None:
            unreadable += bool(line.strip()) and not line.lstrip().startswith("#")
            continue
        times, values = signals.setdefault(match[name_at], ([], []))
        times.append(match[time_at])
        values.append(float(match[3].replace(",", ".")))
    if len(signals) > MOST_SIGNALS:
        allowed, mend = f"up to {MOST_SIGNALS}", "Export one column a signal"
        raise InputError(f"names {len(signals)} signals", path=str(request.source), allowed=allowed, mend=mend)
    origin = min((_date(times[0]) for times, _ in signals.values() if ":" in times[0]), default=None)
    series = []
    for name, (times, values) in signals.items():
        stamps = times if origin is None else [(_date(time) - origin).total_seconds() for time in times]
        series.append(Series(name, np.array(values), np.array(stamps, dtype=float)))
    notes = [f"{unreadable} lines are no value of a signal and were left out"] if unreadable else []
    return table_of_series(series, request, "archive", notes=notes)


def _date(text: str) -> datetime:
    parts = re.split(r"[T ,;\t]+", text, maxsplit=1)
    return datetime.fromisoformat(f"{parts[0].replace('/', '-')}T{parts[1].replace(',', '.')}")
