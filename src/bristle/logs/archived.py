"""Lines of one value each: the name of a signal, when it was taken, and its value, as archivers of EPICS write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.own_times import Series, table_of_series
from bristle.logs.request import Request
from bristle.logs.table import Table

__all__ = ["is_archived", "read"]

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
NUMBER_BYTES = 16


def _pattern_of(lines: Sequence[str]) -> re.Pattern[str] | None:
    filled = [line for line in lines[:LOOKED_AT] if line.strip() and not line.lstrip().startswith("#")]
    for pattern in (_NAMED, _TIMED):
        if len(filled) >= FEWEST and sum(bool(pattern.fullmatch(line)) for line in filled) >= ENOUGH * len(filled):
            return pattern
    return None


def is_archived(lines: Sequence[str]) -> bool:
    """Return whether these lines are values of named signals, one each."""
    return _pattern_of(lines) is not None


def read(lines: Sequence[str], request: Request) -> Table:
    """Return the signals of an archive, each with its own times."""
    refuse_larger(len(lines) * NUMBER_BYTES, request.limit, request.source)
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
