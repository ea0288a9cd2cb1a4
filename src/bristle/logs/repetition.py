"""Whether a motion repeats itself, and how two signals go together, lag by lag."""

from __future__ import annotations

from typing import Protocol

import numpy as np

__all__ = ["Repetition", "by_lag", "repeats_after"]


class Repetition(Protocol):
    """Thresholds from which a motion repeats itself."""

    @property
    def repeated(self) -> float:
        """Correlation from which two motions are the same."""
        ...

    @property
    def repeated_periods(self) -> float:
        """Periods in a log from which it repeats itself."""
        ...


def repeats_after(position: np.ndarray, sample_time: float, settings: Repetition) -> float | None:
    """Return the period of a motion that repeats itself [s]; None where it does not."""
    x = position - np.mean(position)
    product, late, early = (part[x.size - 1 :] for part in by_lag(x, x)[1:])
    size = np.sqrt(late * early)
    correlation = np.divide(product, size, out=np.zeros_like(size), where=size > 0.0)
    below, last = np.flatnonzero(correlation < 0.0), int(x.size / settings.repeated_periods)
    if not below.size or below[0] >= last:
        return None
    beyond = correlation[below[0] : last]
    if not np.max(beyond) >= settings.repeated:
        return None
    first = int(np.argmax(beyond >= settings.repeated * np.max(beyond)))
    period = first + int(np.argmax(beyond[first : first + (below[0] + first) // 2]))
    return float((below[0] + period) * sample_time)


def by_lag(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return for each lag of `x` behind `y` how many samples both share, their product and their squares there."""
    from scipy.signal import correlate, correlation_lags

    lag = correlation_lags(x.size, y.size)
    first, last = np.maximum(lag, 0), np.minimum(x.size, y.size + lag)
    xx, yy = (np.concatenate([[0.0], np.cumsum(signal * signal)]) for signal in (x, y))
    product = np.asarray(correlate(x, y, method="fft"))
    return last - first, product, xx[last] - xx[first], yy[last - lag] - yy[first - lag]
