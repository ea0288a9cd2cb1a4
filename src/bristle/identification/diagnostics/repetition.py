"""What the motion of a log cannot tell, whatever is fitted to it: one amplitude only, and the same motion again."""

from __future__ import annotations

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.friction import is_static
from bristle.identification.dataset import Dataset
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs.segmentation import alternating

__all__ = ["about_amplitudes", "about_repeated_logs", "about_repetition", "half_cycles", "repeats_after"]

COMPARED = 4000  # samples of the longer of two logs
DESIGN = (1.0, 0.4, 0.7, 0.2, 1.0)  # of the amplitude: turning points that close loops inside one another


def half_cycles(dataset: Dataset, tremble: float = DEFAULT.tremble) -> np.ndarray:
    """Return how far the body goes between reversals [m or rad], shape (half-cycle,).

    A way below the share `tremble` of the range is none.
    """
    ways = []
    for segment, turns in zip(dataset.segments, dataset.reversals, strict=True):
        least = tremble * float(np.ptp(segment.position))
        ways.append(np.abs(np.diff(alternating(segment.position[list(turns)].tolist(), least))))
    return np.concatenate(ways)


def about_amplitudes(dataset: Dataset, friction: Model, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where a model has pre-sliding and the log shows it at one amplitude only."""
    if is_static(friction):
        return ()
    ways = half_cycles(dataset, settings.tremble)
    if ways.size < settings.amplitude_half_cycles or np.min(ways) < settings.nested_loop * np.max(ways):
        return ()
    whole = float(np.median(ways))
    numbers = {"half_cycles": ways.size, "amplitude": whole, "advised": tuple(share * whole for share in DESIGN)}
    return (Diagnostic("one-amplitude", numbers=numbers, kind=dataset.kind),)


def repeats_after(dataset: Dataset, settings: Settings = DEFAULT) -> float | None:
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
    last = int(count / settings.repeated_periods)
    if not below.size or below[0] >= last:
        return None
    beyond = correlation[below[0] : last]
    if not np.max(beyond) >= settings.repeated:
        return None
    first = int(np.argmax(beyond >= settings.repeated * np.max(beyond)))
    period = first + int(np.argmax(beyond[first : first + (below[0] + first) // 2]))
    return float((below[0] + period) * dataset.sample_time)


def about_repetition(dataset: Dataset, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where held-out blocks only repeat the motion that was fitted."""
    period = repeats_after(dataset, settings)
    return () if period is None else (Diagnostic("motion-repeats", numbers={"period": period}),)


def about_repeated_logs(dataset: Dataset, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where logs that were held out only repeat the motion of others that were fitted."""
    motions: dict[int, np.ndarray] = {}
    for one in dataset.segments:
        if one.log not in motions or one.position.size > motions[one.log].size:
            motions[one.log] = one.position
    step = max(max(x.size for x in motions.values()) // COMPARED, 1)
    thinned = {log: x[::step] - np.mean(x) for log, x in motions.items()}
    again = sum(
        any(_is_again(x, y, settings) for other, y in thinned.items() if other != log) for log, x in thinned.items()
    )
    if not again:
        return ()
    return (Diagnostic("logs-repeat", numbers={"repeated": again, "logs": len(motions)}),)


def _is_again(one: np.ndarray, other: np.ndarray, settings: Settings) -> bool:
    """Return whether two motions, each about its mean, are the same, one of them shifted in time."""
    n, m = one.size, other.size
    lag = np.arange(-m + 1, n)
    first, last = np.maximum(lag, 0), np.minimum(n, m + lag)
    size = n + m
    spectrum = np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size))
    product = np.fft.irfft(spectrum, size)[lag]
    squares, others = (np.concatenate([[0.0], np.cumsum(x * x)]) for x in (one, other))
    mine, its = squares[last] - squares[first], others[last - lag] - others[first - lag]
    long = (last - first >= settings.repeated_overlap * min(n, m)) & (mine > 0.0) & (its > 0.0)
    alike = long & (product >= settings.repeated * np.sqrt(mine * its))
    most = settings.repeated_size**2
    return bool(np.any(alike & (mine <= most * its) & (its <= most * mine)))
