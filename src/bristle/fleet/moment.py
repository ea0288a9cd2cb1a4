"""When a log was recorded, where its name or its head says so without a doubt."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta

__all__ = ["moment_of"]

NOON = 12
HEAD = 4096  # bytes in which a file says when it was recorded
_HALF = r"[ _-]?[AaPp]\.?[Mm](?![A-Za-z])"  # of the day
_TIME = (
    rf"(?:[T _-]+(?P<hour>\d\d|\d(?=[-:._h]\d\d(?:[-:._]\d\d)?{_HALF}))(?P<colon>[-:._h]?)(?P<minute>\d\d)"
    rf"(?:(?P=colon)(?P<second>\d\d))?(?:[.,]\d+)?(?P<half>{_HALF})?(?!-?\d))?(?!\d)"
)
_YEAR_FIRST = re.compile(rf"(?<!\d)(?P<year>(?:19|20)\d\d)(?P<sign>[-_./]?)(?P<month>\d\d)(?P=sign)(?P<day>\d\d){_TIME}")
# Day and month in either order, before the year: told where only one order is a date.
_YEAR_LAST = re.compile(
    r"(?<!\d)(?<!\d{4}[-_./])(?P<first>\d\d?)(?P<sign>[-_./])(?P<then>\d\d?)(?P=sign)(?P<year>(?:19|20)\d\d)"
    rf"(?![-_.]\d\d[-_.]\d\dT\d){_TIME}"
)
_FILETIME = re.compile(r"[Ss]tart\s?time[^\t;,\n]*[\t;,]\s*(1[0-9]{17})(?!\d)")
_SINCE_1601 = datetime(1601, 1, 1)


def moment_of(names: tuple[str, ...], head: bytes) -> float | None:
    """Return when a log was recorded [s since 1970, as if its clock were UTC]; None where nothing says so alone.

    Examples
    --------
    >>> moment_of(("axis_2026-03-01T06-30-00.csv",), b"") == datetime(2026, 3, 1, 6, 30, tzinfo=UTC).timestamp()
    True
    """
    for name in names:
        moments = list(_moments(name))
        if moments:
            return _only(moments)
    text = head[:HEAD].decode("utf-8", "replace")
    started = _FILETIME.search(text)
    if started is not None:
        return _seconds(_SINCE_1601 + timedelta(microseconds=int(started[1]) // 10))
    moments = list(_moments(text, timed=True))
    days = {moment and moment.date() for moment in moments}
    return _only([min(filter(None, moments))]) if len(days) == 1 and None not in days else None


def _only(moments: Sequence[datetime | None]) -> float | None:
    """Return the one moment there is."""
    return _seconds(moments[0]) if len(moments) == 1 and moments[0] else None


def _moments(text: str, *, timed: bool = False) -> Iterator[datetime | None]:
    """Yield each date in a text; None for one of which nothing tells which number is the day, which the month."""
    moments, years = [], []
    for match in _YEAR_LAST.finditer(text):
        orders = ((match["first"], match["then"]), (match["then"], match["first"]))
        dates = {date for month, day in orders if (date := _date(match, month, day))}
        if dates:
            moments.append((match, _at_its_time(dates.pop(), match) if len(dates) == 1 else None))
            years.append(match.start("year"))
    for match in _YEAR_FIRST.finditer(text):
        date = _date(match, match["month"], match["day"])
        if date and match.start() not in years and (moment := _at_its_time(date, match)):
            moments.append((match, moment))
    yield from (moment for match, moment in moments if not timed or match["hour"])


def _date(match: re.Match[str], month: str, day: str) -> datetime | None:
    try:
        return datetime(int(match["year"]), int(month), int(day))
    except ValueError:  # digits that are no date
        return None


def _at_its_time(date: datetime, match: re.Match[str]) -> datetime | None:
    """Return a date with the time behind it; None where that is none."""
    hour, minute, second = (int(match[part] or 0) for part in ("hour", "minute", "second"))
    if match["half"]:
        if not 1 <= hour <= NOON:
            return None
        hour = hour % NOON + (NOON if "p" in match["half"].lower() else 0)
    try:
        return date.replace(hour=hour, minute=minute, second=second)
    except ValueError:
        return None


def _seconds(moment: datetime) -> float:
    return moment.replace(tzinfo=UTC).timestamp()
