r"""Derivatives of a signal along a log after the filters of the rows: all directions in one pass, block by block.

The zero-phase Butterworth filter forward and backward, section by section in the transposed direct form II, and the
symmetric filter :math:`r_k = \sum_j h_j\, y_{k d + j}` that decimates. `bristle.logs.filters.low_passed` and
`scipy.signal.resample_poly` do the same for one signal. The backward pass begins so many samples after a block that its
transient has decayed: a log of any length needs only the memory of a block.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from bristle.core.kernel import kernel
from bristle.core.tangent import (
    DIRECTIONS,
    keep_tangent,
    still,
    tangent_at,
    tangent_difference,
    tangent_scaled,
    tangent_sum,
)
from bristle.engine.compilation import compiled
from bristle.engine.signature import Vector

# (consecutive sections of the filter, their states, signal, 1 for a backward pass, its sample of the first row, samples
# per row, taps, first and last sample for rows, rows).
Rows = Callable[[Vector, Vector, Vector, int, int, int, Vector, int, int, Vector], float]

# The number of samples of a block, and the function that writes them, shape (sample, direction).
Block = tuple[int, Callable[[np.ndarray], Any]]


@kernel(portable=False)
def pass_through(c, z, y, start, stop, step):
    """Send the tangents of `y` through both sections of the filter, in place."""
    z_0, z_1, z_2, z_3 = tangent_at(z, 0), tangent_at(z, 1), tangent_at(z, 2), tangent_at(z, 3)
    k = start
    while k != stop:
        x = tangent_at(y, k)
        half = tangent_sum(tangent_scaled(c[0], x), z_0)
        z_0 = tangent_sum(
            tangent_difference(tangent_scaled(c[1], x), tangent_scaled(c[4], half)), z_1
        )
        z_1 = tangent_difference(tangent_scaled(c[2], x), tangent_scaled(c[5], half))
        out = tangent_sum(tangent_scaled(c[6], half), z_2)
        z_2 = tangent_sum(
            tangent_difference(tangent_scaled(c[7], half), tangent_scaled(c[10], out)), z_3
        )
        z_3 = tangent_difference(tangent_scaled(c[8], half), tangent_scaled(c[11], out))
        keep_tangent(y, k, out)
        k += step
    keep_tangent(z, 0, z_0)
    keep_tangent(z, 1, z_1)
    keep_tangent(z, 2, z_2)
    keep_tangent(z, 3, z_3)


def rows_entry(c, z, y, backward, first, step, taps, low, high, rows):
    """Send a signal through the filter, in place, and write its rows."""
    count, half = y.size // DIRECTIONS, taps.size // 2
    if backward == 1:
        pass_through(c, z, y, count - 1, -1, -1)
    else:
        pass_through(c, z, y, 0, count, 1)
    for row in range(rows.size // DIRECTIONS):
        at, mean = first + row * step - half, still()
        for j in range(taps.size):
            mean = tangent_sum(
                mean, tangent_scaled(taps[j], tangent_at(y, min(max(at + j, low), high)))
            )
        keep_tangent(rows, row, mean)
    return 0.0


def filtered_rows(
    blocks: Iterable[Block],
    count: int,
    sections: np.ndarray,
    settled: np.ndarray,
    edge: int,
    reach: int,
    dropped: int,
    step: int,
    taps: np.ndarray,
) -> np.ndarray:
    """Return rows, shape (row, direction), of all `count` samples in `blocks`; a transient decays in `reach` samples."""
    entry, empty = compiled("filtered_rows", lambda: rows_entry, Rows), np.empty(0)
    c, start, half = sections.ravel(), settled.reshape(-1, 1), taps.size // 2
    # Indices from the first sample of the extended signal: the samples for rows, and the first sample of `y`.
    low, high, begin = edge + dropped, edge + count - dropped - 1, 0
    rows, tail = (
        np.empty((-(-(count - 2 * dropped) // step), DIRECTIONS)),
        np.empty((edge, DIRECTIONS)),
    )
    complete, taken, state = 0, 0, empty
    for size, write in blocks:
        at, taken, is_first = len(tail), taken + size, taken == 0
        y = np.empty((at + size + edge * (taken == count), DIRECTIONS))
        new = y[at : at + size]
        write(new)
        y[:at] = 2.0 * new[0] - new[edge:0:-1] if is_first else tail
        y[at + size :] = 2.0 * new[-1] - new[-2 : -edge - 2 : -1] if taken == count else 0.0
        state = (start * y[0]).ravel() if is_first else state
        entry(c, state, y[0 if is_first else at :].ravel(), 0, 0, 1, taps, 0, 0, empty)
        ready = (
            len(rows)
            if taken == count
            else max(
                min((begin + len(y) - reach - half - low - 1) // step + 1, len(rows)), complete
            )
        )
        first, part = low + complete * step - begin, rows[complete:ready].reshape(-1)
        needed = max(low + ready * step - half - begin, 0)
        tail = y[needed:].copy() if taken < count else y
        if part.size:
            entry(
                c,
                (start * y[-1]).ravel(),
                y.ravel(),
                1,
                first,
                step,
                taps,
                max(low - begin, 0),
                high - begin,
                part,
            )
        begin, complete = begin + needed, ready
    assert taken == count, f"{taken} of {count} samples"
    return rows


def filtered_every(
    step: int, signals: np.ndarray, sections: np.ndarray, settled: np.ndarray, edge: int, reach: int
) -> np.ndarray:
    """Return every `step`-th sample of filtered signals, shape (signal, sample), with several signals per pass."""
    count, rows = signals.shape[1], list[np.ndarray]()
    for first in range(0, max(len(signals), 1), DIRECTIONS):
        blocks = [(count, partial(_transpose, signals[first : first + DIRECTIONS]))]
        rows.append(
            filtered_rows(blocks, count, sections, settled, edge, reach, 0, step, np.ones(1)).T
        )
    return np.concatenate(rows)[: len(signals)]


def _transpose(signals: np.ndarray, out: np.ndarray) -> None:
    """Write signals as the first directions."""
    out[:] = 0.0
    out[:, : len(signals)] = signals.T
