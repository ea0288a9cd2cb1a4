"""A log in rows for checks: motion and effort behind one and the same short filter, and what a line through them says.

The filter is three moving means, so that velocity and acceleration are exact differences of the position, and the
effort passes the very same filter. It is no treatment for a fit: it only has to be the same for all channels.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from bristle.logs.channel import LogData

__all__ = ["Line", "Rows", "rows_of"]

WINDOWS = (2, 4, 8, 16, 32, 64, 128)  # samples of one moving mean
LONGEST = 0.05  # [s] of one moving mean: beyond, ramps of velocity are blurred
NOISE = 0.1  # of the root mean square acceleration that the noise of the position may leave
SLOW = 0.05  # of the largest speed: below, a contact sticks or turns
MOST = 6000  # rows: more tell nothing more
BLOCKS = 12  # of time, each left out in turn
FEWEST = 120  # rows of a line


@dataclass(frozen=True)
class Rows:
    """Channels of a log behind one filter, shape (row,); what was not recorded is empty.

    Time [s], position, velocity and acceleration, the effort and its rate, and the velocity as it was recorded.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    rate: np.ndarray
    recorded: np.ndarray

    @property
    def sliding(self) -> np.ndarray:
        """Which rows slide, shape (row,) of bool."""
        speed = np.abs(self.velocity)
        return speed > SLOW * speed.max(initial=0.0)

    def of(self, chosen: np.ndarray) -> Rows:
        """Return some of the rows."""
        columns = (getattr(self, field.name) for field in fields(self))
        return Rows(*(column[chosen] if column.size else column for column in columns))


@dataclass(frozen=True)
class Line:
    """A line through columns: its coefficients, their standard errors by leaving out blocks, and what it leaves."""

    coefficients: np.ndarray
    deviations: np.ndarray
    predicted: np.ndarray
    residual: np.ndarray

    @classmethod
    def through(cls, columns: np.ndarray, effort: np.ndarray) -> Line | None:
        """Return the line; None where the rows are too few or tell the columns not apart."""
        if effort.size < FEWEST:
            return None
        size = np.sqrt(np.mean(columns**2, axis=0))
        if not np.all(size > 0.0):
            return None
        scaled = columns / size
        parts = np.array_split(np.arange(effort.size), BLOCKS)
        grams = np.stack([scaled[part].T @ scaled[part] for part in parts])
        rights = np.stack([scaled[part].T @ effort[part] for part in parts])
        gram, right = grams.sum(axis=0), rights.sum(axis=0)
        if np.linalg.cond(gram) > 1e9:
            return None
        without = gram - grams
        if np.linalg.cond(without).max() > 1e9:
            return None
        coefficients = np.linalg.solve(gram, right)
        left = np.linalg.solve(without, (right - rights)[..., None])[..., 0]
        deviations = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((left - left.mean(axis=0)) ** 2, axis=0))
        predicted = scaled @ coefficients
        return cls(coefficients / size, deviations / size, predicted, effort - predicted)

    @property
    def explained(self) -> float:
        """Share of the scatter of the effort that the line explains."""
        total = float(np.var(self.predicted + self.residual))
        return 1.0 - float(np.mean(self.residual**2)) / total if total > 0.0 else 0.0


def rows_of(log: LogData, resolution: float) -> Rows:
    """Return the rows of a log, through twice the shortest filter that its position allows."""
    windows = [w for w in WINDOWS if w * log.sample_time <= LONGEST] or [WINDOWS[0]]
    chosen = windows[-1]
    for window in windows:
        parts = [_differenced(log.position.values[segment], window, 2) for segment in log.segments]
        square = float(np.mean(np.concatenate(parts) ** 2)) if any(part.size for part in parts) else 0.0
        # White noise of an encoder's rounding, twice differenced over the window.
        if 6.0 * resolution**2 / 12.0 / window < NOISE**2 * square:
            chosen = window
            break
    return _filtered(log, 2 * chosen)


def _mean(values: np.ndarray, window: int, times: int) -> np.ndarray:
    """Return moving means, one after the other; each shortens the signal by its window less one."""
    for _ in range(times):
        total = np.concatenate([[0.0], np.cumsum(values - values[0])])
        values = (total[window:] - total[:-window]) / window + values[0]
    return values


def _differenced(values: np.ndarray, window: int, order: int) -> np.ndarray:
    """Return the `order`-th difference over the window of a signal behind what is left of three moving means."""
    if values.size < 3 * window + 1:
        return np.empty(0)
    values = _mean(values, window, 3 - order)
    for _ in range(order):
        values = values[window:] - values[:-window]
    return values


def _filtered(log: LogData, window: int) -> Rows:
    stride = max(window // 2, len(log) // MOST, 1)
    columns: list[list[np.ndarray]] = [[] for _ in fields(Rows)]
    for segment in log.segments:
        first, last, _ = segment.indices(len(log))
        count = last - first - 3 * window - 2
        if count < 1:
            continue
        x, u, v = (None if channel is None else channel.values[segment] for channel in (log.position, log.effort, log.velocity))
        assert x is not None
        signals = (
            log.time.values[first] + log.sample_time * (np.arange(1, count + 1) + 1.5 * window - 0.5),
            *_moving(x, count, window, log.sample_time),
            *_acting(u, count, window, log.sample_time),
            np.empty(0) if v is None else _mean(v, window, 3)[2 : count + 2],
        )
        for column, signal in zip(columns, signals, strict=True):
            column.append(signal[::stride])
    return Rows(*(np.concatenate(column) if column else np.empty(0) for column in columns))


# Sample i of a difference of order n lies (3 - n) / 2 samples before 1.5 windows after i: all are brought to one place.


def _moving(x: np.ndarray, count: int, window: int, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, velocity and acceleration."""
    h, about = window * dt, x[0]
    place, speed, acceleration = (_differenced(x - about, window, order) for order in (0, 1, 2))
    velocity = 0.5 * (speed[1 : count + 1] + speed[2 : count + 2]) / h
    return place[2 : count + 2] + about, velocity, acceleration[1 : count + 1] / h**2


def _acting(u: np.ndarray | None, count: int, window: int, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return effort and its rate."""
    if u is None:
        return np.empty(0), np.empty(0)
    effort, rate = (_differenced(u, window, order) for order in (0, 1))
    return effort[2 : count + 2], 0.5 * (rate[1 : count + 1] + rate[2 : count + 2]) / (window * dt)
