"""Text files that need more than columns of numbers: dates as stamps, several columns of time, cells left empty."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from bristle.core import units
from bristle.logs.layout import CLOCK, Layout, cells_of, without_comments
from bristle.logs.names import listed, plain_unit
from bristle.logs.table import ALL, Request, Table, split_unit
from bristle.logs.tables import Series, table_of_series
from bristle.logs.words import is_time, unit_in_name, unit_of_time

EPOCHS = ((19, 1e9), (17, 1e7), (16, 1e6), (13, 1e3), (0, 1.0))  # digits, and what it counts in a second
OFTEN = 0.2  # share of empty cells from which on a column was recorded less often, or ended early
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
    matches = (_FACT.fullmatch(line[:200]) for line in above)
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
        key = re.sub(r"( ms)?( us)?( s)?( hz)?( khz)?$", "", split_unit(name)[0].lower().rstrip(":").replace("_", " "))
        target = "s" if key in PERIOD_NAMES else "Hz" if key in RATE_NAMES else ""
        amount = amount_in(name, text) if target else None
        unit = amount[1] or target if amount is not None else ""
        if amount is not None and units.is_unit(unit) and units.compatible(unit, target):
            value = amount[0] * units.factor(unit, target)
            if 0.0 < value < np.inf:
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


def stamps_in(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray]:
    """Return the columns of dates, times of day and counts since long ago, as seconds from the first row."""
    lines = [line for line in body.decode(encoding, "replace").split("\n") if line.strip()]
    first = cells_of(without_comments(lines[0]), layout.delimiter) if lines else []
    stamps: dict[int, np.ndarray] = {}
    for index, (cell, numeric, name) in enumerate(zip(first, layout.numeric, layout.names, strict=False)):
        is_date = not numeric and (CLOCK.fullmatch(cell) or _GERMAN.fullmatch(cell))
        # 10 digits of a time that counts from long ago
        if not is_date and not (numeric and is_time(name) and len(cell.replace(",", ".").partition(".")[0]) >= 10):
            continue
        try:
            cells = [cells_of(line, layout.delimiter)[index].replace(",", ".") for line in lines]
            seconds = _of_dates(cells) if is_date else _of_counts(cells)
        except (ValueError, IndexError):
            continue
        if np.any(np.diff(seconds) > 0) or not is_date:  # a date that stands still is no stamp
            stamps[index] = seconds
    return stamps


_GERMAN = re.compile(r"(\d\d?)\.(\d\d?)\.(\d{4})[ T](\d\d?:\d\d:\d\d(?:[.,]\d+)?)")


def _of_dates(cells: Sequence[str]) -> np.ndarray:
    moments = []
    for cell in cells:
        if german := _GERMAN.fullmatch(cell):
            cell = f"{german[3]}-{int(german[2]):02d}-{int(german[1]):02d} {german[4]}"
        date, _, clock = cell.replace("/", "-").removesuffix("Z").replace("T", " ").rpartition(" ")
        moments.append(datetime.fromisoformat(f"{date or '2000-01-01'}T{'0' * (clock[1:2] == ':')}{clock}"))
    seconds = np.array([(moment - moments[0]).total_seconds() for moment in moments])
    return seconds + 86400.0 * np.cumsum(np.append(0.0, np.diff(seconds) < -43200.0))  # a time of day begins anew at midnight


def _of_counts(cells: Sequence[str]) -> np.ndarray:
    """Return times that count since long ago: as a number they would lose their end."""
    parts = [cell.partition(".") for cell in cells]
    counts = np.array([int(left) for left, _, _ in parts], dtype=np.int64)
    fractions = np.array([float(f"0.{right or 0}") for _, _, right in parts])
    if counts.min() < 0:
        raise ValueError("no count")
    scale = next(size for least, size in EPOCHS if len(parts[0][0]) >= least)
    return np.round((counts - counts[0]) / scale + (fractions - fractions[0]) / scale, 9)


def partly_empty(body: bytes, layout: Layout, encoding: str) -> dict[int, np.ndarray] | None:
    """Return all columns of numbers, NaN where a cell is empty; None where a cell is something else.

    Rows may be shorter than the first ones, where columns end early.
    """
    text = without_comments(body.decode(encoding, "replace"))
    rows = [cells_of(line, layout.delimiter) for line in text.split("\n") if line.strip()]
    columns = {}
    for index in np.flatnonzero(layout.numeric).tolist():
        cells = ((row[index] if index < len(row) else "") or "nan" for row in rows)
        try:
            columns[index] = np.array([cell.replace(",", ".") if layout.decimal_comma else cell for cell in cells], dtype=float)
        except ValueError:
            return None
    return columns if any(np.mean(np.isnan(values)) >= OFTEN for values in columns.values()) else None


def with_own_times(columns: dict[int, np.ndarray], layout: Layout, request: Request, notes: Sequence[str]) -> Table | None:
    """Return the table of columns of which several are times, or some were recorded less often than the others.

    None where the columns are of one length and have one time, as most files do.
    """
    clocks = [index for index, values in columns.items() if _is_clock(layout.names[index], values)]
    if not clocks or (len(clocks) < 2 and not any(np.isnan(values).any() for values in columns.values())) or clocks[0] != min(columns):
        return None
    unit = layout.units[clocks[0]] or unit_of_time(layout.names[clocks[0]], columns[clocks[0]])
    series = []
    for index, values in columns.items():
        if index in clocks:
            continue
        times = columns[max(clock for clock in clocks if clock < index)]
        filled = np.isfinite(times)
        missing = np.count_nonzero(np.isnan(values))
        if len(clocks) > 1 or not 0 < missing < OFTEN * values.size:  # else a few samples are missing: that is told, not mended
            filled &= np.isfinite(values)
        samples = values[filled] if request.choice(layout.names[index], index + 1) else None
        series.append(Series(layout.names[index], samples, times[filled], layout.units[index]))
    table = table_of_series(series, request._replace(choice=ALL), "text", time_unit=unit, notes=notes)
    return replace(table, numbers={f"column_{i + 1}": layout.names[i] for i in columns})


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
