"""When a log was recorded, where its name or its head says so without a doubt."""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta

__all__ = ["moment_in", "moment_of"]

HEAD = 4096  # bytes in which a file says when it was recorded
_DATE = re.compile(
    r"(?<!\d)(?P<year>(?:19|20)\d\d)(?P<sign>[-_./]?)(?P<month>\d\d)(?P=sign)(?P<day>\d\d)"
    r"(?:[T _-]+(?P<hour>\d\d)(?P<colon>[-:._h]?)(?P<minute>\d\d)(?:(?P=colon)(?P<second>\d\d))?(?:[.,]\d+)?"
    r"(?!-?\d))?(?!\d)"
)
_FILETIME = re.compile(r"[Ss]tart\s?time[^\t;,\n]*[\t;,]\s*(1[0-9]{17})(?!\d)")
_SINCE_1601 = datetime(1601, 1, 1)


def moment_of(names: tuple[str, ...], head: bytes) -> float | None:
    """Return when a log was recorded [s since 1970, as if its clock were UTC]; None where nothing says so alone.

    Parameters
    ----------
    names : tuple of str
        Name of the file, then of the folder that it lies in: the first one with a date tells.
    head : bytes
        What the file begins with, looked at where no name has a date: the times in it must be of one day.

    Examples
    --------
    >>> moment_of(("axis_2026-03-01T06-30-00.csv",), b"") == datetime(2026, 3, 1, 6, 30, tzinfo=UTC).timestamp()
    True
    """
    for name in names:
        moments = list(_moments(name))
        if moments:
            return _seconds(moments[0]) if len(moments) == 1 else None
    text = head[:HEAD].decode("utf-8", "replace")
    started = _FILETIME.search(text)
    if started is not None:
        return _seconds(_SINCE_1601 + timedelta(microseconds=int(started[1]) // 10))
    moments = sorted(_moments(text, timed=True))
    return _seconds(moments[0]) if moments and len({moment.date() for moment in moments}) == 1 else None


def moment_in(text: str) -> float | None:
    """Return the one date in a text, with its time where it has one [s since 1970]; None where it has none or several.

    Examples
    --------
    >>> moment_in("20260301") == moment_in("2026-03-01 00:00"), moment_in("run 7"), moment_in("12345678")
    (True, None, None)
    """
    moments = list(_moments(text))
    return _seconds(moments[0]) if len(moments) == 1 else None


def _moments(text: str, *, timed: bool = False) -> Iterator[datetime]:
    for match in _DATE.finditer(text):
        if timed and match["hour"] is None:
            continue
        try:
            hour, minute, second = (int(match[part] or 0) for part in ("hour", "minute", "second"))
            yield datetime(int(match["year"]), int(match["month"]), int(match["day"]), hour, minute, second)
        except ValueError:  # digits that are no date
            continue


def _seconds(moment: datetime) -> float:
    return moment.replace(tzinfo=UTC).timestamp()
