"""Logs in JSON: a sequence of records, columns by name, or signals with their values."""

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError, located
from bristle.logs.formats import LogFormat
from bristle.logs.table import Request, Table
from bristle.logs.tables import Series, flattened, no_such_table, note_of_text, table_of_series
from bristle.logs.words import is_time, names_and_units, unit_of_time

DEEPEST = 8
MOST_NAMES, MOST_CELLS = 20_000, 20_000_000  # of records
WIDE = 1000
STARTS = tuple(sign.encode() for sign in '"{[}]-0123456789')
FEWEST = 2
NAMES, VALUES, UNITS = (
    ("name", "signal", "channel", "id", "label"),
    ("values", "data", "samples", "y"),
    ("unit", "units"),
)
MEND = 'Save a list of records, such as [{"t": 0.0, "position": 0.1}, …] (orient="records" of pandas), or a dictionary of columns'


def recognises(head: bytes, suffix: str) -> bool:
    """Return whether text begins like JSON, and not with a section name in brackets."""
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    return text[:1] in (b"{", b"[") and text[1:].lstrip()[:1] in STARTS


def read(data: bytes, request: Request) -> Table:
    """Return the columns of a JSON file."""
    content, source = _parsed(data, request.source), request.source
    with located(source):
        tables = {path: table for path, table in _tables(content, "", 0) if table[0]}
    if not tables:
        raise InputError("holds no records and no columns of numbers", path=str(source), mend=MEND)
    name = request.table
    if name not in tables:
        if name is not None and len(tables) > 1:
            raise no_such_table(name, list(tables), source)
        name = max(tables, key=lambda table: max(map(len, tables[table][0].values())))
    facts = dict(flattened(content, (Mapping,))) if isinstance(content, dict) else {}
    remarks = {key: value for key, value in facts.items() if isinstance(value, str)}
    constants = {key: float(value) for key, value in facts.items() if type(value) in (int, float)}
    return _table(*tables[name], request, remarks, constants)


def _parsed(data: bytes, source: Path) -> Any:
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    try:
        return json.loads(text)
    except RecursionError:
        raise InputError(
            "has lists that are nested too deeply", path=str(source), mend=MEND
        ) from None
    except json.JSONDecodeError as error:
        lines = [line for line in text.splitlines() if line.strip()]
        records: list[dict[str, Any]] = []  # one per line; the last line of a recording may be cut
        with suppress(json.JSONDecodeError, RecursionError):
            for line in lines:
                record = json.loads(line)
                if not isinstance(record, dict):
                    break
                records.append(record)
        if len(records) >= max(FEWEST, len(lines) - 1):
            return records
        raise InputError(
            f"is truncated or not JSON: {error.msg} in line {error.lineno}",
            path=str(source),
            mend="Copy or save it again",
        ) from None


def _tables(
    node: Any, path: str, depth: int
) -> Iterator[tuple[str, tuple[dict[str, list[Any]], dict[str, str]]]]:
    """Yield possible tables, with name, columns and units."""
    if isinstance(node, list) and len(node) >= FEWEST and depth <= DEEPEST:
        if all(isinstance(record, dict) for record in node):
            yield path, _of_records(node)
        elif all(isinstance(row, list) and row for row in node):
            width = min(len(row) for row in node)
            yield path, ({f"column_{k + 1}": [row[k] for row in node] for k in range(width)}, {})
    if not isinstance(node, dict) or depth > DEEPEST:
        return
    rows = node.get("data")
    if (
        isinstance(node.get("columns"), list)
        and isinstance(rows, list)
        and rows
        and all(isinstance(row, list) for row in rows)
    ):
        raise InputError(
            'holds a data frame with separate lists of columns and rows (orient="split")',
            path=path,
            mend=MEND,
        )
    lists = {
        name: value
        for name, value in node.items()
        if isinstance(value, list) and len(value) >= FEWEST
    }
    columns = {
        name: value for name, value in lists.items() if not isinstance(value[0], (dict, list))
    }
    if len(columns) > 1:
        units = next((node[key] for key in UNITS if isinstance(node.get(key), dict)), {})
        yield (
            path,
            (columns, {str(name): unit for name, unit in units.items() if isinstance(unit, str)}),
        )
        return
    for name, value in node.items():
        yield from _tables(value, f"{path}.{name}" if path else name, depth + 1)


