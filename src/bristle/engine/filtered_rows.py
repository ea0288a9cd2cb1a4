r"""Derivatives of a signal along a log, behind the filters that lead to rows: all directions in one pass.

The zero-phase Butterworth filter forward and backward, section by section in the transposed direct form II, and the
symmetric filter :math:`r_k = \sum_j h_j\, y_{k d + j}` that decimates. `bristle.logs.filters.low_passed` and
`scipy.signal.resample_poly` do the same to one signal.
"""

from collections.abc import Callable

import numpy as np

from bristle.core.kernel import kernel
from bristle.core.tangent import (
    DIRECTIONS,
    keep_tangent,
    still,
    tangent_at,
    tangent_combined,
    tangent_difference,
    tangent_scaled,
    tangent_sum,
)
from bristle.engine.compilation import compiled
from bristle.engine.signature import Vector

# (sections of the filter one after the other, their settled states, samples of the extension at either end, samples dropped
# there, samples to a row, taps, signal, the signal extended, rows).
Rows = Callable[[Vector, Vector, int, int, int, Vector, Vector, Vector, Vector], float]


@kernel(portable=False)
def section(c, settled, first, entry, y, start, stop, step):
    """Send the tangents of `y` through one section, in place; `c` begins with its coefficients at `first`.

    Before, the filter has settled at the `entry` into its first section.
    """
    z_0 = tangent_scaled(settled[first // 3], entry)
    z_1 = tangent_scaled(settled[first // 3 + 1], entry)
    k = start
    while k != stop:
        x = tangent_at(y, k)
        out = tangent_sum(tangent_scaled(c[first], x), z_0)
        z_0 = tangent_sum(tangent_difference(tangent_scaled(c[first + 1], x), tangent_scaled(c[first + 4], out)), z_1)
        z_1 = tangent_difference(tangent_scaled(c[first + 2], x), tangent_scaled(c[first + 5], out))
        keep_tangent(y, k, out)
        k += step


def rows_entry(c, settled, edge, dropped, step, taps, signal, extended, rows):
    """Write the rows of a signal."""
    count = signal.size // DIRECTIONS
    for k in range(edge):
        keep_tangent(extended, k, tangent_combined(2.0, tangent_at(signal, 0), -1.0, tangent_at(signal, edge - k)))
        behind = tangent_combined(2.0, tangent_at(signal, count - 1), -1.0, tangent_at(signal, count - 2 - k))
        keep_tangent(extended, edge + count + k, behind)
    for k in range(count):
        keep_tangent(extended, edge + k, tangent_at(signal, k))
    total = count + 2 * edge
    entry = tangent_at(extended, 0)
    for first in range(0, c.size, 6):
        section(c, settled, first, entry, extended, 0, total, 1)
    entry = tangent_at(extended, total - 1)
    for first in range(0, c.size, 6):
        section(c, settled, first, entry, extended, total - 1, -1, -1)
    begin, last, half = edge + dropped, edge + count - dropped - 1, taps.size // 2
    for row in range(rows.size // DIRECTIONS):
        at, mean = begin + row * step - half, still()
        for j in range(taps.size):
            mean = tangent_sum(mean, tangent_scaled(taps[j], tangent_at(extended, min(max(at + j, begin), last))))
        keep_tangent(rows, row, mean)
    return 0.0


def filtered_rows(
    derivatives: np.ndarray, sections: np.ndarray, settled: np.ndarray, edge: int, dropped: int, step: int, taps: np.ndarray
) -> np.ndarray:
    """Return the rows of the derivatives of a signal, shape (row, direction), which are given at its samples."""
    count, directions = derivatives.shape
    inner, blocks = count - 2 * dropped, list[np.ndarray]()
    entry = compiled("filtered_rows", lambda: rows_entry, Rows)
    for first in range(0, directions, DIRECTIONS):
        width = min(directions - first, DIRECTIONS)
        signal = np.zeros((count, DIRECTIONS))
        signal[:, :width] = derivatives[:, first : first + width]
        extended, rows = np.empty((count + 2 * edge) * DIRECTIONS), np.empty(-(-inner // step) * DIRECTIONS)
        entry(sections.ravel(), settled.ravel(), edge, dropped, step, taps, signal.ravel(), extended, rows)
        blocks.append(rows.reshape(-1, DIRECTIONS)[:, :width])
    return blocks[0] if len(blocks) == 1 else np.hstack(blocks)
