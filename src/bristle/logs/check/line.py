"""What a line through a log says against what is told of it: its mass, its level, a channel that bends over.

Inertia, levels and slopes by direction, a fall with speed, and the rate of the effort: a delay or a filter of one of
both channels is then no error of the inertia. The line judges nothing but the log; no fit takes a number from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.logs.check.gears import gears_near
from bristle.logs.check.rows import Line, Rows
from bristle.logs.check.thresholds import CheckThresholds

__all__ = ["Through", "about_line"]

FALLS = (0.1, 0.02)  # of the largest speed, over which friction may fall
SIDE = 0.02  # share of the rows in a direction from which it has columns of its own
EXPLAINED = 0.95  # of the scatter of the effort: a line that leaves more says nothing


@dataclass(frozen=True)
class Through:
    """The rows that slide, with the columns of a line through them."""

    rows: Rows
    columns: np.ndarray

    @classmethod
    def of(cls, rows: Rows) -> Through:
        """Return them."""
        slid = rows.of(rows.sliding)
        v = slid.velocity
        top = float(np.abs(v).max(initial=0.0)) or 1.0
        columns = [slid.acceleration, -slid.rate]
        for side in ((v > 0.0).astype(float), (v < 0.0).astype(float)):
            if v.size and side.mean() > SIDE:
                columns += [side, side * v, *(side * np.exp(-np.abs(v) / (fall * top)) for fall in FALLS)]
        return cls(slid, np.column_stack(columns))

    def line(self, *further: np.ndarray) -> Line | None:
        """Return the line with further columns behind those; None where it says nothing."""
        line = Line.through(np.column_stack([self.columns, *further]), self.rows.effort)
        return line if line is not None and line.explained > EXPLAINED else None


def about_line(rows: Rows, axis: Axis, settings: CheckThresholds, *, clipped: bool) -> Iterator[Diagnostic]:
    """Yield where a line through the log contradicts what is told of the axis, or itself."""
    through = Through.of(rows)
    line = through.line()
    if line is None:
        return
    bent = None if clipped else _bent(through, settings)
    if bent is not None:
        yield Diagnostic("saturates", "", "warning", {"percent": 100.0 * bent}, axis.kind)
    elif not clipped:
        yield from _about_mass(through, line, axis, settings)
    yield from _about_level(through, line, axis, settings)


def _bent(through: Through, settings: CheckThresholds) -> float | None:
    """Return by how much of itself the largest effort reads too little; None where that does not show."""
    effort = through.rows.effort
    top = float(np.abs(effort).max())
    line = through.line(-((effort / top) ** 3) * top)
    if line is None:
        return None
    share, deviation = float(line.coefficients[-1]), float(line.deviations[-1])
    return share if share > settings.soft_limit and share > settings.sure * deviation else None


def _about_mass(through: Through, line: Line, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    mass, deviation = float(line.coefficients[0]), float(line.deviations[0])
    share = abs(mass) * float(np.std(through.rows.acceleration)) / float(np.std(through.rows.effort))
    telling = mass > 0.0 and deviation < settings.mass_error * mass and share > settings.inertia_share
    if axis.mass is None or axis.mass <= 0.0 or axis.plant != "inertia" or not telling:
        return
    ratio = axis.mass / mass
    if max(ratio, 1.0 / ratio) < settings.mass_ratio * (1.0 + settings.sure * deviation / mass):
        return
    numbers = {"known": axis.mass, "found": mass, "ratio": ratio}
    yield Diagnostic("mass_contradicts", "", "warning", numbers, axis.kind)
    yield from gears_near(ratio, "mass", axis, settings)


def _about_level(through: Through, line: Line, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    rows = through.rows
    side = np.sign(rows.velocity)
    if min(np.mean(side > 0.0), np.mean(side < 0.0)) <= SIDE:
        return
    time, position = (_centred(of) for of in (rows.time, rows.position))
    changing = through.line(time, position, side * time, side * position)
    if changing is None:
        return
    rest = rows.effort - line.coefficients[0] * rows.acceleration + line.coefficients[1] * rows.rate
    level = float(np.mean(np.abs(rest - np.median(rest))))
    for place, code in ((-2, "level_drifts"), (-1, "level_over_position")):
        change, deviation = changing.coefficients[place] / level, changing.deviations[place] / level
        if abs(change) > settings.level_drift and abs(change) > settings.sure * deviation:
            numbers = {"percent": 100.0 * float(change), "level": level}
            yield Diagnostic(code, "", "warning", numbers, axis.kind)


def _centred(values: np.ndarray) -> np.ndarray:
    low, high = float(values.min()), float(values.max())
    return (values - 0.5 * (low + high)) / ((high - low) or 1.0)
