"""Text files that need more than columns of numbers: dates as stamps, several columns of time, cells left empty."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from bristle.core import units
from bristle.logs.cells import CLOCK, cells_of, without_comments
from bristle.logs.layout import Layout
from bristle.logs.names import listed, plain_unit
from bristle.logs.table import Table, split_unit
from bristle.logs.tables import Series, table_of_series
from bristle.logs.words import is_time, unit_in_name, unit_of_time

__all__ = [
    "amount_in",
    "facts_above",
    "names_beside_times",
    "partly_empty",
    "period_told",
    "stamps_in",
    "units_of_labview",
    "with_own_times",
]

LONG = 10  # digits of a time that counts from long ago
EPOCHS = ((19, 1e9), (17, 1e7), (16, 1e6), (13, 1e3), (0, 1.0))  # digits, and what it counts in a second
OFTEN = 0.2  # share of empty cells from which on a column was recorded less often, or ended early
LONGEST_FACT = 200
PERIOD_NAMES = listed(
    "sampletime | sample time | sampling time | sampling period | sampling interval | abtastzeit | abtastintervall | abtasttakt | "
    "takt | sample period | sample interval | sampleinterval | samplingtime | samplingperiod | tsample | t sample | delta x | "
    "cycle time | zykluszeit | trace cycle | aufzeichnungstakt | interval | dt | ts"
)
RATE_NAMES = listed("sample rate | samplerate | sampling rate | abtastrate | abtastfrequenz | sampling frequency | sample frequency | fs")
_FACT = re.compile(r"\s*[#%*\"]*\s*([^:=;\t,]{2,60}?)\s*\"?\s*[:=;\t,]\s*\"?\s*(.+?)\s*\"?[;,\t]*\s*")


def facts_above(lines: Sequence[str], layout: Layout) -> dict[str, str]:
    """Return what stands above the header of a text file, as names and what is said of them."""
    above = [line for line in lines[: layout.first] if line.strip()][: -1 if layout.first else None]
    matches = (_FACT.fullmatch(line[:LONGEST_FACT]) for line in above)
    between = r"[;\t,]+" if layout.delimiter == "," and not layout.decimal_comma else r"[;\t]+"
    return {match[1].strip(): re.sub(between, " ", match[2]).strip() for match in matches if match}


def units_of_labview(lines: Sequence[str], layout: Layout) -> dict[str, str]:
    """Return the units of a measurement file of LabVIEW, which stand in a row of their own above the names."""
    row = next((line for line in lines[: layout.first] if line.lower().startswith("y_unit_label")), None)
    if row is None:
        return {}
    # Its first cell says what it is, and stands above the times.
    cells = zip(layout.names[1:], cells_of(row, layout.delimiter)[1:], strict=False)
    return {name: unit for name, unit in cells if unit and not name.lower().startswith("x_value")}


def period_told(facts: dict[str, str]) -> float | None:
    """Return the time between samples [s] that stands above the columns of a file; None where none does."""
    for name, text in facts.items():
        key = split_unit(name)[0].lower().rstrip(":").replace("_", " ")
        key = key.removesuffix(" ms").removesuffix(" us").removesuffix(" s").removesuffix(" hz").removesuffix(" khz")
        for names, target in ((PERIOD_NAMES, "s"), (RATE_NAMES, "Hz")):
            if key in names and (value := _amount(name, text, target)):
                return value if target == "s" else 1.0 / value
    return None


def amount_in(name: str, text: str) -> tuple[float, str] | None:
    """Return the number and the unit of a fact such as ``Rated torque [Nm]: 2,4``; None where it holds none."""
    match = re.match(r"([+-]?\d[\d.,]*(?:[eE][+-]?\d+)?)\s*([^\d\s]\S*)?", text)
    if match is None:
        return None
    unit = plain_unit(match[2] or split_unit(name)[1] or unit_in_name(name))
    try:
        return float(match[1].replace(",", ".")), units.split(f"1 {unit}")[1] if unit else ""
    except ValueError:
        return None


def _amount(name: str, text: str, target: str) -> float | None:
    amount = amount_in(name, text)
    if amount is None:
        return None
    try:
        value = amount[0] * units.factor(amount[1] or target, target)
    except ValueError:
        return None
    return value if 0.0 < value < np.inf else None


def stamps_in(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray]:
    """Return the columns of dates, times of day and counts since long ago, as seconds from the first row."""
    lines = [line for line in body.decode(encoding, "replace").split("\n") if line.strip()]
    first = cells_of(without_comments(lines[0]), layout.delimiter) if lines else []
    stamps: dict[int, np.ndarray] = {}
    for index, (cell, numeric, name) in enumerate(zip(first, layout.numeric, layout.names, strict=False)):
        is_date = not numeric and (CLOCK.fullmatch(cell) or _GERMAN.fullmatch(cell))
        if not is_date and not (numeric and is_time(name) and len(cell.replace(",", ".").partition(".")[0]) >= LONG):
            continue
        try:
            cells = [cells_of(line, layout.delimiter)[index].replace(",", ".") for line in lines]
            seconds = _seconds_of_dates(cells) if is_date else _seconds_of_counts(cells)
        except (ValueError, IndexError):
            continue
        if seconds is not None:
            stamps[index] = seconds
    return stamps


def _seconds_of_dates(cells: Sequence[str]) -> np.ndarray | None:
    moments = [_moment(cell) for cell in cells]
    seconds = np.array([(moment - moments[0]).total_seconds() for moment in moments])
    days = np.cumsum(np.append(0.0, np.diff(seconds) < -43200.0))  # a time of day begins anew at midnight
    return seconds + 86400.0 * days if np.any(np.diff(seconds) > 0) else None  # one that stands still is no stamp


_GERMAN = re.compile(r"(\d\d?)\.(\d\d?)\.(\d{4})[ T](\d\d?:\d\d:\d\d(?:[.,]\d+)?)")


def _moment(cell: str) -> datetime:
    german = _GERMAN.fullmatch(cell)
    if german:
        cell = f"{german[3]}-{int(german[2]):02d}-{int(german[1]):02d} {german[4]}"
    cell = cell.replace(",", ".").replace("/", "-").removesuffix("Z")
    date, _, clock = cell.replace("T", " ").rpartition(" ")
    parts = clock.split(".")
    fraction = (parts[1] + "000000")[:6] if len(parts) > 1 else "000000"
    hour = ":".join(part.zfill(2) for part in parts[0].split(":"))
    return datetime.fromisoformat(f"{date or '2000-01-01'}T{hour}.{fraction}")


def _seconds_of_counts(cells: Sequence[str]) -> np.ndarray | None:
    """Return times that count since long ago: a number would lose their end."""
    digits = cells[0].partition(".")[0].lstrip("-")
    parts = [cell.partition(".") for cell in cells]
    if len(digits) < LONG or not digits.isdigit() or not all(left.isdigit() and (not right or right.isdigit()) for left, _, right in parts):
        return None
    counts = np.array([int(left) for left, _, _ in parts], dtype=np.int64)
    fractions = np.array([float(f"0.{right or 0}") for _, _, right in parts])
    scale = next(size for least, size in EPOCHS if len(digits) >= least)
    return np.round((counts - counts[0]) / scale + (fractions - fractions[0]) / scale, 9)


def partly_empty(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray] | None:
    """Return all columns of numbers, NaN where a cell is empty; None where a cell is something else.

    Rows may be shorter than the first ones, where columns end early.
    """
    lines = [line for line in without_comments(body.decode(encoding, "replace")).split("\n") if line.strip()]
    rows = [cells_of(line, layout.delimiter) for line in lines]
    numeric_columns = [index for index, numeric in enumerate(layout.numeric) if numeric]
    columns = {}
    for index in numeric_columns:
        cells = [row[index] if index < len(row) else "" for row in rows]
        cells = [cell.replace(",", ".") if layout.decimal_comma else cell for cell in cells]
        try:
            columns[index] = np.array([cell or "nan" for cell in cells], dtype=float)
        except ValueError:
            return None
    empty = [np.mean(np.isnan(values)) for values in columns.values()]
    return columns if any(share >= OFTEN for share in empty) else None


def with_own_times(
    columns: dict[int, np.ndarray], layout: Layout, source: Path, chosen: Callable[[str], bool], notes: Sequence[str]
) -> Table | None:
    """Return the table of columns of which several are times, or some were recorded less often than the others.

    None where the columns are of one length and have one time, as most files do.
    """
    clocks = [index for index, values in columns.items() if _is_clock(layout.names[index], values)]
    if not clocks or (len(clocks) < 2 and not any(np.isnan(values).any() for values in columns.values())):
        return None
    if clocks[0] != min(columns):
        return None
    first = layout.names[clocks[0]]
    unit = layout.units[clocks[0]] or unit_of_time(first, columns[clocks[0]])
    series = []
    for index, values in columns.items():
        if index in clocks:
            continue
        times = columns[max(clock for clock in clocks if clock < index)]
        filled = np.isfinite(values) & np.isfinite(times)
        name = layout.names[index]
        if 0 < np.count_nonzero(np.isnan(values)) < OFTEN * values.size and len(clocks) < 2:
            filled = np.isfinite(times)  # a few samples are missing: that is told, not mended
        samples = values[filled] if chosen(name) else None
        series.append(Series(name, samples, times[filled] if samples is not None else None, layout.units[index]))
    return table_of_series(series, source, "text", time_unit=unit, notes=notes)


def names_beside_times(names: Sequence[str]) -> tuple[str, ...]:
    """Return names that stand above the times of their columns, above the columns."""
    pairs = list(zip(names[::2], names[1::2], strict=False))
    nameless = [name.startswith("column_") for name in names]
    if len(names) % 2 or len(pairs) < 2 or any(nameless[::2]) or not all(nameless[1::2]):
        return tuple(names)
    return tuple(name for k, (above, _) in enumerate(pairs) for name in (f"column_{2 * k + 1}", above))


def _is_clock(name: str, values: np.ndarray) -> bool:
    """Return whether a column is a time: by its name, or where it has none, by rising evenly."""
    finite = values[np.isfinite(values)]
    steps = np.diff(finite)
    if finite.size < 3 or not np.all(steps >= 0) or not np.any(steps > 0):
        return False
    if is_time(name) or name.lower() in ("x_value", "name") or name.lower().startswith("x_value_"):
        return True
    nameless = name.startswith("column_") or re.fullmatch(r"name_\d+", name.lower()) is not None
    return nameless and bool(np.ptp(steps) <= 0.02 * np.median(steps) + 1e-12)
