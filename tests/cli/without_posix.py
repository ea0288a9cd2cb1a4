"""Take from this process what only POSIX systems have, and put in what Windows has instead, as far as Linux can.

Imported first in a process of its own, before bristle. What cannot be had here: paths with drives and backslashes (they
are tested by the functions that handle them), files that cannot be renamed while open, consoles.
"""

import ctypes
import fcntl as _fcntl
import os
import select
import signal
import subprocess  # it takes the system for Windows where it finds what is put in below
import sys
import types

for name in ("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "getuid", "fork", "register_at_fork", "mkfifo"):
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

_msvcrt = types.ModuleType("msvcrt")
_msvcrt.LK_NBLCK = 2  # type: ignore[attr-defined]


def locking(opened: int, mode: int, count: int) -> None:
    """Lock bytes from where the file stands, as Windows does: the lock belongs to the opened file."""
    try:
        _fcntl.flock(opened, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise PermissionError(13, "Permission denied") from error


_msvcrt.locking = locking  # type: ignore[attr-defined]
sys.modules["msvcrt"] = _msvcrt


class _NoLibrary:
    """The C library of a system that neither exchanges names nor refuses to replace one."""


_loaded = ctypes.CDLL


def loaded(name: str | None, *arguments: object, **options: object) -> object:
    return _NoLibrary() if name is None else _loaded(name, *arguments, **options)  # type: ignore[arg-type]


ctypes.CDLL = loaded  # type: ignore[assignment,misc]
assert subprocess