def _of_records(records: list[dict[str, Any]]) -> tuple[dict[str, list[Any]], dict[str, str]]:
    """Return the columns of a list of records and their units; a record may be a signal, with a name and its values."""
    key = next(
        (key for key in VALUES if all(isinstance(record.get(key), list) for record in records)),
        None,
    )
    named = next(
        (name for name in NAMES if all(isinstance(record.get(name), str) for record in records)),
        None,
    )
    if key is not None and named is not None:
        units = {
            record[named]: record[unit]
            for record in records
            for unit in UNITS
            if isinstance(record.get(unit), str)
        }
        return {record[named]: record[key] for record in records}, units
    flat = [dict(flattened(record)) for record in records]
    names = list(dict.fromkeys(name for record in flat for name in record))
    if len(names) > MOST_NAMES or (len(names) > WIDE and len(names) * len(flat) > MOST_CELLS):
        raise InputError(
            f"has {len(names)} different names in {len(flat)} records",
            allowed=f"up to {MOST_NAMES} names, and with more than {WIDE} names up to {MOST_CELLS} values",
            mend=MEND,
        )
    return {name: [record.get(name) for record in flat] for name in names}, {}


def _table(
    columns: Mapping[str, list[Any]],
    units: Mapping[str, str],
    request: Request,
    facts: dict[str, str],
    constants: dict[str, float],
) -> Table:
    called, unit_of, notes = names_and_units(columns, units)
    numbers: dict[str, np.ndarray] = {}
    texts: dict[str, InputError] = {}
    for name, values in zip(called, columns.values(), strict=True):
        column = _numbers(values, is_time(name))
        if column is None:
            odd = next((value for value in values if not isinstance(value, (int, float))), None)
            texts[name] = InputError(
                "is not a number", path=f"{request.source}: {name!r}", value=str(odd)[:60]
            )
        else:
            numbers[name] = column
    if not numbers:
        raise InputError("holds no column of numbers", path=str(request.source), mend=MEND)
    advancing = (
        c
        for c, v in numbers.items()
        if is_time(c) and v.size > 1 and np.all(np.isfinite(v)) and np.mean(np.diff(v) > 0) > 0.5
    )
    time = next(advancing, None)
    notes += note_of_text(list(texts))
    series = []
    for name, values in numbers.items():
        if name == time:
            continue
        times = numbers[time] if time is not None and numbers[time].size == values.size else None
        if times is not None and request.choice(name):
            # A record without a value that others have: the channel was recorded at a lower rate.
            values, times = values[~np.isnan(values)], times[~np.isnan(values)]
        series.append(Series(name, values, times, unit_of.get(name, "")))
    named = (
        {}
        if time is None
        else {"time": time, "time_unit": unit_of.get(time) or unit_of_time(time, numbers[time])}
    )
    return table_of_series(
        series, request, "JSON", notes=notes, texts=texts, facts=facts, constants=constants, **named
    )


def _numbers(values: list[Any], may_count: bool) -> np.ndarray | None:
    """Return a list as numbers: NaN for missing values, dates and counts of time as seconds from the first."""
    filled = [value for value in values if value is not None]
    if not filled:
        return None
    # A count of µs or less since an epoch.
    if may_count and all(type(value) is int for value in values) and abs(values[0]) > 10**15:
        # Counts since an epoch would lose their last digits as floats.
        size = next(
            size for least, size in ((1e18, 1e9), (1e17, 1e7), (0, 1e6)) if abs(values[0]) >= least
        )
        return np.array([value - values[0] for value in values], dtype=np.int64) / size
    if all(isinstance(value, (int, float)) for value in filled):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    if not all(isinstance(value, str) for value in values):
        return None
    with suppress(ValueError):
        return np.array(values, dtype=float)
    with suppress(ValueError, TypeError):
        dates = [datetime.fromisoformat(value) for value in values]
        return np.array([(date - dates[0]).total_seconds() for date in dates])
    return None


EXAMPLE = b'[{"t": 0.0, "q": 1.5}, {"t": 0.001, "q": 1.6}, {"t": 0.002, "q": 1.7}, {"t": 0.003, "q": 1.8}]'
FORMAT = json_records = LogFormat(
    "json_records", "JSON", recognises, read=read, holds_tables=True, example=EXAMPLE
)
