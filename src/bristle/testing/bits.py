"""The bits of plain Python, from compiled code."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle.core.variable import Kind, unit_of
from bristle.engine import interpreted
from bristle.testing.check import Fact, UnmetError

__all__ = ["compiled_as_plain"]


def compiled_as_plain(forces: Callable[[], np.ndarray], kind: Kind) -> Fact:
    """Return that some forces are the same in plain Python and compiled, to the bit."""
    fast = forces()
    with interpreted():
        slow = forces()
    worst = float(np.max(np.abs(fast - slow)))
    fact = Fact(f"largest difference {worst:.3g} in {fast.size} steps", worst, unit_of("force", kind), 0.0)
    if not np.array_equal(fast, slow):
        raise UnmetError(fact, "Use bristle.core.mathematics, not math or **")
    return fact
