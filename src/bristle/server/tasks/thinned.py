"""Signals with as many points as a screen shows: no peak is lost."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

__all__ = ["thinned"]

BUCKETS = 1500
DIGITS = 8


def thinned(time: np.ndarray, *signals: np.ndarray) -> list[list[Any]]:
    """Return a time and signals along it, each reduced to the smallest and the largest sample of many in turn."""
    count = time.size
    places = np.arange(count)
    if count > 2 * BUCKETS:
        edges = np.linspace(0, count, BUCKETS + 1).astype(int)
        first = np.nan_to_num(signals[0])
        ends = [begin + np.array([np.argmin(first[begin:end]), np.argmax(first[begin:end])]) for begin, end in pairwise(edges)]
        places = np.unique(np.concatenate([*ends, [0, count - 1]]))
    return [[_short(value) for value in np.asarray(values, float)[places]] for values in (time, *signals)]


def _short(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
