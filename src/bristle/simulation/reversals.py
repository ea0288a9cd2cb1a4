"""Where a following error swings most: around the reversals of its reference."""

import numpy as np

from bristle.logs.turns import reversals


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
    """Return the swing of the error there, peak to peak [m or rad]; None where the reference never reverses."""
    at = worst_reversal(reference, error)
    return None if at is None else float(np.ptp(error[at]))
