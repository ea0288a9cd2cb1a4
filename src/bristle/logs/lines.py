"""Numerics of the checks of a log: motion and effort after a short filter, regression lines, work, lost rows, pile-ups.

Three moving means make velocity and acceleration exact differences of the position. The effort passes the same filter.
The checks need the same filter on all channels; a fit has a better treatment.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.logs.channel import LogData
from bristle.logs.problems import Cut, longest_run
from bristle.logs.turns import noise_of

WINDOWS = (2, 4, 8, 16, 32, 64, 128)  # samples of one moving mean
BLOCKS = 12  # of time, each left out in turn
FEWEST_ROWS = 120  # of a line; also steps of a segment searched for lost rows
SINGULAR = 1e9  # condition number above which columns count as collinear


STRIDE = 10  # samples for the velocity at an end

BELOW = 2.0  # widths below the pile, for comparison


class Rows(NamedTuple):
    """Channels of a log after one filter, shape (row,), in SI; empty if not recorded."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    rate: np.ndarray
    recorded: np.ndarray

    @property
    def sliding(self) -> Rows:
        """Rows in which the axis slides."""
        speed = np.abs(self.velocity)
        # Of the largest speed: below, a contact sticks or turns.
        return self.of(speed > 0.05 * speed.max(initial=0.0))

    def of(self, chosen: np.ndarray) -> Rows:
        """Return the chosen rows."""
        return Rows(*(column[chosen] if column.size else column for column in self))


@dataclass(frozen=True)
class Line:
    """A regression line: coefficients, their standard errors by leaving out blocks, and explained effort."""

    coefficients: np.ndarray
    deviations: np.ndarray
    explained: float

    @classmethod
    def through(cls, columns: np.ndarray, effort: np.ndarray) -> Line | None:
        """Return the line; None if there are too few rows or the columns are collinear."""
        size = np.sqrt(np.mean(columns**2, axis=0)) if effort.size >= FEWEST_ROWS else np.zeros(1)
        if not np.all(size > 0.0):
            return None
        scaled = columns / size
        parts = np.array_split(np.arange(effort.size), BLOCKS)
        grams = np.stack([scaled[part].T @ scaled[part] for part in parts])
        rights = np.stack([scaled[part].T @ effort[part] for part in parts])
        gram, right = grams.sum(axis=0), rights.sum(axis=0)
        without = gram - grams
        if np.linalg.cond(gram) > SINGULAR or np.linalg.cond(without).max() > SINGULAR:
            return None
        coefficients = np.linalg.solve(gram, right)
        left = np.linalg.solve(without, (right - rights)[..., None])[..., 0]
        deviations = np.sqrt(
            (BLOCKS - 1) / BLOCKS * np.sum((left - left.mean(axis=0)) ** 2, axis=0)
        )
        residual, total = effort - scaled @ coefficients, float(np.var(effort))
        return cls(
            coefficients / size,
            deviations / size,
            1.0 - float(np.mean(residual**2)) / total if total > 0.0 else 0.0,
        )

    @property
    def last(self) -> tuple[float, float]:
        """Coefficient of the last column and its standard error."""
        return float(self.coefficients[-1]), float(self.deviations[-1])


def rows_of(log: LogData, resolution: float) -> Rows:
    """Return the rows of a log, after twice the shortest filter that its position allows."""
    # At most 0.05 [s] per moving mean: longer means blur ramps of the velocity.
    window = longest = max((w for w in WINDOWS if w * log.sample_time <= 0.05), default=WINDOWS[0])
    for window in WINDOWS:
        parts = [_differenced(log.position.values[segment], window, 2) for segment in log.segments]
        square = (
            float(np.mean(np.concatenate(parts) ** 2)) if any(part.size for part in parts) else 0.0
        )
        # White noise of encoder rounding, differenced twice over the window.
        # The position noise may leave 0.1 of the root mean square acceleration.
        if window == longest or 6.0 * resolution**2 / 12.0 / window < 0.1**2 * square:
            break
    return _filtered(log, 2 * window)


