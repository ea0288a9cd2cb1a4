"""Find rests, reversals and periods of a motion, and the legs between them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.core.normal import DEVIATION_OVER_MEDIAN


def reversals(velocity: np.ndarray, *, sided: bool = False) -> np.ndarray:
    """Return the first sample after each change of direction, however small the motion.

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


def turning_points(
    position: np.ndarray, least: float = 0.0, candidates: Sequence[int] | None = None
) -> list[int]:
    """Return the samples at which the motion turns by more than `least` [m or rad], of all or of the ordered `candidates`."""
    turns: list[int] = []
    side, extreme = 0.0, 0
    for k in [
        *(reversals(np.diff(position)).tolist() if candidates is None else candidates),
        position.size - 1,
    ]:
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
    """Return the number of the half-cycle of each sample of several segments, counted across all segments."""
    first = np.cumsum([0, *(len(places) + 1 for places in turns)]).tolist()
    return [
        start + numbered(places, count)
        for start, places, count in zip(first[:-1], turns, counts, strict=True)
    ]


def runs(inside: np.ndarray) -> list[slice]:
    """Return the runs of true samples, in order.

    Examples
    --------
    >>> runs(np.array([True, True, False, True]))
    [slice(0, 2, None), slice(3, 4, None)]
    """
    edges = np.flatnonzero(
        np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8))
    ).tolist()
    return [slice(first, stop) for first, stop in zip(edges[::2], edges[1::2], strict=True)]


def rests(position: np.ndarray, window: int, step: float) -> np.ndarray:
    """Return whether the position stays within a step of the centre of a window, shape (sample,)."""
    padded = np.pad(position, window, mode="edge")
    before, after = padded[: -2 * window], padded[2 * window :]
    middles = (np.abs(after - position) <= step) & (np.abs(position - before) <= step)
    counted = np.concatenate([[0], np.cumsum(np.pad(middles, window))])
    return counted[2 * window + 1 :] > counted[: -2 * window - 1]


