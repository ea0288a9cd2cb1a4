"""A folder that is held open, and folders renamed so that nothing is missing in between: links are never followed."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import hashlib
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

from bristle.core.content import CHUNK
from bristle.core.errors import InputError

_NO_LINKS = getattr(os, "O_NOFOLLOW", 0)


class Folder:
    """A folder that is held open, so that what is done in it is done in that very folder, whatever its path is now."""

    def __init__(self, path: Path, above: Folder | None = None) -> None:
        self.path = path
        self._above = above
        self._opened: int | None = None

    def __enter__(self) -> Folder:
        if os.stat in os.supports_dir_fd and hasattr(os, "O_DIRECTORY"):
            location, above = (self.path, None) if self._above is None else (self.path.name, self._above._opened)
            self._opened = os.open(location, os.O_RDONLY | os.O_DIRECTORY | _NO_LINKS, dir_fd=above)
        elif not stat.S_ISDIR(os.lstat(self.path).st_mode):
            raise OSError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(self.path))
        return self

    def __exit__(self, *_: object) -> None:
        if self._opened is not None:
            os.close(self._opened)

    def names(self) -> list[str]:
        """Return what is in it."""
        return sorted(os.listdir(self.path if self._opened is None else self._opened))

    def below(self, name: str) -> Folder:
        """Return a folder in it, to be held open."""
        return Folder(self.path / name, above=self)

    def is_file(self, name: str) -> bool:
        """Return whether this is a regular file, and no link to one."""
        try:
            return stat.S_ISREG(self._status(name).st_mode)
        except OSError:
            return False

    def open(self, name: str, flags: int = os.O_RDONLY) -> int:
        """Return a file opened; a link is not followed."""
        with self._holder(name) as (holder, last):
            return os.open(holder._at(last), flags | _NO_LINKS | getattr(os, "O_BINARY", 0), 0o666, dir_fd=holder._opened)

    def size(self, name: str) -> int:
        """Return how large a file is [byte]."""
        return self._status(name).st_size

    def checksum(self, name: str) -> str:
        """Return the SHA-256 of a file."""
        digest = hashlib.sha256()
        with os.fdopen(self.open(name), "rb") as file:
            while chunk := file.read(CHUNK):
                digest.update(chunk)
        return digest.hexdigest()

    def is_there(self, name: str) -> bool:
        """Return whether anything has this name, be it a link that leads nowhere."""
        try:
            self._status(name)
        except OSError:
            return False
        return True

    def _status(self, name: str) -> os.stat_result:
        with self._holder(name) as (holder, last):
            return os.stat(holder._at(last), dir_fd=holder._opened, follow_symlinks=False)

    def make(self, name: str) -> None:
        """Make a folder in it, unless it is there."""
        with contextlib.suppress(FileExistsError):
            os.mkdir(self._at(name), dir_fd=self._opened)
        with self.below(name):  # a link in its place, or a file, is refused
            pass

    def rename(self, old: str, new: str) -> None:
        """Give a file another name in the same folder, which nothing has."""
        with self._holder(old) as (holder, last):
            first, second, at = holder._at(last), holder._at(new.rpartition("/")[2]), holder._opened
            if os.link in os.supports_dir_fd and _linked(first, second, at):
                os.unlink(first, dir_fd=at)
                return
            if self.is_there(new):
                raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(self.path / new))
            os.rename(first, second, src_dir_fd=at, dst_dir_fd=at)

    def replace(self, old: str, new: str) -> None:
        """Give a file the name of another one in the same folder, which is gone then."""
        with self._holder(old) as (holder, last):
            at = holder._opened
            os.replace(holder._at(last), holder._at(new.rpartition("/")[2]), src_dir_fd=at, dst_dir_fd=at)

    def remove(self, name: str) -> None:
        """Remove a file."""
        with self._holder(name) as (holder, last):
            os.unlink(holder._at(last), dir_fd=holder._opened)

    def remove_empty(self, name: str) -> None:
        """Remove a folder in it, which must be empty."""
        os.rmdir(self._at(name), dir_fd=self._opened)

    @contextlib.contextmanager
    def _holder(self, name: str) -> Iterator[tuple[Folder, str]]:
        """Give the folder that holds a file, and what the file is called in it."""
        above, _, last = name.rpartition("/")
        if not above:
            yield self, last
            return
        with self.below(above) as holder:
            yield holder, last

    def _at(self, name: str) -> str:
        return name if self._opened is not None else os.path.join(self.path, name)


def _linked(first: str, second: str, at: int | None) -> bool:
    """Give a file a second name; False where the file system knows no such names."""
    try:
        os.link(first, second, src_dir_fd=at, dst_dir_fd=at, follow_symlinks=False)
    except FileExistsError:
        raise
    except OSError:
        return False
    return True


_AS_IT_IS = "\\\\?\\"

_CURRENT_FOLDER = -100  # AT_FDCWD: relative paths start from the current folder
# Flags of Linux (renameat2) and of macOS (renamex_np).
_NO_REPLACE, _EXCHANGE = (4, 2) if sys.platform == "darwin" else (1, 2)


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


def folder_wanted(out: str | os.PathLike[str]) -> Path:
    """Return a folder to be written, without links: where the path is a link, the folder that it leads to."""
    text = os.fspath(out)
    if "\0" in text:
        raise InputError("holds a NUL character and names no folder", path="--out", value=text, mend="Name a new folder")
    try:
        path = Path(text)
        ends = path.name not in ("", "..") and not path.is_symlink()
        plain = path.parent.resolve() / path.name if ends else path.resolve()
        if plain.name == "" or plain == plain.parent:
            raise InputError("is the root of a file system", path=text, mend="Name a new folder in it")
        if not plain.parent.is_dir():
            raise InputError("the folder that is to hold it does not exist", path=str(plain), mend=f"Make {plain.parent} first")
    except (OSError, RuntimeError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(f"cannot be written: {reason}", path=text, mend="Name a folder elsewhere") from None
    return Path(extended(str(plain))) if os.name == "nt" else plain


def extended(path: str) -> str:
    """Return the path of a folder as Windows takes it whatever its length; a short one as it is."""
    if len(path) < 200 or path.startswith(_AS_IT_IS):  # of a folder; with the names of files in it, Windows takes 260 characters
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
    if code in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP):  # the system does not know it
        return False
    raise OSError(code, os.strerror(code), str(old), None, str(new))
