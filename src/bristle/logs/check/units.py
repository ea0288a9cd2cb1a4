"""Whether the units of a log are those of an axis: what its columns are called, how fast it moves and is sampled."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic, Number
from bristle.logs.channel import LogData, clear_step
from bristle.logs.check.rows import Rows
from bristle.logs.check.thresholds import CheckThresholds

__all__ = ["about_units", "unit_in_name"]

TIMES = {"s": "s", "sec": "s", "ms": "ms", "msec": "ms", "us": "us", "usec": "us", "µs": "us", "μs": "us", "ns": "ns"}
LENGTHS = {
    "m": "m",
    "mm": "mm",
    "um": "um",
    "µm": "um",
    "μm": "um",
    "nm": "nm",
    "rad": "rad",
    "mrad": "mrad",
    "deg": "deg",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "rev": "rev",
    "turn": "rev",
    "turns": "rev",
}
OTHER_STEP = 5.0  # times the resolution: counts of a quadrature encoder differ by 2 and 4
DEGREES = 180.0 / math.pi  # in a radian
ALMOST_ALL = 0.999  # of the rows: faster ones may be noise


def about_units(log: LogData, rows: Rows, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield what says that a unit is another one than that declared."""
    named = _named_otherwise("time", TIMES, axis)
    dt = log.sample_time
    if named is not None or not settings.shortest_sample <= dt <= settings.longest_sample:
        column, declared, called = named or (log.time.column, "", "")
        numbers = {"sample_time": dt, "column": column, "declared": declared, "called": called}
        yield Diagnostic("clock_suspect", "", "warning", numbers, log.kind)
    yield from _about_steps(log, axis)
    named = _named_otherwise("position", LENGTHS, axis)
    speed = float(np.quantile(np.abs(rows.velocity), ALMOST_ALL)) if rows.velocity.size else 0.0
    most = settings.fastest if log.kind == "translational" else settings.fastest_turning
    if named is not None or (speed > most and dt >= settings.shortest_sample):
        column, declared, called = named or (log.position.column, "", "")
        numbers = {"speed": speed, "column": column, "declared": declared, "called": called}
        yield Diagnostic("unit_suspect", "", "warning", numbers, log.kind)


def _about_steps(log: LogData, axis: Axis) -> Iterator[Diagnostic]:
    """Yield that the position steps by something else than the resolution of the axis file."""
    recorded = log.position.recorded_step
    if not axis.resolution:
        return
    step = clear_step(log.position.values, most=math.inf) if recorded is None else recorded
    if step < axis.resolution and recorded is None:  # digits of a text are a finer step than any encoder has
        step = clear_step(log.position.values)
    if not step:
        return
    times = step / axis.resolution
    if 1.0 / OTHER_STEP < times < OTHER_STEP:
        return
    degrees = any(abs(ratio / DEGREES - 1.0) < 0.02 for ratio in (times, 1.0 / times))
    numbers: dict[str, Number] = {"step": step, "resolution": axis.resolution, "times": times, "degrees": float(degrees)}
    yield Diagnostic("resolution_contradicts", "", "warning", numbers, log.kind)


def unit_in_name(name: str, units: dict[str, str]) -> str:
    """Return the unit that the name of a column ends with; empty where it names none.

    Examples
    --------
    >>> unit_in_name("phi_deg", LENGTHS), unit_in_name("t [ms]", TIMES), unit_in_name("x", LENGTHS)
    ('deg', 'ms', '')
    """
    parts = [part for part in re.split(r"[\s_\-\[\]()./:]+", name) if part]
    return units.get(parts[-1].lower(), "") if len(parts) > 1 else ""


def _named_otherwise(channel: str, units: dict[str, str], axis: Axis) -> tuple[str, str, str] | None:
    """Return a column, its declared unit and the one in its name, where these differ."""
    column = axis.columns.get(channel)
    if column is None or not column.unit:
        return None
    called, declared = unit_in_name(column.name, units), units.get(column.unit.lower(), "")
    return (column.name, column.unit, called) if called and declared and called != declared else None
