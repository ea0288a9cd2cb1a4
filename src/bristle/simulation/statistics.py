"""Statistics of a signal, and of the following error where its reference reverses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bristle.core.edge import array, guarded
from bristle.logs.turns import reversals


@dataclass(frozen=True)
class Statistics:
    """Six statistics of a signal, in its unit.

    Parameters
    ----------
    peak_to_peak, mean, std, rms, min, max : float
        `peak_to_peak`: largest minus smallest value; `std`: standard deviation; `rms`: root mean square.
    """

    peak_to_peak: float
    mean: float
    std: float
    rms: float
    min: float
    max: float


NO_STATISTICS = Statistics(*[math.nan] * 6)


@guarded(signal=array(finite=False))  # the last numbers of a diverged loop are not finite
def statistics_of(signal: Any) -> Statistics:
    """Return peak-to-peak, mean, standard deviation, root mean square, minimum and maximum of a signal."""
    if signal.size == 0:
        return NO_STATISTICS
    low = float(signal.min())
    high = float(signal.max())
    with np.errstate(over="ignore", invalid="ignore"):
        rms = float(np.sqrt(np.mean(signal * signal)))
        return Statistics(
            peak_to_peak=high - low,
            mean=float(signal.mean()),
            std=float(signal.std()),
            rms=rms,
            min=low,
            max=high,
        )


def relative_error_percent(signal: np.ndarray, predicted: np.ndarray) -> float:
    """Return 100 ||signal - predicted|| / ||signal|| [%]; NaN for a signal of zeros."""
    total = float(np.linalg.norm(signal))
    if total > 0.0:
        return 100.0 * float(np.linalg.norm(signal - predicted)) / total
    return float("nan")


def mean_statistics(statistics: Sequence[Statistics]) -> Statistics:
    """Return the means of each statistic over several signals."""
    names = [field.name for field in fields(Statistics)]
    return Statistics(
        *(float(np.mean([getattr(part, name) for part in statistics])) for name in names)
    )


def worst_reversal(reference: np.ndarray, error: np.ndarray) -> slice | None:
    """Return the samples around the reversal of a reference with the widest swing of the error."""
    count = min(max(round(0.05 * error.size), 40), error.size)
    starts = np.clip(reversals(np.diff(reference)) - count // 3, 0, error.size - count)
    if not starts.size:
        return None
    swings = [np.ptp(error[start : start + count]) for start in starts]
    start = int(starts[int(np.argmax(swings))])
    return slice(start, start + count)


def swing_at_worst_reversal(reference: np.ndarray, error: np.ndarray) -> float | None:
    """Return the peak-to-peak swing of the error at the worst reversal [m or rad]; None without a reversal."""
    at = worst_reversal(reference, error)
    if at is None:
        return None
    return float(np.ptp(error[at]))
