"""What checks of a log compute with: motion and effort behind one short filter, lines through them, work, lost rows, pile-ups.

The filter is three moving means, so that velocity and acceleration are exact differences of the position, and the
effort passes the very same filter. It is no treatment for a fit: it only has to be the same for all channels.
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
FEWEST_ROWS = 120  # of a line, and steps of a segment in which lost rows are looked for
SINGULAR = 1e9  # condition from which columns are not told apart


STRIDE = 10  # samples over which the velocity at an end is taken

BELOW = 2.0  # widths below the pile, with which it is compared


class Rows(NamedTuple):
    """Channels of a log behind one filter, shape (row,), in SI; what was not recorded is empty."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    rate: np.ndarray
    recorded: np.ndarray

    @property
    def sliding(self) -> Rows:
        """The rows that slide."""
        speed = np.abs(self.velocity)
        return self.of(speed > 0.05 * speed.max(initial=0.0))  # of the largest speed: below, a contact sticks or turns

    def of(self, chosen: np.ndarray) -> Rows:
        """Return some of the rows."""
        return Rows(*(column[chosen] if column.size else column for column in self))


@dataclass(frozen=True)
class Line:
    """A line through columns: its coefficients, their standard errors by leaving out blocks, and what it explains."""

    coefficients: np.ndarray
    deviations: np.ndarray
    explained: float

    @classmethod
    def through(cls, columns: np.ndarray, effort: np.ndarray) -> Line | None:
        """Return the line; None where the rows are too few or tell the columns not apart."""
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
        deviations = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((left - left.mean(axis=0)) ** 2, axis=0))
        residual, total = effort - scaled @ coefficients, float(np.var(effort))
        return cls(coefficients / size, deviations / size, 1.0 - float(np.mean(residual**2)) / total if total > 0.0 else 0.0)

    @property
    def last(self) -> tuple[float, float]:
        """The coefficient of the last column and its standard error."""
        return float(self.coefficients[-1]), float(self.deviations[-1])


def rows_of(log: LogData, resolution: float) -> Rows:
    """Return the rows of a log, through twice the shortest filter that its position allows."""
    # 0.05 [s] of one moving mean: beyond, ramps of velocity are blurred
    window = longest = max((w for w in WINDOWS if w * log.sample_time <= 0.05), default=WINDOWS[0])
    for window in WINDOWS:
        parts = [_differenced(log.position.values[segment], window, 2) for segment in log.segments]
        square = float(np.mean(np.concatenate(parts) ** 2)) if any(part.size for part in parts) else 0.0
        # White noise of an encoder's rounding, twice differenced over the window.
        # 0.1 of the root mean square acceleration that the noise of the position may leave
        if window == longest or 6.0 * resolution**2 / 12.0 / window < 0.1**2 * square:
            break
    return _filtered(log, 2 * window)


def _differenced(values: np.ndarray, window: int, order: int) -> np.ndarray:
    """Return the `order`-th difference over the window of a signal behind what is left of three moving means."""
    # Each mean shortens the signal by its window less one.
    if values.size < 3 * window + 1:
        return np.empty(0)
    for _ in range(3 - order):
        total = np.concatenate([[0.0], np.cumsum(values - values[0])])
        values = (total[window:] - total[:-window]) / window + values[0]
    for _ in range(order):
        values = values[window:] - values[:-window]
    return values