def _differenced(values: np.ndarray, window: int, order: int) -> np.ndarray:
    """Return the `order`-th difference of a signal over the window, after the remaining of three moving means."""
    # Each mean shortens the signal by its window minus 1.
    if values.size < 3 * window + 1:
        return np.empty(0)
    for _ in range(3 - order):
        total = np.concatenate([[0.0], np.cumsum(values - values[0])])
        values = (total[window:] - total[:-window]) / window + values[0]
    for _ in range(order):
        values = values[window:] - values[:-window]
    return values


def _filtered(log: LogData, window: int) -> Rows:
    # More rows add no information.
    stride, h = (max(window // 2, len(log) // 6000, 1), window * log.sample_time)
    parts = []
    for segment in log.segments:
        first, last, _ = segment.indices(len(log))
        count = last - first - 3 * window - 2
        if count < 1:
            continue

        def behind(signal: np.ndarray | None, order: int, count: int = count) -> np.ndarray:
            """Return differences of any order, aligned: those of order n lie (3 - n) / 2 samples earlier."""
            values = np.empty(0) if signal is None else _differenced(signal, window, order)
            if order == 1:
                return 0.5 * (values[1 : count + 1] + values[2 : count + 2])
            return values[1 : count + 1] if order == 2 else values[2 : count + 2]

        x, u, v = (
            None if channel is None else channel.values[segment]
            for channel in (log.position, log.effort, log.velocity)
        )
        assert x is not None
        about = x[0]
        time = log.time.values[first] + log.sample_time * (
            np.arange(1, count + 1) + 1.5 * window - 0.5
        )
        motion = (
            behind(x - about, 0) + about,
            behind(x - about, 1) / h,
            behind(x - about, 2) / h**2,
        )
        parts.append(
            [
                signal[::stride]
                for signal in (time, *motion, behind(u, 0), behind(u, 1) / h, behind(v, 0))
            ]
        )
    return (
        Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        if parts
        else Rows(*[np.empty(0)] * 7)
    )


def lost_in(log: LogData, resolution: float, factor: float = 8.0) -> np.ndarray:
    """Return the samples before steps of the position that the velocity around does not explain, shape (place,)."""
    # The step across a lost row differs by far more than its neighbours from each other, and by more than other steps of the
    # log.
    places = [np.empty(0, dtype=int)]
    for segment in log.segments:
        steps = np.diff(log.position.values[segment])
        if steps.size < FEWEST_ROWS:
            continue
        beside = np.stack([steps[:-4], steps[1:-3], steps[3:-1], steps[4:]])
        inner, around, spread = steps[2:-2], beside.mean(axis=0), np.ptp(beside, axis=0)
        out = np.abs(inner - around)
        usual = float(np.quantile(out, 0.95))  # quantile of the difference from the steps around
        # A step over a missing row is at least 1.8 times the steps around it; a smaller step is a late sample.
        at = np.flatnonzero(
            (out > factor * np.maximum(spread, max(usual, resolution)))
            & (np.abs(inner) > 1.8 * np.abs(around))
        )
        # Jumps of equal size are the overflow of a counter.
        # Share of outliers above which they belong to the motion of the axis, unless all are equal: 0.001.
        # Relative tolerance of the jumps of a counter: 0.1.
        if at.size and (
            at.size < 0.001 * steps.size + 3 or np.ptp(out[at]) < 0.1 * np.median(out[at])
        ):
            places.append(at + 2 + (segment.start or 0))
    return np.concatenate(places)


def work_share(log: LogData) -> float:
    """Return the work of the effort over closed motion, divided by that of an effort that is friction only."""
    # Effort over travel from one sample to a later one at the same position and speed: inertia, gravity and springs return
    # the work that they take. The loop of effort over position has an area even where friction has not saturated.
    work, total = 0.0, 0.0
    for segment in log.segments if log.effort is not None else ():
        assert log.effort is not None
        ends = _closed(log.position.values[segment])
        x, u = log.position.values[segment][ends], log.effort.values[segment][ends]
        if x.size < 2:
            continue
        steps = np.diff(x)
        # Keep a constant force out of the work over the remaining travel.
        middle = 0.5 * (u[:-1] + u[1:]) - np.mean(u)
        work += float(middle @ steps)
        total += float(np.abs(middle) @ np.abs(steps))
    return work / total if total > 0.0 else 0.0


def _closed(position: np.ndarray) -> slice:
    """Return the longest closed motion of a segment, both ends included; an empty slice if there is none."""
    reach = float(np.ptp(position)) if position.size >= 4 * STRIDE else 0.0
    if reach == 0.0:
        return slice(0)
    # Samples of a segment, compared in pairs.
    at = np.unique(np.linspace(STRIDE, position.size - 1 - STRIDE, 200).astype(int))
    x, speed = position[at], position[at + STRIDE] - position[at - STRIDE]
    fastest = float(np.max(np.abs(position[2 * STRIDE :] - position[: -2 * STRIDE])))
    energy = (speed / (fastest or 1.0)) ** 2
    apart = np.abs(x[:, None] - x[None, :]) / reach + np.abs(energy[:, None] - energy[None, :])
    # Tolerance of the ends of a closed motion: 0.02 of the range and of the largest kinetic energy.
    length = np.where(apart < 0.02, at[None, :] - at[:, None], 0)
    first, last = np.unravel_index(int(np.argmax(length)), length.shape)
    # A closed motion contains a reversal.
    # It covers at least 0.25 of a segment.
    return (
        slice(at[first], at[last] + 1)
        if fastest and length[first, last] >= 0.25 * position.size
        else slice(0)
    )


def piled_up(log: LogData, rows: Rows, resolution: float, run: int, sure: float) -> Cut | None:
    """Return the pile-up of an effort near its extreme while the motion needs more effort; None if there is no pile-up."""
    # The effort of a drive at its limit piles up too, but inertia times acceleration matches the rest of the log.
    assert log.effort is not None
    values = log.effort.values
    at = sum((side * _piled(side * values, run) for side in (1.0, -1.0)), np.zeros(values.size))
    if not at.any():
        return None
    # Filter the missing effort like all rows.
    missing = rows_of(replace(log, effort=replace(log.effort, values=at)), resolution).effort
    level = float(np.median(np.abs(values[at != 0.0])))
    columns = (
        rows.acceleration,
        rows.velocity,
        np.sign(rows.velocity),
        np.ones_like(rows.velocity),
    )
    line, bent = (
        Line.through(np.column_stack([*columns, shape]), rows.effort)
        for shape in (-missing, rows.effort**3)
    )
    # A channel that saturates gradually lacks an effort proportional to the cube of its reading.
    if line is None or (bent is not None and bent.explained > line.explained):
        return None
    short, error = line.last
    # Of the level: extra effort that the motion needs.
    if not (short > 0.05 * level and short > sure * error):
        return None
    start, length = longest_run(at != 0.0)
    return Cut(float(np.sign(at[start])) * level, start, length, int(np.count_nonzero(at)))


def _piled(values: np.ndarray, run: int) -> np.ndarray:
    """Return the samples near the largest, if they are far more frequent, and their runs longer, than samples below; else no samples."""
    none = np.zeros(values.size, dtype=bool)
    if np.count_nonzero(values > 0.0) < run:
        return none
    # Quantile of one sign: single samples beyond are noise.
    top = float(np.quantile(values[values > 0.0], 0.999))
    # Width of a pile, by noise and by the top value.
    width = float(np.clip(6.0 * noise_of(values), 0.02 * top, 0.08 * top))
    near, low = top - width, top - (1.0 + BELOW) * width
    at, below = values > near, (values > low) & (values <= near)
    # A pile holds at least 3.0 times the samples below; a sine reaches 2.7.
    if longest_run(at)[1] >= run and np.count_nonzero(at) * BELOW >= 3.0 * np.count_nonzero(below):
        return at
    return none
