"""What the motion of a log cannot tell, whatever is fitted to it: one amplitude only, and the same motion again."""

from __future__ import annotations

import numpy as np

from bristle.core.contracts import Model
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.friction import is_static
from bristle.identification.dataset import Dataset

__all__ = ["about_amplitudes", "about_repeated_logs", "about_repetition", "half_cycles", "repeats_after"]

NESTED = 0.7  # of the longest half-cycle: a shorter one is another amplitude
TURNS_LEAST = 6  # half-cycles, for one amplitude to be worth a word
SMALLEST = 0.02  # of the range: a shorter way between two reversals is a tremble
ALIKE = 0.98  # correlation of a motion with itself, one period later
PERIODS_LEAST = 3.0  # in the log
SAME_SIZE = 1.1  # ratio of two motions that are one
OVERLAP = 0.5  # of the shorter of two logs, over which they are compared
COMPARED = 4000  # samples of the longer one
NO_TEST = (
    "what was held out is the motion that was fitted, so that its error tells how well the axis repeats itself, not "
    "how the model does on another motion. Predict a log of another motion with it"
)


def half_cycles(dataset: Dataset) -> np.ndarray:
    """Return how far the body goes between reversals [m or rad], trembles left out, shape (half-cycle,)."""
    found = []
    for number, one in enumerate(dataset.segments):
        turns = [k for segment, k in dataset.reversals if segment == number]
        tops = one.position[turns]
        least = SMALLEST * float(np.ptp(one.position))
        kept: list[float] = []
        for x in tops.tolist():
            if kept and abs(x - kept[-1]) <= least:
                continue
            # Two ways in one direction are one.
            if len(kept) >= 2 and (x - kept[-1]) * (kept[-1] - kept[-2]) > 0.0:
                kept[-1] = x
            else:
                kept.append(x)
        found.append(np.abs(np.diff(kept)))
    return np.concatenate(found) if found else np.empty(0)


def about_amplitudes(dataset: Dataset, friction: Model) -> tuple[str, ...]:
    """Return a warning where a model has pre-sliding and the log shows it at one amplitude only."""
    if is_static(friction):
        return ()
    ways = half_cycles(dataset)
    if ways.size < TURNS_LEAST or np.min(ways) < NESTED * np.max(ways):
        return ()
    unit = unit_of("length", dataset.kind)
    whole = float(np.median(ways))
    turns = ", ".join(with_unit(share * whole, unit) for share in (1.0, 0.4, 0.7, 0.2, 1.0))
    return (
        f"all {ways.size} half-cycles go the same way of {with_unit(whole, unit)}: a log of one amplitude holds no "
        "loop inside another one, so that it cannot tell a contact that remembers one force (dahl, lugre) from one "
        "that remembers its turning points (maxwell_slip), however their errors differ. Record a motion to and fro "
        f"over {turns}: elements close the loops inside the large one, the others creep",
    )


def repeats_after(dataset: Dataset) -> float | None:
    """Return the period of a motion that repeats itself [s]; None where it does not."""
    one = max(dataset.segments, key=lambda segment: segment.position.size)
    x = one.position - np.mean(one.position)
    count = x.size
    spectrum = np.fft.rfft(x, 2 * count)
    lagged = np.fft.irfft(spectrum * np.conj(spectrum))[:count]
    squares = np.concatenate([[0.0], np.cumsum(x * x)])
    # Of each lag, over what both ends share.
    both = np.sqrt(squares[count:0:-1] * (squares[-1] - squares[:count]))
    correlation = np.where(both > 0.0, lagged / np.where(both > 0.0, both, 1.0), 0.0)
    below = np.flatnonzero(correlation < 0.0)
    last = int(count / PERIODS_LEAST)
    if not below.size or below[0] >= last:
        return None
    beyond = correlation[below[0] : last]
    if not np.max(beyond) >= ALIKE:
        return None
    first = int(np.argmax(beyond >= ALIKE * np.max(beyond)))
    period = first + int(np.argmax(beyond[first : first + (below[0] + first) // 2]))
    return float((below[0] + period) * dataset.sample_time)


def about_repetition(dataset: Dataset) -> tuple[str, ...]:
    """Return a warning where held-out blocks only repeat the motion that was fitted."""
    period = repeats_after(dataset)
    if period is None:
        return ()
    return (f"the motion repeats itself every {with_unit(period, 's')}: {NO_TEST}",)


def about_repeated_logs(dataset: Dataset) -> tuple[str, ...]:
    """Return a warning where logs that were held out only repeat the motion of others that were fitted."""
    motions: dict[int, np.ndarray] = {}
    for one in dataset.segments:
        if one.log not in motions or one.position.size > motions[one.log].size:
            motions[one.log] = one.position
    step = max(max(x.size for x in motions.values()) // COMPARED, 1)
    thinned = {log: x[::step] - np.mean(x) for log, x in motions.items()}
    again = [log for log, x in thinned.items() if any(_is_again(x, y) for two, y in thinned.items() if two != log)]
    if not again:
        return ()
    which = "each log repeats" if len(again) == len(motions) else f"{len(again)} of {len(motions)} logs repeat"
    return (f"{which} the motion of another one: {NO_TEST}",)


def _is_again(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two motions, each about its mean, are the same, one of them shifted in time."""
    n, m = one.size, other.size
    lag = np.arange(-m + 1, n)
    first, last = np.maximum(lag, 0), np.minimum(n, m + lag)
    size = n + m
    spectrum = np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size))
    product = np.fft.irfft(spectrum, size)[lag]
    squares, others = (np.concatenate([[0.0], np.cumsum(x * x)]) for x in (one, other))
    mine, its = squares[last] - squares[first], others[last - lag] - others[first - lag]
    long = (last - first >= OVERLAP * min(n, m)) & (mine > 0.0) & (its > 0.0)
    alike = long & (product >= ALIKE * np.sqrt(mine * its))
    return bool(np.any(alike & (mine <= SAME_SIZE**2 * its) & (its <= SAME_SIZE**2 * mine)))
