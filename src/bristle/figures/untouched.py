"""Results that are drawn and stay as they are: what draws them is handed the arrays themselves, and may be a user's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

__all__ = ["untouched"]

DEEPEST = 8


@contextmanager
def untouched(*values: Any) -> Iterator[None]:
    """Let no array in these values be written to while this lasts."""
    held = [array for array in _arrays_in(values, set(), DEEPEST) if array.flags.writeable]
    for array in held:
        array.flags.writeable = False
    try:
        yield
    finally:
        # A view can be written to again once the array can that it looks into.
        for array in sorted(held, key=lambda array: array.base is not None):
            array.flags.writeable = True


def _arrays_in(value: Any, visited: set[int], depth: int) -> Iterator[np.ndarray]:
    if id(value) in visited or depth == 0 or isinstance(value, (str, bytes, int, float, complex, type)):
        return
    visited.add(id(value))
    if isinstance(value, np.ndarray):
        yield value
        return
    if isinstance(value, Mapping):
        parts: Any = value.values()
    elif isinstance(value, (list, tuple, set, frozenset)):
        parts = value
    else:
        own = type(value).__module__.startswith("bristle.")
        parts = vars(value).values() if own and hasattr(value, "__dict__") else ()
    for part in list(parts):
        yield from _arrays_in(part, visited, depth - 1)
