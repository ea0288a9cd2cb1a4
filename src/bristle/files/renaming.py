"""Renaming a folder so that at no moment anything is missing, or anything else replaced."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from pathlib import Path

__all__ = ["exchange", "extended", "rename_new"]

LONGEST_PATH = 200  # of a folder; with the names of files in it, Windows takes 260 characters
_AS_IT_IS = "\\\\?\\"

_CURRENT_FOLDER = -100  # AT_FDCWD: relative paths start from the current folder
# Flags of Linux (renameat2) and of macOS (renamex_np).
_NO_REPLACE, _EXCHANGE = (4, 2) if sys.platform == "darwin" else (1, 2)
_UNKNOWN = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP}


def rename_new(old: Path, new: Path) -> None:
    """Give a folder a name that nothing has."""
    if _rename(old, new, _NO_REPLACE):
        return
    if os.path.lexists(new):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(new))
    os.rename(old, new)


def exchange(first: Path, second: Path) -> bool:
    """Exchange the names of two folders in one step; False, and nothing done, where the system cannot."""
    return _rename(first, second, _EXCHANGE)


def extended(path: str) -> str:
    """Return the path of a folder as Windows takes it whatever its length; a short one as it is."""
    if len(path) < LONGEST_PATH or path.startswith(_AS_IT_IS):
        return path
    return f"{_AS_IT_IS}UNC\\{path[2:]}" if path.startswith("\\\\") else _AS_IT_IS + path


def _rename(old: Path, new: Path, flag: int) -> bool:
    if sys.platform == "win32":
        return False
    library = ctypes.CDLL(None, use_errno=True)
    names = os.fsencode(old), os.fsencode(new)
    if hasattr(library, "renameat2"):
        failed = library.renameat2(_CURRENT_FOLDER, names[0], _CURRENT_FOLDER, names[1], flag)
    elif hasattr(library, "renamex_np"):
        failed = library.renamex_np(*names, flag)
    else:
        return False
    if not failed:
        return True
    code = ctypes.get_errno()
    if code in _UNKNOWN:
        return False
    raise OSError(code, os.strerror(code), str(old), None, str(new))
