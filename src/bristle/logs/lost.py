"""Rows that a recorder lost: where they are missing among the stamps of a log, and which of them are bridged."""

from __future__ import annotations

import numpy as np

__all__ = ["UNIFORM", "bridge_notes", "samples_between"]

BRIDGED = 3  # rows lost on end that are interpolated: a longer pause splits the log
MOST_LOST = 0.1  # of the rows: where more are missing none is bridged
HALF = 0.5  # of the sample time: what the stamps behind a step are later by where a row was lost
AROUND = 33  # rows before a step, and behind it: 16 that came late and are made up for are no majority of them
EXACT = 0.99  # of the steps being even: a pause of no whole number of samples is the clock's, and splits the log
UNIFORM = 0.01  # of the sample time: rounding of the stamps, left alone
PASSES = 8  # rows that were lost close together are found one after the other


def samples_between(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which steps are pauses that split the log, and over how many samples each other step is.

    A row that was lost moves all stamps behind it, a late one only itself: the medians of the stamps before and behind
    a step, against even ones, tell them apart. Few rows that were lost on end are bridged.
    """
    counts = np.ones(stamps.size - 1)
    for _ in range(PASSES):
        off = (stamps - usual * np.concatenate([[0.0], np.cumsum(counts)])) / usual
        before, behind = _medians(off)[:-1], _medians(off[::-1])[::-1][1:]
        rise = behind - before
        found = np.flatnonzero(rise > HALF)
        if not found.size:
            break
        jumps = np.diff(off)
        for near in np.split(found, np.flatnonzero(np.diff(found) > 1) + 1):
            missing = np.round(jumps[near])
            if missing.min() >= 0.0 and abs(missing.sum() - (behind[near[-1]] - before[near[0]])) < HALF:
                counts[near] += missing  # single steps and the stamps around all of them agree
                continue
            at = near[np.argmax(jumps[near])]
            counts[at] += max(round(float(min(rise[near].max(), jumps[at]))), 1)
    gaps = counts > (BRIDGED + 1.0 if np.sum(counts > 1.0) <= MOST_LOST * counts.size else 1.0)
    fraction = np.abs(np.diff(stamps) / usual - counts)
    if np.quantile(fraction, EXACT) < UNIFORM:
        gaps |= (counts > 1.0) & (fraction > UNIFORM)
    return gaps, np.where(gaps, 1.0, counts)


def bridge_notes(counts: np.ndarray) -> list[str]:
    """Return how many rows are bridged, in a sentence; none where none is."""
    lost = int(np.sum(counts - 1.0))
    if not lost:
        return []
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    return [f"{rows} missing, {BRIDGED} on end at most: interpolated between those around"]


def _medians(off: np.ndarray) -> np.ndarray:
    """Return the median of the values up to each one."""
    from scipy.ndimage import median_filter

    reach = min(AROUND, off.size)
    return median_filter(off, size=reach, origin=(reach - 1) // 2, mode="nearest")
