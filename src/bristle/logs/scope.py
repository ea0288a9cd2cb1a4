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
from bristle.logs.cells import cells_of, numbers_in, why_no_number
from bristle.logs.names import distinct, listed
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, table_of_series

__all__ = ["Head", "head_of", "is_archived", "read_archive", "read_scope"]

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
DELIMITERS = ("\t", ";", ",", "|")
FILETIME = 10**15  # counts of 100 ns since 1601 are larger than this, milliseconds since the start are not
TICKS = 10_000  # of 100 ns in a millisecond
HEAD_LINES = 120


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
    for delimiter in DELIMITERS:
        rows = [cells_of(line, delimiter) for line in lines[:HEAD_LINES]]
        filled = [index for index, cells in enumerate(rows) if any(cells)]
        for place, index in enumerate(filled[:-1]):
            if rows[index][0].lower() != NAME or len(rows[index]) < 2:
                continue
            below = [rows[i][0].lower() for i in filled[place + 1 : place + 1 + len(KEYS)]]
            if below[0] in KEYS or _is_count(below[0]):
                return _head(rows, delimiter, index, filled[place + 1 :], filled[:place])
    return None


def _is_count(cell: str) -> bool:
    return cell.replace(",", ".").replace(".", "", 1).lstrip("-").isdigit()


def _head(rows: list[list[str]], delimiter: str, index: int, below: list[int], above: list[int]) -> Head:
    first, described = below[-1] + 1, {}
    for line in below:
        key = rows[line][0].lower()
        if key not in KEYS:
            first = line
            break
        described[key] = tuple(rows[line])
    facts = {rows[line][0]: " ".join(cell for cell in rows[line][1:] if cell) for line in above if len(rows[line]) > 1}
    names = tuple("" if cell.lower() == NAME else cell for cell in rows[index])
    return Head(delimiter, first, names, described, facts)


def read_scope(lines: Sequence[str], head: Head, request: Request) -> Table:
    """Return the channels of a trace, each with its time."""
    body = [line for line in lines[head.first :] if line.strip() and line.strip().lower() != END]
    cut = lines[-1].strip() != "" and lines[-1].strip().lower() != END
    body = body[:-1] if cut else body
    refuse_larger(len(body) * len(head.names) * NUMBER_BYTES, request.limit, request.source)
    columns = list(zip_longest(*(line.split(head.delimiter) for line in body), fillvalue=""))
    columns = [[cell.strip().strip('"') for cell in column] for column in columns]
    columns = _beside_keys(columns, head)
    places = [place for place, name in enumerate(head.names) if name and place < len(columns)]
    called, notes = distinct(head.names[place] for place in places)
    series, texts = [], {}
    for name, place in zip(called, places, strict=True):
        filled = [cell for cell in columns[place] if cell]
        values = numbers_in(filled, head.delimiter != ",")
        if values is None:
            texts[name] = _no_number(filled, name, head, request.source)
        elif values.size:
            times = _time_of(columns, place, head, values.size, request.source) if request.choice(name) else None
            if times is not None and times.dtype.kind == "i":
                times = (times - _earliest(columns, head)) / TICKS
            about = _about(head, place)
            series.append(Series(name, values if request.choice(name) else None, times, _unit(head, place), about))
    scaled = [name for name, place in zip(called, places, strict=True) if head.of("scalefactor", place) not in ("", "1")]
    if scaled:
        notes.append(f"the ScaleFactor of {', '.join(scaled)} is not applied: the export may have done so")
    if cut:
        notes.append("the file does not end with a line break: its last row may be cut and was left out")
    return table_of_series(series, request.source, "TwinCAT Scope", time_unit="ms", notes=notes, texts=texts, facts=dict(head.facts))


def _beside_keys(columns: list[list[str]], head: Head) -> list[list[str]]:
    """Return the cells below the names: an export without times has none below the keys."""
    named = sum(map(bool, head.names))
    if len(columns) != named or named == len(head.names):
        return columns
    values = iter(columns)
    return [next(values) if name else [""] * len(columns[0]) for name in head.names]