def _filtered(log: LogData, window: int) -> Rows:
    stride, h = max(window // 2, len(log) // 6000, 1), window * log.sample_time  # more tell nothing more
    parts = []
    for segment in log.segments:
        first, last, _ = segment.indices(len(log))
        count = last - first - 3 * window - 2
        if count < 1:
            continue

        def behind(signal: np.ndarray | None, order: int, count: int = count) -> np.ndarray:
            """Return differences of any order, brought to one place: that of order n lies (3 - n) / 2 samples before it."""
            values = np.empty(0) if signal is None else _differenced(signal, window, order)
            if order == 1:
                return 0.5 * (values[1 : count + 1] + values[2 : count + 2])
            return values[1 : count + 1] if order == 2 else values[2 : count + 2]

        x, u, v = (None if channel is None else channel.values[segment] for channel in (log.position, log.effort, log.velocity))
        assert x is not None
        about = x[0]
        time = log.time.values[first] + log.sample_time * (np.arange(1, count + 1) + 1.5 * window - 0.5)
        motion = (behind(x - about, 0) + about, behind(x - about, 1) / h, behind(x - about, 2) / h**2)
        parts.append([signal[::stride] for signal in (time, *motion, behind(u, 0), behind(u, 1) / h, behind(v, 0))])
    return Rows(*(np.concatenate(column) for column in zip(*parts, strict=True))) if parts else Rows(*[np.empty(0)] * 7)


def lost_in(log: LogData, resolution: float, factor: float = 8.0) -> np.ndarray:
    """Return the samples before steps of the position that the velocity around does not explain, shape (place,).

    A step stands out where it differs from the steps next to it by far more than those do among themselves, and by
    more than the whole log does elsewhere.
    """
    places = [np.empty(0, dtype=int)]
    for segment in log.segments:
        steps = np.diff(log.position.values[segment])
        if steps.size < FEWEST_ROWS:
            continue
        beside = np.stack([steps[:-4], steps[1:-3], steps[3:-1], steps[4:]])
        inner, around, spread = steps[2:-2], beside.mean(axis=0), np.ptp(beside, axis=0)
        out = np.abs(inner - around)
        usual = float(np.quantile(out, 0.95))  # quantile of how steps differ from those around them
        # 1.8 times the steps around it that a step over a missing row is; less is a sample that was late
        at = np.flatnonzero((out > factor * np.maximum(spread, max(usual, resolution))) & (np.abs(inner) > 1.8 * np.abs(around)))
        # Jumps of one size are those of a counter that starts anew.
        # 0.001 of the steps: what stands out more often is how this axis moves, unless it is always the same
        # 0.1 relative, by which the jumps of one counter differ
        if at.size and (at.size < 0.001 * steps.size + 3 or np.ptp(out[at]) < 0.1 * np.median(out[at])):
            places.append(at + 2 + (segment.start or 0))
    return np.concatenate(places)


def work_share(log: LogData) -> float:
    """Return the work that the effort does over closed motion, over what it would be if all of it were friction.

    The integral of effort over way from one sample to a later one at the same place and speed: inertia, gravity and
    springs give back what they took, whatever they are. No model is fitted, and where friction has not saturated the
    loop of effort over position has an area too.
    """
    work, total = 0.0, 0.0
    for segment in log.segments if log.effort is not None else ():
        assert log.effort is not None
        ends = _closed(log.position.values[segment])
        x, u = log.position.values[segment][ends], log.effort.values[segment][ends]
        if x.size < 2:
            continue
        steps = np.diff(x)
        # What is left of the way is not for a constant force to answer.
        middle = 0.5 * (u[:-1] + u[1:]) - np.mean(u)
        work += float(middle @ steps)
        total += float(np.abs(middle) @ np.abs(steps))
    return work / total if total > 0.0 else 0.0


def _closed(position: np.ndarray) -> slice:
    """Return the longest closed motion of a segment, both ends included; an empty one where there is none."""
    reach = float(np.ptp(position)) if position.size >= 4 * STRIDE else 0.0
    if reach == 0.0:
        return slice(0)
    at = np.unique(np.linspace(STRIDE, position.size - 1 - STRIDE, 200).astype(int))  # of a segment, of which pairs are compared
    x, speed = position[at], position[at + STRIDE] - position[at - STRIDE]
    fastest = float(np.max(np.abs(position[2 * STRIDE :] - position[: -2 * STRIDE])))
    energy = (speed / (fastest or 1.0)) ** 2
    apart = np.abs(x[:, None] - x[None, :]) / reach + np.abs(energy[:, None] - energy[None, :])
    # 0.02 of range and largest kinetic energy: what two ends of a closed motion may differ by
    length = np.where(apart < 0.02, at[None, :] - at[:, None], 0)
    first, last = np.unravel_index(int(np.argmax(length)), length.shape)
    # The motion turned in between, or it would not be back.
    # 0.25 of a segment: a closed motion that says something of it
    return slice(at[first], at[last] + 1) if fastest and length[first, last] >= 0.25 * position.size else slice(0)


def piled_up(log: LogData, rows: Rows, resolution: float, run: int, sure: float) -> Cut | None:
    """Return where an effort piles up near its extreme although the motion takes more of it; None where none does.

    A drive at its limit piles up too, and its effort is the one that acts: there inertia times acceleration is what it
    was elsewhere.
    """
    assert log.effort is not None
    values = log.effort.values
    at = sum((side * _piled(side * values, run) for side in (1.0, -1.0)), np.zeros(values.size))
    if not at.any():
        return None
    # The missing effort passes the filter of all rows.
    missing = rows_of(replace(log, effort=replace(log.effort, values=at)), resolution).effort
    level = float(np.median(np.abs(values[at != 0.0])))
    columns = (rows.acceleration, rows.velocity, np.sign(rows.velocity), np.ones_like(rows.velocity))
    line, bent = (Line.through(np.column_stack([*columns, shape]), rows.effort) for shape in (-missing, rows.effort**3))
    # A channel that bends over does not end at once; what it lacks goes with the cube of what it reads.
    if line is None or (bent is not None and bent.explained > line.explained):
        return None
    short, error = line.last
    if not (short > 0.05 * level and short > sure * error):  # of the level: what the motion asks for beyond it
        return None
    start, length = longest_run(at != 0.0)
    return Cut(float(np.sign(at[start])) * level, start, length, int(np.count_nonzero(at)))


def _piled(values: np.ndarray, run: int) -> np.ndarray:
    """Return which samples lie near the largest, where they do far more often and for longer than below; else none."""
    none = np.zeros(values.size, dtype=bool)
    if np.count_nonzero(values > 0.0) < run:
        return none
    top = float(np.quantile(values[values > 0.0], 0.999))  # quantile of a side: single samples beyond are noise
    width = float(np.clip(6.0 * noise_of(values), 0.02 * top, 0.08 * top))  # of the noise, and of the top: the width of a pile below it
    near, low = top - width, top - (1.0 + BELOW) * width
    at, below = values > near, (values > low) & (values <= near)
    # 3.0 than below is a pile; a sine has 2.7
    return at if longest_run(at)[1] >= run and np.count_nonzero(at) * BELOW >= 3.0 * np.count_nonzero(below) else none
