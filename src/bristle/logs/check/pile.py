"""An effort that is cut off below its noise: it piles up near its extreme, and falls short of the motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bristle.core.normal import DEVIATION_OVER_MEDIAN
from bristle.logs.channel import LogData
from bristle.logs.check.rows import Line, Rows, rows_of
from bristle.logs.check.thresholds import CheckThresholds
from bristle.logs.checks import Cut, longest_run

__all__ = ["piled_up"]

TOP = 0.999  # quantile of a side: single samples beyond are noise
DEVIATIONS, NARROWEST, WIDEST = 6.0, 0.02, 0.08  # of the noise, and of the top: the width of a pile below it
BELOW = 2.0  # widths below the pile, with which it is compared
PILE_UP = 3.0  # times as dense as below; a sine has 2.7
SHORT = 0.05  # of the level: what the motion asks for beyond it


def piled_up(log: LogData, rows: Rows, resolution: float, settings: CheckThresholds) -> Cut | None:
    """Return where an effort piles up near its extreme although the motion takes more of it; None where none does.

    A drive at its limit piles up too, and its effort is the one that acts: there inertia times acceleration is what it
    was elsewhere.
    """
    assert log.effort is not None
    values = log.effort.values
    sides = [side for side in (1.0, -1.0) if _piles(side * values, int(settings.clipped_samples))]
    if not sides:
        return None
    at = sum((side * _near(side * values) for side in sides), np.zeros(values.size))
    # The missing effort passes the filter of all rows.
    missing = rows_of(replace(log, effort=replace(log.effort, values=at)), resolution).effort
    level = float(np.median(np.abs(values[at != 0.0])))
    if not _falls_short(rows, missing, level, settings.sure):
        return None
    start, length = longest_run(at != 0.0)
    return Cut(float(np.sign(at[start])) * level, start, length, int(np.count_nonzero(at)))


def _edges(values: np.ndarray) -> tuple[float, float]:
    """Return where a pile below the largest values begins, and where the band begins that it is compared with."""
    top = float(np.quantile(values[values > 0.0], TOP))
    noise = DEVIATION_OVER_MEDIAN * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0)
    width = float(np.clip(DEVIATIONS * noise, NARROWEST * top, WIDEST * top))
    return top - width, top - (1.0 + BELOW) * width


def _near(values: np.ndarray) -> np.ndarray:
    return values > _edges(values)[0]


def _piles(values: np.ndarray, run: int) -> bool:
    """Return whether a signal lies near its largest value far more often, and for longer, than below it."""
    if np.count_nonzero(values > 0.0) < run:
        return False
    near, low = _edges(values)
    at, below = values > near, (values > low) & (values <= near)
    return longest_run(at)[1] >= run and bool(np.count_nonzero(at) * BELOW >= PILE_UP * np.count_nonzero(below))


def _falls_short(rows: Rows, missing: np.ndarray, level: float, sure: float) -> bool:
    """Return whether a line through the rows lacks effort where it piles up."""
    columns = (rows.acceleration, rows.velocity, np.sign(rows.velocity), np.ones_like(rows.velocity))
    line, bent = (Line.through(np.column_stack([*columns, shape]), rows.effort) for shape in (-missing, rows.effort**3))
    # A channel that bends over does not end at once; what it lacks goes with the cube of what it reads.
    if line is None or (bent is not None and bent.explained > line.explained):
        return False
    short, error = float(line.coefficients[-1]), float(line.deviations[-1])
    return short > SHORT * level and short > sure * error
