"""Where a motion rests, turns and repeats: changes of direction, those that are more than noise, and half-cycles between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def reversals(velocity: np.ndarray, *, sided: bool = False) -> np.ndarray:
    """Return the first sample after each change of direction, whatever the way between two of them.

    Examples
    --------
    >>> reversals(np.array([1.0, 0.0, -1.0, 0.0, -1.0, 1.0]))
    array([2, 5])
    >>> reversals(np.array([1.0, -0.0, -1.0, 0.0, -1.0, 1.0]), sided=True)
    array([1, 3, 4, 5])
    """
    if sided:
        return np.flatnonzero(np.diff(np.signbit(velocity))) + 1
    side = np.sign(velocity)
    moving = np.flatnonzero(side)
    return moving[1:][side[moving[1:]] != side[moving[:-1]]]


def turning_points(position: np.ndarray, least: float = 0.0, candidates: Sequence[int] | None = None) -> list[int]:
    """Return the samples at which the motion turns by more than `least` [m or rad], ends not included.

    Of a motion that goes to and fro by less, the farthest sample counts. It is looked for among all samples, or among
    `candidates` in order, as reversals of a velocity are.
    """
    turns: list[int] = []
    side, extreme = 0.0, 0
    for k in [*(reversals(np.diff(position)).tolist() if candidates is None else candidates), position.size - 1]:
        change = position[k] - position[extreme]
        if side * change > 0.0:
            extreme = k
        elif abs(change) > least:
            if side != 0.0:
                turns.append(extreme)
            side, extreme = float(np.sign(change)), k
    return turns


def numbered(turns: Sequence[int] | np.ndarray, count: int) -> np.ndarray:
    """Return the number of the half-cycle of each of `count` samples; a turn is the first sample of the next one.

    Examples
    --------
    >>> numbered([2, 3], 5)
    array([0, 0, 1, 2, 2])
    """
    return np.searchsorted(turns, np.arange(count), side="right")


def half_cycle_numbers(turns: Sequence[Sequence[int]], counts: Sequence[int]) -> list[np.ndarray]:
    """Return the number of the half-cycle of each sample of several segments, counted through all of them."""
    first = np.cumsum([0, *(len(places) + 1 for places in turns)]).tolist()
    return [start + numbered(places, count) for start, places, count in zip(first[:-1], turns, counts, strict=True)]


def runs(inside: np.ndarray) -> list[slice]:
    """Return the runs of samples that are true, in order.

    Examples
    --------
    >>> runs(np.array([True, True, False, True]))
    [slice(0, 2, None), slice(3, 4, None)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8))).tolist()
    return [slice(first, stop) for first, stop in zip(edges[::2], edges[1::2], strict=True)]


def rests(position: np.ndarray, window: int, step: float) -> np.ndarray:
    """Return the windows in which the position goes no further than a step, shape (sample,) of bool.

    From its middle to either end, because around a turning point both ends are alike though the body moves.
    """
    padded = np.pad(position, window, mode="edge")
    before, after = padded[: -2 * window], padded[2 * window :]
    middles = (np.abs(after - position) <= step) & (np.abs(position - before) <= step)
    counted = np.concatenate([[0], np.cumsum(np.pad(middles, window))])
    return counted[2 * window + 1 :] > counted[: -2 * window - 1]


def with_sides(velocity: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the velocity with a zero at rest, which carries the sign of the last motion.

    Examples
    --------
    >>> with_sides(np.array([0.1, -1.0, 0.1, 2.0]), np.array([True, False, True, False]))
    array([-0., -1., -0.,  2.])
    """
    if rest.all():
        return np.zeros_like(velocity)
    last = np.maximum.accumulate(np.where(rest, int(np.argmin(rest)), np.arange(velocity.size)))
    return np.where(rest, np.copysign(0.0, velocity[last]), velocity)


def whole_cycle(position: np.ndarray, velocity: np.ndarray) -> int | None:
    """Return after how many samples a motion that repeats is where it began, and moves on alike; None if it never is.

    Examples
    --------
    >>> phase = 2.0 * np.pi * np.arange(25) / 10.0
    >>> whole_cycle(np.sin(phase), np.cos(phase))
    10
    """
    covered = np.maximum.accumulate(position) - np.minimum.accumulate(position)
    away = np.abs(position - position[0])
    back = (covered > 0.9 * covered[-1]) & (away < 0.02 * covered[-1])  # of the range: a whole cycle is through, the motion is back
    back &= np.signbit(velocity) == np.signbit(velocity[0])
    if not back.any():
        return None
    first = int(np.argmax(back))
    stay = int(np.argmin(back[first:])) or back.size - first
    return first + int(np.argmin(away[first : first + stay]))


def period_of(position: np.ndarray, sample_time: float, correlated: float, periods: float) -> float | None:
    """Return the period [s] of a motion that, from so many periods on, correlates with itself so well; None where it has none."""
    x = position - np.mean(position)
    product, late, early = (part[x.size - 1 :] for part in by_lag(x, x)[1:])
    size = np.sqrt(late * early)
    correlation = np.divide(product, size, out=np.zeros_like(size), where=size > 0.0)
    below, last = np.flatnonzero(correlation < 0.0), int(x.size / periods)
    if not below.size or below[0] >= last:
        return None
    beyond = correlation[below[0] : last]
    if not np.max(beyond) >= correlated:
        return None
    first = int(np.argmax(beyond >= correlated * np.max(beyond)))
    period = first + int(np.argmax(beyond[first : first + (below[0] + first) // 2]))
    return float((below[0] + period) * sample_time)


def by_lag(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return for each lag of `x` behind `y` how many samples both share, their product and their squares there."""
    from scipy.signal import correlate, correlation_lags

    lag = correlation_lags(x.size, y.size)
    first, last = np.maximum(lag, 0), np.minimum(x.size, y.size + lag)
    xx, yy = (np.concatenate([[0.0], np.cumsum(signal * signal)]) for signal in (x, y))
    return last - first, np.asarray(correlate(x, y, method="fft")), xx[last] - xx[first], yy[last - lag] - yy[first - lag]
