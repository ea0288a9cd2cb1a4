"""The columns of a file as candidates for channels: their numbers, their units, and what their names mean."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bristle.core import units
from bristle.core.least_squares import unbounded
from bristle.logs.table import Table, axis_in
from bristle.logs.words import Meaning, is_time, meaning_of, unit_in_name


@dataclass(frozen=True, eq=False)
class Candidate:
    """A column that may be a channel."""

    name: str
    values: np.ndarray
    unit: str
    told_by: str
    meaning: Meaning
    axis: tuple[str, str] | None = None
    unknown: str = ""

    def is_apart_from(self, position: Candidate) -> bool:
        """Return whether the addresses of two signals name two axes."""
        return self.axis is not None and position.axis is not None and self.axis != position.axis

    def is_one_of(self, bases: Iterable[str]) -> bool:
        """Return whether its unit is one of several quantities."""
        return bool(self.unit) and any(units.compatible(self.unit, base) for base in bases)

    def fits(self, role: str, bases: Iterable[str]) -> bool:
        """Return whether the column may play a role: by its unit where it has one, else by its name."""
        if self.unit:
            return self.is_one_of(bases) and self.meaning.role in ("", role, "status")
        return self.meaning.role == role


def candidate_of(table: Table, name: str, is_nameless: bool) -> Candidate | None:
    """Return a column as a candidate; None for times of other columns and for what is too short or no numbers."""
    values = table.columns[name]
    if name in table.stamps.values() or values.size < 20:
        return None
    finite = np.isfinite(values)
    if not finite.any():
        return None
    filled = values if finite.all() else np.where(finite, values, np.median(values[finite]))
    unit, told_by, unknown = table.units.get(name, ""), "header", table.unknown_unit(name)
    if not unit or unknown:
        unit, told_by = unit_in_name(name), "name"
    about = table.about.get(name, "")
    meaning = Meaning() if is_nameless else meaning_of(name, about)
    return Candidate(name, filled, unit, told_by if unit else "", meaning, axis_in(name) or axis_in(about), unknown)


def time_among(table: Table, columns: list[Candidate]) -> tuple[Candidate, str] | None:
    """Return the column of time, and why it is one; None where there is none, or each column brings its own."""
    if table.stamps:
        return None
    rises = {column.name: float(np.mean(np.diff(column.values) > 0.0)) for column in columns}
    rising = [column for column in columns if rises[column.name] > 0.5 and column.values[-1] > column.values[0]]
    called = [column for column in columns if column.meaning.role == "time" and is_time(column.name)]
    # Stamps of a host that repeat rise with halts.
    # 0.02 of the steps of a time that rise: fewer are no stamps of samples
    halting = [column for column in called if np.all(np.diff(column.values) >= 0.0) and rises[column.name] >= 0.02]
    called = [column for column in called if column in rising or column in halting]
    named = [column for column in called if not column.unit or column.is_one_of(("s",))]
    named += [column for column in rising if column.is_one_of(("s",)) and column not in named]
    for column in rising if not named and table.sample_time is None else ():
        step = np.diff(column.values)
        # One that no name tells rises evenly; without a halt, if it is not the first.
        even = np.quantile(np.abs(step - np.median(step)), 0.95) <= 0.05 * np.median(step)
        untold = column.meaning.role in ("", "status") if column is columns[0] else not column.meaning.role and np.all(step > 0.0)
        if even and untold and not column.unit and not column.unknown and not np.all(step == 1.0):
            named.append(column)
    return (named[0], "its name" if named[0] in called else "it rises evenly") if named else None


EDGE = 20


def rate_of(position: np.ndarray, times: np.ndarray | None) -> np.ndarray:
    """Return the smoothed rate of a signal over time, or over its samples where there is no time."""
    from scipy.ndimage import uniform_filter1d

    width = int(np.clip(position.size // 2000, 3, 15))
    smooth = uniform_filter1d(position, width)
    if times is None or times.size != position.size:
        return np.gradient(smooth)
    even = np.linspace(times[0], times[-1], times.size)
    steps = np.gradient(even)
    return np.gradient(smooth) / (steps if np.all(steps > 1e-15) else 1.0)  # of the unit of time, from sample to sample: less is no time


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return the correlation of two signals, 0 where one of them stands still."""
    if first.size != second.size or first.size < EDGE:
        return 0.0
    sized = []
    for signal in (first, second):  # 1 at most: its squares are neither too large nor too small for a number
        about = signal - signal.mean()
        largest = float(np.max(np.abs(about)))
        sized.append(about / largest if largest > 0.0 else about)
    a, b = sized
    scale = float(np.sqrt(np.dot(a, a) * np.dot(b, b)))
    return float(np.dot(a, b)) / scale if scale > 0.0 else 0.0


def slope(first: np.ndarray, second: np.ndarray) -> float:
    """Return by what `first` is multiplied to be `second`, but for a constant."""
    a, b = first - first.mean(), second - second.mean()
    scale = float(np.dot(a, a))
    return float(np.dot(a, b)) / scale if scale > 0.0 else 0.0


def roughness(values: np.ndarray) -> float:
    """Return the size of the second differences of a signal over that of the first ones."""
    first, second = np.diff(values), np.diff(values, 2)
    scale = float(np.std(first))
    return float(np.std(second)) / scale if scale > 0.0 else np.inf


def explained(effort: np.ndarray, position: np.ndarray) -> float:
    """Return which share of a signal inertia, friction and a constant along a motion explain."""
    rest = _left(effort, [*_moving(position), position])
    return 1.0 - float(np.var(rest)) / (float(np.var(effort)) or 1.0)


def pulls_as_a_link(effort: np.ndarray, angle: np.ndarray) -> bool:
    """Return whether an effort goes with sine and cosine of an angle [rad], and more so than with a parabola of it."""
    # 1.0 [rad], over which the sine of an angle is more than a straight line
    if effort.size != angle.size or effort.size < 4 * EDGE or float(np.ptp(angle)) < 1.0:
        return False
    within = slice(EDGE, -EDGE)  # the rates of the first and the last samples are those of a jump
    motion = [column[within] for column in _moving(angle)]
    effort, angle = effort[within], angle[within]
    place = angle - angle.mean()
    alone, parabola, link = (
        float(np.var(_left(effort, [*motion, *more]))) for more in ((), (place, place**2), (np.sin(angle), np.cos(angle)))
    )
    # 0.25 of what motion leaves of an effort, that the angle must tell; a parabola along it must leave more still
    return link < (1.0 - 0.25) * min(alone, parabola)


def _moving(position: np.ndarray) -> list[np.ndarray]:
    """Return what inertia and friction do along a motion."""
    velocity = rate_of(position, None)
    sliding = np.sign(velocity) * (np.abs(velocity) > 0.02 * np.max(np.abs(velocity)))
    return [rate_of(velocity, None), velocity, sliding]


def _left(effort: np.ndarray, columns: list[np.ndarray]) -> np.ndarray:
    """Return what some columns and a constant leave of a signal."""
    scaled = [column / (np.std(column) or 1.0) for column in columns]
    design = np.column_stack([*scaled, np.ones(effort.size)])
    return effort - design @ unbounded(design, effort)
