"""How many processor cores this process may use, and for what."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor  # noqa: TID251  (the one place that does)
from contextlib import contextmanager
from contextvars import copy_context
from types import SimpleNamespace
from typing import Any, TypeVar

from bristle.core.locks import SHARING

A = TypeVar("A")
B = TypeVar("B")

# How many blocks keep linear algebra to one thread, and what the first of them found.
_blocks = SimpleNamespace(inside=0, limits=None)


def core_count() -> int:
    """Return on how many cores this process may run; where a system does not say so, how many there are."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


class Abreast(ThreadPoolExecutor):
    """Threads that work for one caller, as it would itself: what holds in its context holds in them."""

    def __init__(self, threads: int | None = None) -> None:
        super().__init__(threads or core_count())

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Let a function be called by one of the threads, in a copy of the context of this call."""
        return super().submit(copy_context().run, fn, *args, **kwargs)


def abreast(function: Callable[[A], B]) -> Callable[[Sequence[A]], list[B]]:
    """Return what calls a function with each of several values, on all cores."""

    def together(values: Sequence[A]) -> list[B]:
        if len(values) == 1:
            return [function(values[0])]
        pool = Abreast()
        try:
            return list(pool.map(function, values))
        finally:
            pool.shutdown(cancel_futures=True)

    return together


@contextmanager
def cores_for_simulations() -> Iterator[None]:
    """Keep linear algebra to one thread: all matrices here are small, and a second thread spins on its core.

    It would also add up in another order. So of blocks that overlap in several threads none ends for the others: the
    last one gives back what the first one found.
    """
    import scipy.linalg  # noqa: F401  (it brings a library of its own, which must be there to be told)
    from threadpoolctl import threadpool_info, threadpool_limits

    with SHARING:
        _take_over()
        own = threadpool_limits(1, user_api="blas")
        _blocks.inside, _blocks.limits = _blocks.inside + 1, _blocks.limits or own
    try:
        yield
    finally:
        with SHARING:
            _blocks.inside -= 1
            if any(pool.get("threading_layer") == "openmp" for pool in threadpool_info()):
                own.restore_original_limits()  # each thread has a number of its own
            elif _blocks.inside <= 0:
                (_blocks.limits or own).restore_original_limits()
            if _blocks.inside <= 0:
                _leave_blocks()
                _blocks.limits = None
            _take_over()


def _take_over() -> None:
    """Let any thread say how many there are: some versions heed only the first that ever did."""
    from threadpoolctl import OpenBLASController

    forget = getattr(OpenBLASController, "clear_controlling_thread", None)
    if forget is not None:
        forget(force=True)


def _leave_blocks() -> None:
    _blocks.inside = 0


if hasattr(os, "register_at_fork"):
    # The other threads that are in a block are not there in a fork, and never leave it.
    os.register_at_fork(after_in_child=_leave_blocks)
