"""Locks of the whole process: a fork first acquires all of them, so that they are free in the child."""

import logging  # noqa: F401  (a fork acquires the locks of the first import last)
import os
import threading

# A thread with a lock may acquire only locks that follow in this list.
LOADING = threading.RLock()  # a user file runs
MAKING = threading.RLock()  # a factory makes a component
COMPILING = threading.RLock()  # an entry is compiled
SHARING = threading.RLock()  # the thread limit of linear algebra changes

_ORDER = (LOADING, MAKING, COMPILING, SHARING)
_held = threading.local()


def _take_all() -> None:
    _held.locks = []
    for lock in _ORDER:
        lock.acquire()
        _held.locks.append(lock)


def _give_back() -> None:
    # Only the acquired locks, if the wait was interrupted.
    for lock in reversed(_held.locks):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_take_all, after_in_parent=_give_back, after_in_child=_give_back)
