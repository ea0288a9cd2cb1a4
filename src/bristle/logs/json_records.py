"""Logs in JSON: records one after another, columns by name, or signals with their values."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.names import names_and_units
from bristle.logs.table import Choice, Request, Table
from bristle.logs.tables import Series, no_such_table, table_of_series
from bristle.logs.words import is_time, unit_of_time

__all__ = ["looks_like_json", "read"]

DEEPEST = 8
MOST_NAMES, MOST_CELLS = 20_000, 20_000_000  # of records
WIDE = 1000
LARGE = 10**15  # of a count of µs or less since long ago
STARTS = tuple(sign.encode() for sign in '"{[}]-0123456789')
FEWEST = 2
NAMES, VALUES, UNITS = (("name", "signal", "channel", "id", "label"), ("values", "data", "samples", "y"), ("unit", "units"))
MEND = 'Save a list of records, such as [{"t": 0.0, "position": 0.1}, …], or columns by name'


def looks_like_json(head: bytes) -> bool:
    """Return whether text begins as JSON does, and not with the name of a section in brackets."""
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    return text[:1] in (b"{", b"[") and text[1:].lstrip()[:1] in STARTS


def read(data: bytes, request: Request) -> Table:
    """Return the columns of a JSON file."""
    content = _parsed(data, request.source)
    try:
        tables = {path: table for path, table in _tables(content, "", 0) if table[0]}
    except InputError as error:
        raise error.at(str(request.source)) from None
    if not tables:
        raise InputError("holds no records and no columns of numbers", path=str(request.source), mend=MEND)
    name = _chosen(tables, request.table, request.source)
    columns, units = tables[name]
    facts = {key: value for key, value in _facts(content, "", 0) if isinstance(value, str)}
    constants = {key: float(value) for key, value in _facts(content, "", 0) if not isinstance(value, str)}
    return _table(columns, units, request.source, request.choice, facts, constants)


def _parsed(data: bytes, source: Path) -> Any:
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    try:
        return json.loads(text)
    except RecursionError:
        raise InputError("is nested too deeply", path=str(source), mend=MEND) from None
    except json.JSONDecodeError as error:
        lines = [line for line in text.splitlines() if line.strip()]
        records = _objects(lines)
        if len(records) >= max(FEWEST, len(lines) - 1):  # the last line of a recording may be cut
            return records
        raise InputError(
            f"is truncated or no JSON: {error.msg} in line {error.lineno}", path=str(source), mend="Copy or save it again"
        ) from None


def _objects(lines: list[str]) -> list[dict[str, Any]]:
    """Return the objects in lines of one each, as far as they are."""
    records: list[dict[str, Any]] = []
    with suppress(json.JSONDecodeError, RecursionError):
        for line in lines:
            record = json.loads(line)
            if not isinstance(record, dict):
                break
            records.append(record)
    return records


def _tables(node: Any, path: str, depth: int) -> Iterator[tuple[str, tuple[dict[str, list[Any]], dict[str, str]]]]:
    """Yield what a table can be made of, with its name, its columns and their units."""
    if depth > DEEPEST:
        return
    if isinstance(node, list) and len(node) >= FEWEST and all(isinstance(record, dict) for record in node):
        signals = _signals(node)
        yield path, signals if signals else (_of_records(node), {})
        return
    if isinstance(node, list) and len(node) >= FEWEST and all(isinstance(row, list) and row for row in node):
        width = min(len(row) for row in node)
        yield path, ({f"column_{k + 1}": [row[k] for row in node] for k in range(width)}, {})
        return
    if not isinstance(node, dict):
        return
    if isinstance(node.get("columns"), list) and isinstance(node.get("data"), list):  # as pandas splits a frame
        rows = [row for row in node["data"] if isinstance(row, list)]
        yield path, ({str(name): [row[k] for row in rows] for k, name in enumerate(node["columns"])}, {})
        return
    columns = {name: list(value.values()) if isinstance(value, dict) else value for name, value in node.items() if _is_column(value)}
    if len(columns) > 1:
        yield path, (columns, _units_in(node))
        return
    for name, value in node.items():
        yield from _tables(value, f"{path}.{name}" if path else name, depth + 1)


def _is_column(value: Any) -> bool:
    if isinstance(value, dict):  # as pandas writes a frame: by index
        return len(value) >= FEWEST and all(str(key).isdigit() for key in value) and _is_column(list(value.values()))
    return isinstance(value, list) and len(value) >= FEWEST and not isinstance(value[0], (dict, list))


def _units_in(node: Mapping[str, Any]) -> dict[str, str]:
    unit_of = next((node[key] for key in UNITS if isinstance(node.get(key), dict)), {})
    return {str(name): unit for name, unit in unit_of.items() if isinstance(unit, str)}


def _signals(node: list[dict[str, Any]]) -> tuple[dict[str, list[Any]], dict[str, str]] | None:
    """Return the columns of a list of signals, each of which has a name and its values."""
    key = next((key for key in VALUES if all(isinstance(entry.get(key), list) for entry in node)), None)
    named = next((name for name in NAMES if all(isinstance(entry.get(name), str) for entry in node)), None)
    if key is None or named is None:
        return None
    units = {entry[named]: entry[unit] for entry in node for unit in UNITS if isinstance(entry.get(unit), str)}
    return {entry[named]: entry[key] for entry in node}, units


def _of_records(records: list[dict[str, Any]]) -> dict[str, list[Any]]:
    flat = [dict(_flat(record, "", 0)) for record in records]
    names = list(dict.fromkeys(name for record in flat for name in record))
    if len(names) > MOST_NAMES or (len(names) > WIDE and len(names) * len(flat) > MOST_CELLS):
        raise InputError(
            f"has {len(names)} different names in {len(flat)} records",
            allowed=f"{MOST_NAMES} names; beyond {WIDE}, {MOST_CELLS} values",
            mend=MEND,
        )
    return {name: [record.get(name) for record in flat] for name in names}


def _flat(node: Any, path: str, depth: int) -> Iterator[tuple[str, Any]]:
    if isinstance(node, dict) and depth < DEEPEST:
        for name, value in node.items():
            yield from _flat(value, f"{path}.{name}" if path else name, depth + 1)
    elif isinstance(node, list) and depth < DEEPEST:
        for index, value in enumerate(node):
            yield from _flat(value, f"{path}[{index}]", depth + 1)
    else:
        yield path, node


def _facts(node: Any, path: str, depth: int) -> Iterator[tuple[str, Any]]:
    if not isinstance(node, dict) or depth > DEEPEST:
        return
    for name, value in node.items():
        full = f"{path}.{name}" if path else str(name)
        if isinstance(value, dict):
            yield from _facts(value, full, depth + 1)
        elif isinstance(value, (int, float, str)) and not isinstance(value, bool):
            yield full, value


def _chosen(tables: Mapping[str, Any], table: str | None, source: Path) -> str:
    if table is not None and table in tables:
        return table
    if table is not None and len(tables) > 1:
        raise no_such_table(table, list(tables), source)
    return max(tables, key=lambda name: max(map(len, tables[name][0].values())))


def _table(
    columns: Mapping[str, list[Any]],
    units: Mapping[str, str],
    source: Path,
    choice: Choice,
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
            texts[name] = InputError("is not a number", path=f"{source}: {name!r}", value=str(odd)[:60])
        else:
            numbers[name] = column
    if not numbers:
        raise InputError("holds no column of numbers", path=str(source), mend=MEND)
    time = next((name for name in numbers if is_time(name) and _advances(numbers[name])), None)
    notes += [f"text was left out: {', '.join(list(texts)[:20])}"] if texts else []
    series = []
    for name, values in numbers.items():
        if name == time:
            continue
        times = numbers[time] if time is not None and numbers[time].size == values.size else None
        if times is not None and choice(name):
            # Where a record lacks a value that others have, the channel was recorded less often.
            values, times = values[~np.isnan(values)], times[~np.isnan(values)]
        series.append(Series(name, values if choice(name) else None, times, unit_of.get(name, "")))
    named = {} if time is None else {"time": time, "time_unit": unit_of.get(time) or unit_of_time(time, numbers[time])}
    return table_of_series(series, source, "JSON", notes=notes, texts=texts, facts=facts, constants=constants, **named)


def _advances(values: np.ndarray) -> bool:
    return bool(np.all(np.isfinite(values)) and values.size > 1 and np.mean(np.diff(values) > 0) > 0.5)


def _counted(values: list[int]) -> np.ndarray:
    """Return times that count from long ago in s from the first: as numbers they would lose their end."""
    size = next(size for least, size in ((1e18, 1e9), (1e17, 1e7), (0, 1e6)) if abs(values[0]) >= least)
    return np.array([value - values[0] for value in values], dtype=np.int64) / size


def _numbers(values: list[Any], may_count: bool) -> np.ndarray | None:
    """Return a list as numbers: a missing one is NaN, dates and counts of a time are seconds from the first."""
    filled = [value for value in values if value is not None]
    if not filled:
        return None
    is_counted = may_count and len(filled) == len(values) and all(type(value) is int for value in values)
    if is_counted and abs(values[0]) > LARGE:
        return _counted(values)
    if all(isinstance(value, (int, float)) for value in filled):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    if not all(isinstance(value, str) for value in filled) or len(filled) < len(values):
        return None
    with suppress(ValueError):
        return np.array(values, dtype=float)
    with suppress(ValueError, TypeError):
        dates = [datetime.fromisoformat(value) for value in values]
        return np.array([(date - dates[0]).total_seconds() for date in dates])
    return None