def _time_of(columns: list[list[str]], place: int, head: Head, count: int, source: Path) -> np.ndarray | None:
    """Return the times of a channel in ms, or as counts of 100 ns; None where the file tells none."""
    left = next((before for before in range(place - 1, -1, -1) if not head.names[before]), None)
    cells = [time for time, value in zip(columns[left], columns[place], strict=True) if value] if left is not None else []
    if any(cells):
        if len(cells[0].lstrip("-")) >= len(str(FILETIME)) and cells[0].isdigit():
            return np.array(cells, dtype=np.int64)
        times = numbers_in(cells, head.delimiter != ",")
        if times is None or times.size != count:
            raise InputError(
                "has no time for each of its samples",
                path=f"{source}: column {head.names[place]!r}",
                mend="Export it with a column of time for each channel",
            )
        return times
    period = numbers_in([head.of("sampletime[ms]", place) or "x"], True)
    return None if period is None else period[0] * np.arange(count)


def _earliest(columns: list[list[str]], head: Head) -> int:
    """Return the first time of a trace, as a count of 100 ns."""
    firsts = (next(filter(None, column), "") for column, name in zip(columns, head.names, strict=False) if not name)
    return min(int(first) for first in firsts if first.isdigit())


def _no_number(cells: Sequence[str], name: str, head: Head, source: Path) -> InputError:
    odd = next(cell for cell in cells if numbers_in([cell], head.delimiter != ",") is None)
    message, mend = why_no_number(odd)
    return InputError(message, path=f"{source}: column {name!r}", value=odd, mend=mend)


def _unit(head: Head, place: int) -> str:
    unit = head.of("unit", place)
    return "" if unit.lower() in NO_UNIT else unit.strip("()[]")


def _about(head: Head, place: int) -> str:
    parts = (head.of(key, place) for key in ("symbolname", "symbolcomment", "data-type"))
    return " ".join(part for part in parts if part)


_DATE = r"\d{4}[-/]\d\d[-/]\d\d[T ,;\t]+\d\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?"
_SECONDS = r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
# Name first, or time first; what follows the value is its state.
_NAMED = re.compile(rf'\s*"?([A-Za-z_][\w:.\-/<>\[\]]*)"?[\s,;]+"?({_DATE}|{_SECONDS})"?[\s,;]+({_NUMBER})(?:[\s,;].*)?')
_TIMED = re.compile(rf'\s*"?({_DATE}|{_SECONDS})"?[\s,;]+"?([A-Za-z_][\w:.\-/<>\[\]]*)"?[\s,;]+({_NUMBER})(?:[\s,;].*)?')
LOOKED_AT = 60  # lines
FEWEST = 10
ENOUGH = 0.8  # of the lines looked at
MOST_SIGNALS = 1000


def _pattern_of(lines: Sequence[str]) -> re.Pattern[str] | None:
    filled = [line for line in lines[:LOOKED_AT] if line.strip() and not line.lstrip().startswith("#")]
    for pattern in (_NAMED, _TIMED):
        if len(filled) >= FEWEST and sum(bool(pattern.fullmatch(line)) for line in filled) >= ENOUGH * len(filled):
            return pattern
    return None


def is_archived(lines: Sequence[str]) -> bool:
    """Return whether these lines are values of named signals, one each."""
    return _pattern_of(lines) is not None


def read_archive(lines: Sequence[str], request: Request) -> Table:
    """Return the signals of an archive, each with its own times."""
    refuse_larger(len(lines) * 2 * NUMBER_BYTES, request.limit, request.source)
    pattern = _pattern_of(lines)
    assert pattern is not None
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
        raise InputError(
            f"names {len(signals)} signals", path=str(request.source), allowed=f"up to {MOST_SIGNALS}", mend="Export one column a signal"
        )
    origin = min((_date(times[0]) for times, _ in signals.values() if ":" in times[0]), default=None)
    series = [
        Series(name, np.array(values) if request.choice(name) else None, _seconds(times, origin) if request.choice(name) else None)
        for name, (times, values) in signals.items()
    ]
    notes = [f"{unreadable} lines are no value of a signal and were left out"] if unreadable else []
    return table_of_series(series, request.source, "archive", notes=notes)


def _seconds(times: list[str], origin: datetime | None) -> np.ndarray:
    if origin is None:
        return np.array(times, dtype=float)
    return np.array([(_date(time) - origin).total_seconds() for time in times])


def _date(text: str) -> datetime:
    parts = re.split(r"[T ,;\t]+", text, maxsplit=1)
    return datetime.fromisoformat(f"{parts[0].replace('/', '-')}T{parts[1].replace(',', '.')}")
