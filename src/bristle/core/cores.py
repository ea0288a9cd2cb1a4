"""How many processor cores this process may use, and for what."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["core_count", "cores_for_simulations"]


def core_count() -> int:
    """Return on how many cores this process may run; where a system does not say so, how many there are."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


@contextmanager
def cores_for_simulations() -> Iterator[None]:
    """Keep linear algebra to one thread: all matrices here are small, and a second thread spins on its core."""
    import scipy.linalg  # noqa: F401  (it brings a library of its own, which must be there to be told)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, user_api="blas"):
        yield
