"""Number of processor cores for this process, and their use."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor  # noqa: TID251  (the only place that imports it)
from contextlib import contextmanager
from contextvars import copy_context
from types import SimpleNamespace
from typing import Any, TypeVar

from bristle.core.locks import SHARING

A = TypeVar("A")
B = TypeVar("B")

# Number of active blocks with single-threaded linear algebra, and the limits before the first block.
_blocks = SimpleNamespace(inside=0, limits=None)


def core_count() -> int:
    """Return the number of cores available to this process, or else the number of cores of the machine."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


class Abreast(ThreadPoolExecutor):
    """Threads that work in the context of their caller."""

    def __init__(self, threads: int | None = None) -> None:
        super().__init__(threads or core_count())

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call a function in a thread, with a copy of the current context."""
        return super().submit(copy_context().run, fn, *args, **kwargs)

    def __exit__(self, *error: Any) -> None:
        """Wait for all work; an interruption takes effect at once, and each thread ends with the value that it computes."""
        self.shutdown(wait=not isinstance(error[1], KeyboardInterrupt), cancel_futures=True)


def abreast(function: Callable[[A], B]) -> Callable[[Sequence[A]], list[B]]:
    """Return a function that maps values on all cores."""

    def together(values: Sequence[A]) -> list[B]:
        if len(values) == 1:
            return [function(values[0])]
        with Abreast() as pool:
            return list(pool.map(function, values))

    return together


@contextmanager
def cores_for_simulations() -> Iterator[None]:
    """Limit linear algebra to one thread: all matrices are small, and a second thread would only spin on its core.

    A second thread would also change the order of sums. Blocks may overlap in several threads: the last block restores
    the limits before the first.
    """
    import scipy.linalg  # noqa: F401  (its separate library must be loaded before the limit is set)
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
                own.restore_original_limits()  # each thread has a separate limit
            elif _blocks.inside <= 0:
                (_blocks.limits or own).restore_original_limits()
            if _blocks.inside <= 0:
                _leave_blocks()
                _blocks.limits = None
            _take_over()


def _take_over() -> None:
    """Let any thread set the limit: some versions obey only the first thread that set it."""
    from threadpoolctl import OpenBLASController

    forget = getattr(OpenBLASController, "clear_controlling_thread", None)
    if forget is not None:
        forget(force=True)


def _leave_blocks() -> None:
    _blocks.inside = 0


if hasattr(os, "register_at_fork"):
    # Other threads inside a block do not exist in a fork and never leave the block.
    os.register_at_fork(after_in_child=_leave_blocks)
