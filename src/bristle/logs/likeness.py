"""What moves like what: whether one column is the velocity of another, its reference, or the effort that moves it."""

from __future__ import annotations

import numpy as np

from bristle.core.least_squares import unbounded

__all__ = ["correlation", "explained", "pulls_as_a_link", "rate_of", "roughness", "slope"]

SMOOTHING = (3, 15)  # samples
LONG = 2000  # samples for each of them
EDGE = 20
LEAST_ANGLE = 1.0  # [rad], over which the sine of an angle is more than a straight line
PULLED = 0.25  # of what motion leaves of an effort, that the angle must tell; a parabola along it must leave more still
SHORTEST = 1e-15  # of the unit of time, from sample to sample: less is no time


def rate_of(position: np.ndarray, times: np.ndarray | None) -> np.ndarray:
    """Return the smoothed rate of a signal over time, or over its samples where there is no time."""
    from scipy.ndimage import uniform_filter1d

    width = int(np.clip(position.size // LONG, *SMOOTHING))
    smooth = uniform_filter1d(position, width)
    if times is None or times.size != position.size:
        return np.gradient(smooth)
    even = np.linspace(times[0], times[-1], times.size)
    steps = np.gradient(even)
    return np.gradient(smooth) / (steps if np.all(steps > SHORTEST) else 1.0)


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return the correlation of two signals, 0 where one of them stands still."""
    if first.size != second.size or first.size < EDGE:
        return 0.0
    a, b = _sized(first), _sized(second)
    scale = float(np.sqrt(np.dot(a, a) * np.dot(b, b)))
    return float(np.dot(a, b)) / scale if scale > 0.0 else 0.0


def _sized(signal: np.ndarray) -> np.ndarray:
    """Return a signal about its mean, 1 at most, whose squares are neither too large nor too small for a number."""
    about = signal - signal.mean()
    largest = float(np.max(np.abs(about)))
    return about / largest if largest > 0.0 else about


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
    if effort.size != angle.size or effort.size < 4 * EDGE or float(np.ptp(angle)) < LEAST_ANGLE:
        return False
    within = slice(EDGE, -EDGE)  # the rates of the first and the last samples are those of a jump
    motion = [column[within] for column in _moving(angle)]
    effort, angle = effort[within], angle[within]
    place = angle - angle.mean()
    alone, parabola, link = (
        float(np.var(_left(effort, [*motion, *more]))) for more in ((), (place, place**2), (np.sin(angle), np.cos(angle)))
    )
    return link < (1.0 - PULLED) * min(alone, parabola)


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
