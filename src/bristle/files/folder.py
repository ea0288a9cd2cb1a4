"""Folders that stay open, and atomic renaming of folders; links are never followed."""

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
    """A folder that stays open: operations act on this folder even if its path changes."""

    def __init__(self, path: Path, above: Folder | None = None) -> None:
        self.path = path
        self._above = above
        self._opened: int | None = None

    def __enter__(self) -> Folder:
        if os.stat in os.supports_dir_fd and hasattr(os, "O_DIRECTORY"):
            location, above = (
                (self.path, None) if self._above is None else (self.path.name, self._above._opened)
            )
            self._opened = os.open(location, os.O_RDONLY | os.O_DIRECTORY | _NO_LINKS, dir_fd=above)
        elif not stat.S_ISDIR(os.lstat(self.path).st_mode):
            raise OSError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(self.path))
        return self

    def __exit__(self, *_: object) -> None:
        if self._opened is not None:
            os.close(self._opened)

    def names(self) -> list[str]:
        """Return the names in it."""
        return sorted(os.listdir(self.path if self._opened is None else self._opened))

    def below(self, name: str) -> Folder:
        """Return a folder in it, to be opened."""
        return Folder(self.path / name, above=self)

    def is_file(self, name: str) -> bool:
        """Return whether this is a regular file and not a link."""
        try:
            return stat.S_ISREG(self._status(name).st_mode)
        except OSError:
            return False

    def open(self, name: str, flags: int = os.O_RDONLY) -> int:
        """Open a file without following a link."""
        with self._holder(name) as (holder, last):
            return os.open(
                holder._at(last),
                flags | _NO_LINKS | getattr(os, "O_BINARY", 0),
                0o666,
                dir_fd=holder._opened,
            )

    def size(self, name: str) -> int:
        """Return the size of a file [byte]."""
        return self._status(name).st_size

    def checksum(self, name: str) -> str:
        """Return the SHA-256 of a file."""
        digest = hashlib.sha256()
        with os.fdopen(self.open(name), "rb") as file:
            while chunk := file.read(CHUNK):
                digest.update(chunk)
        return digest.hexdigest()

    def is_there(self, name: str) -> bool:
        """Return whether the name exists, even as a broken link."""
        try:
            self._status(name)
        except OSError:
            return False
        return True

    def _status(self, name: str) -> os.stat_result:
        with self._holder(name) as (holder, last):
            return os.stat(holder._at(last), dir_fd=holder._opened, follow_symlinks=False)

    def make(self, name: str) -> None:
        """Make a folder in it if it is missing."""
        with contextlib.suppress(FileExistsError):
            os.mkdir(self._at(name), dir_fd=self._opened)
        with self.below(name):  # a link in its place, or a file, is refused
            pass

    def rename(self, old: str, new: str) -> None:
        """Rename a file to an unused name in the same folder."""
        with self._holder(old) as (holder, last):
            first, second, at = holder._at(last), holder._at(new.rpartition("/")[2]), holder._opened
            if os.link in os.supports_dir_fd and _linked(first, second, at):
                os.unlink(first, dir_fd=at)
                return
            if self.is_there(new):
                raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(self.path / new))
            os.rename(first, second, src_dir_fd=at, dst_dir_fd=at)

    def replace(self, old: str, new: str) -> None:
        """Rename a file in the same folder and replace the file that has this name."""
        with self._holder(old) as (holder, last):
            at = holder._opened
            os.replace(
                holder._at(last), holder._at(new.rpartition("/")[2]), src_dir_fd=at, dst_dir_fd=at
            )

    def remove(self, name: str) -> None:
        """Remove a file."""
        with self._holder(name) as (holder, last):
            os.unlink(holder._at(last), dir_fd=holder._opened)

    def remove_empty(self, name: str) -> None:
        """Remove a folder in it, which must be empty."""
        os.rmdir(self._at(name), dir_fd=self._opened)

    @contextlib.contextmanager
    def _holder(self, name: str) -> Iterator[tuple[Folder, str]]:
        """Yield the folder that contains a file, and the name of the file in it."""
        above, _, last = name.rpartition("/")
        if not above:
            yield self, last
            return
        with self.below(above) as holder:
            yield holder, last

    def _at(self, name: str) -> str:
        return name if self._opened is not None else os.path.join(self.path, name)


def _linked(first: str, second: str, at: int | None) -> bool:
    """Give a file a second name; False if the file system does not support hard links."""
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
    """Rename a folder to an unused name."""
    if _rename(old, new, _NO_REPLACE):
        return
    if os.path.lexists(new):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(new))
    os.rename(old, new)


def exchange(first: Path, second: Path) -> bool:
    """Exchange the names of two folders in one step; return False without a change if the system cannot."""
    return _rename(first, second, _EXCHANGE)


def folder_wanted(out: str | os.PathLike[str]) -> Path:
    """Return the folder to be written; if the path is a link, return its target."""
    text = os.fspath(out)
    if "\0" in text:
        raise InputError(
            "contains a NUL character", path="--out", value=text, mend="Name a new folder"
        )
    try:
        path = Path(text)
        ends = path.name not in ("", "..") and not path.is_symlink()
        plain = path.parent.resolve() / path.name if ends else path.resolve()
        if plain.name == "" or plain == plain.parent:
            raise InputError(
                "is the root of a file system", path=text, mend="Name a new folder in it"
            )
        if not plain.parent.is_dir():
            raise InputError(
                "its parent folder does not exist",
                path=str(plain),
                mend=f"Make {plain.parent} first",
            )
    except (OSError, RuntimeError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(
            f"cannot be written: {reason}", path=text, mend="Name a folder in another place"
        ) from None
    return Path(extended(str(plain))) if os.name == "nt" else plain


def extended(path: str) -> str:
    """Return the path of a folder with the prefix that Windows needs for long paths; a short path is unchanged."""
    # For the folder only; Windows accepts 260 characters with the name of a file.
    if len(path) < 200 or path.startswith(_AS_IT_IS):
        return path
    if path.startswith("\\\\"):
        return f"{_AS_IT_IS}UNC\\{path[2:]}"
    return _AS_IT_IS + path


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
    # Not supported by the system.
    if code in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP):
        return False
    raise OSError(code, os.strerror(code), str(old), None, str(new))
