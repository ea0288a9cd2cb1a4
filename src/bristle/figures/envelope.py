"""Long signals as short lines that look the same: the samples that a line of this width can show.

References
----------
.. [1] U. Jugel, Z. Jerzak, G. Hackenbroich, V. Markl, "M4: a visualization-oriented time series data aggregation",
   Proceedings of the VLDB Endowment 7(10), 2014. doi:10.14778/2732951.2732953
"""

from __future__ import annotations

import numpy as np

COLUMNS = 480  # about one a point of a figure as wide as a page


def envelope(y: np.ndarray, columns: int = COLUMNS) -> np.ndarray:
    """Return which samples of a signal to keep: first, smallest, largest and last of each column."""
    if y.size <= 4 * columns:
        return np.arange(y.size)
    width = -(-y.size // columns)
    starts = np.arange(0, y.size, width)
    last = np.minimum(starts + width, y.size) - 1
    # The end is padded with the last sample, which adds neither a smaller nor a larger one.
    blocks = np.pad(y, (0, starts.size * width - y.size), mode="edge").reshape(starts.size, width)
    low, high = starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1)
    return np.unique(np.minimum(np.concatenate([starts, low, high, last]), y.size - 1))


def runs(x: np.ndarray, y: np.ndarray) -> list[slice]:
    """Return the stretches without a gap in `x` (a step of more than 1.5 times the usual) and with finite `y`."""
    good = np.isfinite(y) & np.isfinite(x)
    if not good.any():
        return []
    steps = np.diff(x)
    usual = np.median(steps) if steps.size else 0.0
    joined = good[1:] & good[:-1] & ~(steps > 1.5 * usual)
    begins = np.flatnonzero(good & ~np.concatenate([[False], joined]))
    ends = np.flatnonzero(good & ~np.concatenate([joined, [False]]))
    return [slice(int(begin), int(end) + 1) for begin, end in zip(begins, ends, strict=True)]


def line(x: np.ndarray, y: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """Return a signal over time as a short line that looks the same, broken where there is a gap."""
    parts = runs(x, y)
    total = sum(part.stop - part.start for part in parts)
    kept_x, kept_y = [], []
    for part in parts:
        # A long stretch takes its share of the width, or a few short ones beside it would make it coarse.
        # Two columns at least for each stretch.
        samples = envelope(y[part], max(columns * (part.stop - part.start) // total, 2)) + part.start
        kept_x += [x[samples], [np.nan]]
        kept_y += [y[samples], [np.nan]]
    if not parts:
        return np.empty(0), np.empty(0)
    return np.concatenate(kept_x[:-1]), np.concatenate(kept_y[:-1])


def spread(x: np.ndarray, y: np.ndarray, cells: tuple[int, int] = (240, 120)) -> np.ndarray:
    """Return which points of a cloud to draw: one for each cell of a grid that holds any, and the extremes."""
    if x.size == 0:
        return np.arange(0)
    across, up = (np.minimum(((v - v.min()) / (np.ptp(v) or 1.0) * n).astype(int), n - 1) for v, n in zip((x, y), cells, strict=True))
    _, first = np.unique(across * cells[1] + up, return_index=True)
    extremes = [x.argmin(), x.argmax(), y.argmin(), y.argmax()]
    return np.unique(np.concatenate([first, extremes]))
