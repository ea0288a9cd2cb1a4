"""Text files with more than columns of numbers: dates as stamps, columns with separate times, TwinCAT Scope, archives."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import combinations, product, zip_longest
from pathlib import Path

import numpy as np

from bristle.core import InputError, units
from bristle.core.content import refuse_larger
from bristle.logs.check import SAMPLED
from bristle.logs.clock import LONGEST, SHORTEST, UNIFORM
from bristle.logs.layout import CLOCK, Layout, cells_of, numbers_in, why_no_number, without_comments
from bristle.logs.table import ALL, NUMBER_BYTES, Request, Table, some_of, split_unit
from bristle.logs.tables import Series, note_of_text, table_of_series
from bristle.logs.words import (
    converts,
    distinct,
    is_time,
    listed,
    meaning_of,
    plain_unit,
    unit_in_name,
)

# Digits of a count, and counts per second.
EPOCHS = ((19, 1e9), (17, 1e7), (16, 1e6), (13, 1e3), (0, 1.0))
OFTEN = 0.2  # share of empty cells above which a column has a lower rate, or ended early
_ACT = r"(?:sampl\w*|abtast|scan|log|logging|record|recording|acquisition|daq|trace|aufzeichnungs)"
# Unit -> names of a sample time or rate.
_SAMPLING = {
    "s": re.compile(
        rf"(?:sampl\w*|abtast|scan|cycle|zyklus)[ -]?(?:time|zeit)|{_ACT}[ -]?(?:period\w*|interval\w*|takt|step|cycle)|takt|interval\w*"
        "|t ?sample|delta ?[tx]|dt|ts"
    ),
    "Hz": re.compile(rf"{_ACT}[ -]?(?:rate|freq\w*)|sampling|fs"),
}
_THOUSANDS = re.compile(r"^([1-9]\d{0,2}),(\d{3})(?!\d)")  # or a decimal comma
_FACT = re.compile(
    r"\s*[#%*\"]*\s*([^:=;\t,]{2,60}?)\s*\"?(?:\s*[:=;\t,]\s*\"?\s*|\s+(?=\d[\d.,]*\s*\S+$))(.+?)\s*\"?[;,\t]*\s*"
)


def facts_above(lines: Sequence[str], layout: Layout) -> dict[str, str]:
    """Return the facts above the header of a text file, as names and values."""
    has_names = layout.first and not all(name.startswith("column_") for name in layout.names)
    above = [line for line in lines[: layout.first] if line.strip()][: -1 if has_names else None]
    matches = (_FACT.fullmatch(line[:200]) for line in above)
    between = r"[;\t,]+" if layout.delimiter == "," and not layout.decimal_comma else r"[;\t]+"
    return {match[1].strip(): re.sub(between, " ", match[2]).strip() for match in matches if match}


def units_of_labview(lines: Sequence[str], layout: Layout) -> dict[str, str]:
    """Return the units of a LabVIEW measurement file, which has them in a separate row above the names."""
    row = next(
        (line for line in lines[: layout.first] if line.lower().startswith("y_unit_label")), None
    )
    if row is None:
        return {}
    # Its first cell, above the times, is the label of the row.
    cells = zip(layout.names[1:], cells_of(row, layout.delimiter)[1:], strict=False)
    return {name: unit for name, unit in cells if unit and not name.lower().startswith("x_value")}


def stated_period(facts: Mapping[str, str]) -> float | None:
    """Return the time between samples [s] stated above the columns of a file; None if there is none, or if lines contradict each other."""
    periods = list(stated_periods(facts).values())
    return periods[0] if periods and max(periods) / min(periods) < 1.0 + UNIFORM else None


def stated_periods(facts: Mapping[str, str], *, named: bool = True) -> dict[str, float]:
    """Return the lines above the columns of a file that state a time or rate, unless `named` of sampling, and this time [s]."""
    periods = dict[str, float]()
    for name, text in facts.items():
        key = re.sub(
            r"( [mu]?s)?( k?hz)?$", "", split_unit(name)[0].lower().rstrip(":").replace("_", " ")
        )
        usual = next((unit for unit, names in _SAMPLING.items() if names.fullmatch(key)), "")
        readings = dict.fromkeys((text, _THOUSANDS.sub(r"\1\2", text)))
        for reading, (target, power) in product(readings, (("s", 1), ("Hz", -1))):
            amount = amount_in(name, reading, usual)
            if (
                amount is None
                or not converts(amount[1], target)
                or not SHORTEST <= amount[0] * units.factor(amount[1], target) <= LONGEST
            ):
                continue
            period = (amount[0] * units.factor(amount[1], target)) ** power
            is_sure, is_plausible = (
                bool(usual) and len(readings) == 1,
                SAMPLED[0] <= period <= SAMPLED[1],
            )
            if is_sure or (is_plausible and not (named and not usual)):
                periods[f"{name}: {reading}"] = period
    return periods


def amount_in(name: str, text: str, usual: str = "") -> tuple[float, str] | None:
    """Return number and unit of a fact such as ``Rated torque [Nm]: 2,4``; None if it has no number."""
    match = re.match(r"([+-]?\d[\d.,]*(?:[eE][+-]?\d+)?)\s*([^\d\s]\S*(?: per \w+)?)?", text)
    if match is None:
        return None
    unit = plain_unit(match[2] or split_unit(name)[1] or unit_in_name(name) or usual)
    try:
        return float(match[1].replace(",", ".")), units.split(f"1 {unit}")[1] if unit else ""
    except ValueError:
        return None


def stamps_in(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray]:
    """Return the columns of dates, times of day and counts since an epoch, as seconds from the first row."""
    begin = re.search(rb"[^\n]*\S[^\n]*", body)
    first = (
        cells_of(without_comments(begin[0].decode(encoding, "replace")), layout.delimiter)
        if begin
        else []
    )
    lines, stamps = list[str](), dict[int, np.ndarray]()
    for index, (cell, numeric, name) in enumerate(
        zip(first, layout.numeric, layout.names, strict=False)
    ):
        is_date = not numeric and (CLOCK.fullmatch(cell) or _GERMAN.fullmatch(cell))
        # Counts since an epoch have at least 10 digits.
        if not is_date and not (
            numeric and is_time(name) and len(cell.replace(",", ".").partition(".")[0]) >= 10
        ):
            continue
        lines = lines or [
            line for line in body.decode(encoding, "replace").split("\n") if line.strip()
        ]
        try:
            cells = [cells_of(line, layout.delimiter)[index].replace(",", ".") for line in lines]
            seconds = _of_dates(cells) if is_date else _of_counts(cells)
        except (ValueError, IndexError):
            continue
        if np.any(np.diff(seconds) > 0) or not is_date:  # a constant date is no stamp
            stamps[index] = seconds
    return stamps


_GERMAN = re.compile(r"(\d\d?)\.(\d\d?)\.(\d{4})[ T](\d\d?:\d\d:\d\d(?:[.,]\d+)?)")


def _of_dates(cells: Sequence[str]) -> np.ndarray:
    """Return dates, or times of day, as seconds from the first."""
    moments = [_moment(cell) for cell in cells]
    seconds = np.array([(moment - moments[0]).total_seconds() for moment in moments])
    # A time of day restarts at midnight.
    restarts = (np.diff(seconds) < -43200.0) & (":" in cells[0][:3])
    return seconds + 86400.0 * np.cumsum(np.append(0.0, restarts))


def _moment(text: str) -> datetime:
    if german := _GERMAN.fullmatch(text):
        text = f"{german[3]}-{int(german[2]):02d}-{int(german[1]):02d} {german[4]}"
    *date, clock = re.split(r"[T ,;\t]+", text.replace("/", "-").removesuffix("Z"), maxsplit=1)
    day = "".join(date) or "2000-01-01"
    return datetime.fromisoformat(f"{day}T{'0' * (clock[1:2] == ':')}{clock.replace(',', '.')}")


def _of_counts(cells: Sequence[str]) -> np.ndarray:
    """Return counts of time since an epoch; a float would lose their last digits."""
    parts = [cell.partition(".") for cell in cells]
    counts = np.array([int(left) for left, _, _ in parts], dtype=np.int64)
    fractions = np.array([float(f"0.{right or 0}") for _, _, right in parts])
    if counts.min() < 0:
        raise ValueError("no count")
    scale = next(size for least, size in EPOCHS if len(parts[0][0]) >= least)
    return np.round((counts - counts[0]) / scale + (fractions - fractions[0]) / scale, 9)


def words_in(body: bytes, layout: Layout, encoding: str) -> dict[int, list[str]]:
    """Return the cells of the columns without numbers in the first rows; cells at the end of a row may be missing."""
    places = [place for place, numeric in enumerate(layout.numeric) if not numeric]
    lines = without_comments(body.decode(encoding, "replace")).split("\n") if places else []
    rows = [cells for line in lines if any(cells := cells_of(line, layout.delimiter))]
    return {place: ["".join(row[place : place + 1]) for row in rows] for place in places}


def partly_empty(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray] | None:
    """Return all columns of numbers, NaN for empty cells and short rows; None if a column has other text."""
    text = without_comments(body.decode(encoding, "replace"))
    rows = [
        cells
        for line in text.split("\n")
        if line.strip() and any(cells := cells_of(line, layout.delimiter))
    ]
    columns = {}
    if max(map(len, rows), default=0) > len(layout.numeric):
        return None
    for index in np.flatnonzero(layout.numeric).tolist():
        cells = ((row[index] if index < len(row) else "") or "nan" for row in rows)
        try:
            columns[index] = np.array(
                [cell.replace(",", ".") if layout.decimal_comma else cell for cell in cells],
                dtype=float,
            )
        except ValueError:
            return None
    is_empty = any(np.isnan(values).any() for values in columns.values())
    if any(map(is_slow, columns.values())) or (
        is_empty and not any(map(lacks_inside, columns.values()))
    ):
        return columns
    return None


def lacks_inside(values: np.ndarray) -> bool:
    """Return whether a column lacks samples between its first and its last one."""
    filled = np.flatnonzero(~np.isnan(values))
    return bool(filled.size) and int(filled[-1] - filled[0]) >= filled.size


def is_slow(values: np.ndarray) -> bool:
    """Return whether a column was recorded at a lower rate: a few missing samples are reported instead."""
    return lacks_inside(values) and bool(np.mean(np.isnan(values)) >= OFTEN)


def with_own_times(
    columns: dict[int, np.ndarray], layout: Layout, request: Request, notes: Sequence[str]
) -> Table | None:
    """Return the table of a file with several time columns or shorter columns; None if all columns share one time."""
    clocks = [index for index, values in columns.items() if _is_clock(layout.names[index], values)]
    several = len(clocks) > 1
    if (
        not clocks
        or not (several or any(map(is_slow, columns.values())))
        or (several and clocks[0] != min(columns))
    ):
        return None
    unit = layout.units[clocks[0]] or unit_in_name(layout.names[clocks[0]])
    series = []
    for index, values in columns.items():
        if index in clocks:
            continue
        times = columns[max((clock for clock in clocks if clock < index), default=clocks[0])]
        filled = np.isfinite(times)
        if several or is_slow(values):
            filled &= np.isfinite(values)
        samples = values[filled] if request.choice(layout.names[index], index + 1) else None
        series.append(Series(layout.names[index], samples, times[filled], layout.units[index]))
    table = table_of_series(
        series, request._replace(choice=ALL), "text", time_unit=unit, notes=notes
    )
    return replace(table, numbers={f"column_{i + 1}": layout.names[i] for i in columns})


def names_beside_times(names: Sequence[str]) -> tuple[str, ...]:
    """Return names for columns whose names are above their time columns."""
    pairs = list(zip(names[::2], names[1::2], strict=False))
    nameless = [name.startswith("column_") for name in names]
    if len(names) % 2 or len(pairs) < 2 or any(nameless[::2]) or not all(nameless[1::2]):
        return tuple(names)
    return tuple(
        name for k, (above, _) in enumerate(pairs) for name in (f"column_{2 * k + 1}", above)
    )


def _is_clock(name: str, values: np.ndarray) -> bool:
    """Return whether a column is a time: by its name, or without a name if it rises evenly."""
    finite = values[np.isfinite(values)]
    steps = np.diff(finite)
    if finite.size < 3 or not np.all(steps >= 0) or not np.any(steps > 0):
        return False
    if is_time(name) or name.lower() in ("x_value", "name") or name.lower().startswith("x_value_"):
        return True
    nameless = name.startswith("column_") or re.fullmatch(r"name_\d+", name.lower()) is not None
    return nameless and bool(np.ptp(steps) <= 0.02 * np.median(steps) + 1e-12)


NAME = "name"
# Possible first cells of the rows below the names; the export options decide.
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
    """Head of a trace, above its numbers."""

    delimiter: str
    first: int
    names: tuple[str, ...]
    rows: Mapping[str, Sequence[str]] = field(default_factory=dict)
    facts: Mapping[str, str] = field(default_factory=dict)

    def of(self, key: str, column: int) -> str:
        """Return the cell of a column in a row of the head; empty if there is no such row."""
        cells = self.rows.get(key, ())
        return cells[column] if column < len(cells) else ""


def head_of(lines: Sequence[str]) -> Head | None:
    """Return the head of a trace of TwinCAT Scope; None if the lines are something else."""
    for delimiter in ("\t", ";", ",", "|"):
        rows = [cells_of(line, delimiter) for line in lines[:120]]
        filled = [index for index, cells in enumerate(rows) if any(cells)]
        for place, index in enumerate(filled[:-1]):
            below = rows[filled[place + 1]][0].lower()
            is_count = below.replace(",", ".").replace(".", "", 1).lstrip("-").isdigit()
            if (
                rows[index][0].lower() == NAME
                and len(rows[index]) > 1
                and (below in KEYS or is_count)
            ):
                return _head(rows, delimiter, index, filled[place + 1 :], filled[:place])
    return None


def _head(
    rows: list[list[str]], delimiter: str, index: int, below: list[int], above: list[int]
) -> Head:
    first, described = below[-1] + 1, {}
    for line in below:
        key = rows[line][0].lower()
        if key not in KEYS:
            first = line
            break
        described[key] = tuple(rows[line])
    facts = {
        rows[line][0]: " ".join(cell for cell in rows[line][1:] if cell)
        for line in above
        if len(rows[line]) > 1
    }
    return Head(
        delimiter,
        first,
        tuple("" if cell.lower() == NAME else cell for cell in rows[index]),
        described,
        facts,
    )


def read_scope(lines: Sequence[str], head: Head, request: Request) -> Table:
    """Return the channels of a trace, each with its time."""
    body = [line for line in lines[head.first :] if line.strip() and line.strip().lower() != END]
    cut = lines[-1].strip() != "" and lines[-1].strip().lower() != END
    body = body[:-1] if cut else body
    refuse_larger(len(body) * len(head.names) * NUMBER_BYTES, request.limit, request.source)
    columns = [
        [cell.strip().strip('"') for cell in column]
        for column in zip_longest(*(line.split(head.delimiter) for line in body), fillvalue="")
    ]
    # Without times, an export has no cells below the keys.
    if len(columns) == sum(map(bool, head.names)) < len(head.names):
        values = iter(columns)
        columns = [next(values) if name else [""] * len(columns[0]) for name in head.names]
    firsts = (
        next(filter(None, column), "")
        for column, name in zip(columns, head.names, strict=False)
        if not name
    )
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
            texts[name] = InputError(
                message, path=f"{request.source}: column {name!r}", value=odd, mend=mend
            )
        elif values.size:
            read = (
                (values, _times_of(columns, place, head, earliest, request.source))
                if request.choice(name)
                else (None, None)
            )
            unit = head.of("unit", place)
            about = filter(
                None, (head.of(key, place) for key in ("symbolname", "symbolcomment", "data-type"))
            )
            series.append(
                Series(
                    name,
                    *read,
                    "" if unit.lower() in NO_UNIT else unit.strip("()[]"),
                    " ".join(about),
                )
            )
    scaled = [
        name
        for name, place in zip(called, places, strict=True)
        if head.of("scalefactor", place) not in ("", "1")
    ]
    if scaled:
        notes.append(
            f"the ScaleFactor of {', '.join(scaled)} is not applied, because the export may have applied it already"
        )
    if cut:
        notes.append(
            "the file does not end with a line break: bristle ignores its last row, which may be incomplete"
        )
    return table_of_series(
        series,
        request,
        "TwinCAT Scope",
        time_unit="ms",
        notes=notes,
        texts=texts,
        facts=dict(head.facts),
    )


def _times_of(
    columns: list[list[str]], place: int, head: Head, earliest: int, source: Path
) -> np.ndarray | None:
    """Return the times of a channel [ms]; None if the file has none."""
    left = next((before for before in range(place - 1, -1, -1) if not head.names[before]), None)
    cells = (
        [time for time, value in zip(columns[left], columns[place], strict=True) if value]
        if left is not None
        else []
    )
    if not any(cells):
        period = numbers_in([head.of("sampletime[ms]", place) or "x"], True)
        return None if period is None else period[0] * np.arange(sum(map(bool, columns[place])))
    # Counts of 100 ns since 1601; milliseconds since the start have fewer digits.
    if len(cells[0]) >= 16 and cells[0].isdigit():
        return (np.array(cells, dtype=np.int64) - earliest) / 1e4
    times = numbers_in(cells, head.delimiter != ",")
    if times is None:
        raise InputError(
            "has no time for each of its samples",
            path=f"{source}: column {head.names[place]!r}",
            mend="Export the trace with a column of time for each channel",
        )
    return times


_DATE = r"\d{4}[-/]\d\d[-/]\d\d[T ,;\t]+\d\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?"
_SECONDS = r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_NAMED = re.compile(
    rf'\s*"?([A-Za-z_][\w:.\-/<>\[\]]*)"?[\s,;]+"?({_DATE}|{_SECONDS})"?[\s,;]+({_NUMBER})(?:[\s,;]+(\D*))?'
)
MOST_SIGNALS = 1000


def is_archive(lines: Sequence[str]) -> bool:
    """Return whether lines without a header hold the name of a signal, a time, one value and its state."""
    filled = [line for line in lines[:60] if line.strip() and not line.lstrip().startswith("#")]
    matches = sum(bool(_NAMED.fullmatch(line)) for line in filled)
    # Of the lines looked at.
    return len(filled) >= 10 and bool(_NAMED.fullmatch(filled[0])) and matches >= 0.8 * len(filled)


def read_archive(lines: Sequence[str], request: Request) -> Table:
    """Return the signals of an archive, each with separate times."""
    refuse_larger(len(lines) * 2 * NUMBER_BYTES, request.limit, request.source)
    matches = list(filter(None, map(_NAMED.fullmatch, lines)))
    names = {match[1]: match[2] for match in reversed(matches)}  # with their first stamps
    if len(names) > MOST_SIGNALS:
        raise InputError(
            f"names {len(names)} signals",
            path=str(request.source),
            allowed=f"up to {MOST_SIGNALS}",
            mend="Export the log as a table with one column per signal",
        )
    # Reading dates takes most of the time.
    chosen = [match for match in matches if request.choice(match[1])]
    stamps = [*names.values(), *(match[2] for match in chosen)]
    times = _of_dates(stamps) if ":" in stamps[0] else np.array(stamps, dtype=float)
    times -= times[: len(names)].min() * (":" in stamps[0])
    values = np.array([float(match[3].replace(",", ".")) for match in chosen])
    series = [
        *_series_by_name([match[1] for match in chosen], times[len(names) :], {"": (values, "")})
    ]
    series += [Series(name, None) for name in names if not request.choice(name)]
    unreadable = sum(
        bool(line.strip()) and not line.lstrip().startswith("#") for line in lines
    ) - len(matches)
    notes = [f"bristle ignores {unreadable} lines without a value of a signal"] * (unreadable > 0)
    notes += ["bristle ignores the text behind the values"] * any(match[4] for match in matches)
    return table_of_series(series, request, "archive", notes=notes)


def way_within(words: Sequence[str], times: np.ndarray, columns: Sequence[np.ndarray]) -> float:
    """Return the share of the way of all values within the rows of one word; infinity unless words name the signal of each row."""
    place = {word: k for k, word in enumerate(dict.fromkeys(words))}
    codes = np.array([place[word] for word in words])
    order, changes = np.argsort(codes, kind="stable"), np.count_nonzero(np.diff(codes))
    inside = np.diff(codes[order]) == 0
    if not changes or len(place) > MOST_SIGNALS:
        return np.inf
    ways = [
        (np.diff(values[order])[inside], np.diff(values))
        for values in columns
        if np.any(np.diff(values) < 0.0)
    ]
    shares = [
        float(np.nansum(np.abs(within)) / np.nansum(np.abs(over))) for within, over in ways
    ] or [1.0]
    # Several signals have the same stamps, or the stamps of one start again behind those of another; or values alternate
    # between signals, so that their way over all rows is far longer than within the rows of each word.
    is_again = (
        np.mean(np.diff(times[order])[inside] > 0.0) > 0.99
        and np.sum(np.diff(times) <= 0.0) >= 0.4 * changes
    )
    return (
        float(np.mean(shares)) if is_again or (min(shares) < 0.5 and max(shares) < 1.2) else np.inf
    )


def signals_of_rows(
    words: Mapping[int, list[str]],
    dates: Mapping[int, np.ndarray],
    columns: Mapping[int, np.ndarray],
    layout: Layout,
    request: Request,
    notes: Sequence[str],
) -> Table | None:
    """Return the signals of a table in long form, whose rows name their joint or signal; None if it is a table of columns."""
    clock = next(
        (i for i in (*dates, *columns) if i in dates or is_time(layout.names[i])), min(columns)
    )
    times = {**columns, **dates}[clock]
    values = {
        layout.names[i]: (column, layout.units[i]) for i, column in columns.items() if i != clock
    }
    # As few columns of words as possible, with the fewest names: a word of a row can depend on its joint.
    filled = [i for i, column in words.items() if all(column)]
    keys = [key for size in range(1, len(filled) + 1) for key in combinations(filled, size)]
    named = {key: list(map(" ".join, zip(*(words[i] for i in key), strict=True))) for key in keys}
    shares = {
        key: way_within(named[key], times, [column for column, _ in values.values()])
        for key in keys
    }
    least = min(shares.values(), default=np.inf)
    if least == np.inf:
        return None
    key = min(
        (key for key in keys if shares[key] <= 2.0 * least),
        key=lambda key: (len(key), len(set(named[key]))),
    )
    naming, signals = (
        " and column ".join(layout.names[i] for i in key),
        some_of(dict.fromkeys(named[key])),
    )
    notes = [
        *layout.notes,
        *notes,
        f"column {naming} names the signal of each row: bristle splits the table into {signals}",
    ]
    notes += note_of_text([layout.names[i] for i in words if i not in key])
    unit = "s" if clock in dates else layout.units[clock] or unit_in_name(layout.names[clock])
    return table_of_series(
        _series_by_name(named[key], times, values), request, "text", time_unit=unit, notes=notes
    )


def _series_by_name(
    words: Sequence[str], times: np.ndarray, columns: Mapping[str, tuple[np.ndarray, str]]
) -> Iterator[Series]:
    """Yield the columns of a table in long form, given with their units, as signals of each name."""
    roles = {meaning_of(name).role for name in columns} - {"", "time", "status"}
    of_row = np.array(words, dtype=object)
    for word in dict.fromkeys(words):
        rows = of_row == word
        for name, (values, unit) in columns.items():
            called = f"{word}.{name}" if roles or len(columns) > 1 else word
            filled = rows & np.isfinite(values)
            yield Series(
                called, values[filled], times[filled], unit, joint=word if len(roles) > 1 else ""
            )
