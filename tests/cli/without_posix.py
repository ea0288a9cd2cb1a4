"""Take from a process what only POSIX systems have, and put in what Windows has instead, as far as Linux can.

Called first in a process of its own, before bristle is imported: nothing is given back. What cannot be had here: paths
with drives and backslashes (they are tested by the functions that handle them), files that cannot be renamed while
open, consoles.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import subprocess  # it takes the system for Windows where it finds what is put in below
import sys
import types

assert subprocess


def take_away() -> None:
    """Leave this process with what Windows has."""
    sys.modules["msvcrt"] = _locks_of_windows()
    for name in (
        "O_DIRECTORY",
        "O_NOFOLLOW",
        "O_NONBLOCK",
        "getuid",
        "fork",
        "register_at_fork",
        "mkfifo",
    ):
        if hasattr(os, name):
            delattr(os, name)
    os.supports_dir_fd = set()
    for name in ("poll", "epoll"):
        if hasattr(select, name):
            delattr(select, name)
    for name in ("SIGHUP", "pthread_kill"):
        delattr(signal, name)
    for name in ("fcntl", "resource", "pwd", "grp", "termios"):
        sys.modules[name] = None  # type: ignore[assignment]
    _without_exchange_of_names()


def _locks_of_windows() -> types.ModuleType:
    import fcntl

    def locking(opened: int, mode: int, count: int) -> None:
        """Lock bytes from where the file stands, as Windows does: the lock belongs to the opened file."""
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise PermissionError(13, "Permission denied") from error

    module = types.ModuleType("msvcrt")
    module.LK_NBLCK = 2  # type: ignore[attr-defined]
    module.locking = locking  # type: ignore[attr-defined]
    return module


class _NoLibrary:
    """The C library of a system that neither exchanges names nor refuses to replace one."""


def _without_exchange_of_names() -> None:
    load = ctypes.CDLL

    def loaded(name: str | None, *arguments: object, **options: object) -> object:
        return _NoLibrary() if name is None else load(name, *arguments, **options)  # type: ignore[arg-type]

    ctypes.CDLL = loaded  # type: ignore[assignment,misc]
