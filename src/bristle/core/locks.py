"""Locks of the whole process: forking waits until nobody else holds one, so that none stays closed in the child.

A thread that holds a lock takes only those that come after it here.
"""

import logging  # noqa: F401  (its own locks come last of all: what is brought first is taken last by a fork)
import os
import threading

LOADING = threading.RLock()  # a file of a user's is run
MAKING = threading.RLock()  # a component is made by a factory
COMPILING = threading.RLock()  # an entry is compiled
SHARING = threading.RLock()  # the threads of linear algebra are set

_ORDER = (LOADING, MAKING, COMPILING, SHARING)
_held = threading.local()


def _take_all() -> None:
    _held.locks = []
    for lock in _ORDER:
        lock.acquire()
        _held.locks.append(lock)


def _give_back() -> None:
    # Not all of them, where the waiting was interrupted.
    for lock in reversed(_held.locks):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take_all, after_in_parent=_give_back, after_in_child=_give_back)