def with_sides(velocity: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the velocity with a signed zero at rest, whose sign is that of the previous motion.

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
    """Return the count of samples of a whole cycle of a repeating motion; None if the motion does not repeat.

    Examples
    --------
    >>> phase = 2.0 * np.pi * np.arange(25) / 10.0
    >>> whole_cycle(np.sin(phase), np.cos(phase))
    10
    """
    covered = np.maximum.accumulate(position) - np.minimum.accumulate(position)
    away = np.abs(position - position[0])
    # Of the range: the motion completed a cycle and returned.
    back = (covered > 0.9 * covered[-1]) & (away < 0.02 * covered[-1])
    back &= np.signbit(velocity) == np.signbit(velocity[0])
    if not back.any():
        return None
    first = int(np.argmax(back))
    stay = int(np.argmin(back[first:])) or back.size - first
    return first + int(np.argmin(away[first : first + stay]))


LONG = 2**17  # samples above which the search for a period begins coarsely


def period_of(
    position: np.ndarray, sample_time: float, correlated: float = 0.98, periods: float = 3.0
) -> float | None:
    """Return the period [s] of a motion whose autocorrelation over several periods is high enough; None if it has no period."""
    if position.size > LONG:
        return _period_of_long(position, sample_time, correlated, periods)
    from scipy.signal import correlate

    x = position - np.mean(position)
    sums = np.concatenate([[0.0], np.cumsum(x * x)])
    product, size = (
        np.asarray(correlate(x, x, method="fft"))[x.size - 1 :],
        np.sqrt((sums[-1] - sums[:-1]) * sums[:0:-1]),
    )
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


def _period_of_long(
    position: np.ndarray, sample_time: float, correlated: float, periods: float
) -> float | None:
    """Return the period [s] of a long motion: a short period from its first samples, a long one from every n-th sample."""
    step = -(-position.size // LONG)
    for part, stride in ((position[:LONG], 1), (position[::step], step)):
        rough = period_of(part, stride * sample_time, correlated, periods)
        if rough is None:
            continue
        middle, reach = round(rough / sample_time), stride - 1
        lags = range(max(middle - reach, 1), middle + reach + 1)
        lag = min(lags, key=lambda lag: float(np.mean((position[lag:] - position[:-lag]) ** 2)))
        if np.corrcoef(position[lag:], position[:-lag])[0, 1] >= correlated:
            return lag * sample_time
    return None


CHUNKS = 20  # of a leg, each with its speed
CRUISING = 0.08  # relative deviation of the speed that counts as constant; a sine meets it for a third of its period
SETTLING = 0.03  # of the adjacent leg: shorter legs are ignored
FAST = 0.8  # quantile of the speeds of a leg that a cruise has


@dataclass(frozen=True)
class Leg:
    """A stretch in one direction, between rests or turning points."""

    first: int
    last: int
    distance: float
    duration: float
    cruise: slice
    cruise_share: float
    speed: float
    from_rest: bool


def noise_of(values: np.ndarray) -> float:
    """Return the standard deviation of noise, from second differences."""
    bends = np.abs(np.diff(values, 2))
    return DEVIATION_OVER_MEDIAN * float(np.median(bends)) / np.sqrt(6.0) if bends.size else 0.0


def graininess(position: np.ndarray, resolution: float | None) -> float:
    """Return the smallest detectable motion of a recorded position [m or rad]."""
    if resolution is None:
        steps = np.abs(np.diff(position))
        resolution = float(np.min(steps[steps > 0.0], initial=np.inf))
        resolution = resolution if np.isfinite(resolution) else 0.0
    return max(2.5 * resolution, 4.0 * noise_of(position))  # of the encoder, and of its noise


def rests_of(position: np.ndarray, grain: float, sample_time: float) -> list[slice]:
    """Return the samples of each rest: the position stays within one grain of its centre."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    window = max(round(0.12 / sample_time), 3)  # [s] without a detectable motion
    if position.size < window:
        return []
    half = window // 2
    span = maximum_filter1d(position, 2 * half + 1) - minimum_filter1d(position, 2 * half + 1)
    # Extend each rest to the ends of its windows.
    counted = np.concatenate([[0], np.cumsum(np.pad((span <= 2.0 * grain)[half:-half], 2 * half))])
    return runs(counted[2 * half + 1 :] > counted[: -2 * half - 1])


def legs_of(
    position: np.ndarray, rests: list[slice], grain: float, sample_time: float
) -> Iterator[Leg]:
    """Yield the legs between rests and turning points, without those that hardly move."""
    edges = [
        0,
        *(edge for rest in rests for edge in (rest.start, rest.stop - 1)),
        position.size - 1,
    ]
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin < 2:
            continue
        marks = [begin, *(begin + k for k in turning_points(position[begin : end + 1], grain)), end]
        marks = _without_jitter(position, marks)
        # Leave out legs next to a rest that are tiny relative to the next leg.
        lengths = [abs(position[b] - position[a]) for a, b in pairwise(marks)]
        first = len(lengths) > 1 and lengths[0] < SETTLING * lengths[1]
        last = len(lengths) > 1 and lengths[-1] < SETTLING * lengths[-2]
        marks = marks[int(first) : len(marks) - int(last)]
        for number, (first, last) in enumerate(pairwise(marks)):
            if abs(position[last] - position[first]) > grain:
                yield _leg(
                    position, first, last, grain, sample_time, from_rest=number == 0 and begin > 0
                )


def _without_jitter(position: np.ndarray, marks: list[int]) -> list[int]:
    """Return ends of legs, without legs that are tiny in length and duration relative to the adjacent leg."""
    # Near a turning point the motion is slow, and noise reverses it several times.
    remaining = np.array(marks)
    while remaining.size > 3:
        lengths, times = np.abs(np.diff(position[remaining])), np.diff(remaining)
        beside = np.where(
            lengths[:-2] > lengths[2:], np.arange(lengths.size - 2), np.arange(2, lengths.size)
        )
        inner = slice(1, -1)
        negligible = (lengths[inner] < SETTLING * lengths[beside]) & (
            times[inner] < SETTLING * times[beside]
        )
        if not negligible.any():
            break
        shortest = 1 + int(np.argmin(np.where(negligible, lengths[inner], np.inf)))
        # Without the two ends of a leg, its neighbours merge.
        remaining = np.delete(remaining, (shortest, shortest + 1))
    return [int(k) for k in remaining]


def _leg(
    position: np.ndarray, first: int, last: int, grain: float, dt: float, *, from_rest: bool
) -> Leg:
    marks = np.unique(np.linspace(first, last, CHUNKS + 1).astype(int))
    times = dt * np.diff(marks)
    distance = float(position[last] - position[first])
    speeds = np.diff(position[marks]) / times * np.sign(distance)
    top = float(np.quantile(speeds, FAST))
    steady = np.abs(speeds - top) <= CRUISING * top + 2.0 * grain / times
    longest = max(runs(steady), key=lambda run: run.stop - run.start, default=slice(0, 0))
    cruise = slice(int(marks[longest.start]), int(marks[longest.stop]))
    duration = dt * (cruise.stop - cruise.start)
    speed = (
        abs(float(position[cruise.stop] - position[cruise.start])) / duration
        if duration > 0.0
        else top
    )
    return Leg(
        first,
        last,
        distance,
        dt * (last - first),
        cruise,
        duration / (dt * (last - first)),
        speed,
        from_rest,
    )
