"""A folder that is held open, and the files in it: links are never followed."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

__all__ = ["Folder"]

CHUNK = 2**20
_NO_LINKS = getattr(os, "O_NOFOLLOW", 0)
_BINARY = getattr(os, "O_BINARY", 0)


class Folder:
    """A folder that is held open, so that what is done in it is done in that very folder, whatever its path is now.

    Files of it are named as they stand in it, those in a folder below with that folder: ``figures/time.svg``.
    """

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
            with self._holder(name) as (holder, last):
                status = os.stat(holder._at(last), dir_fd=holder._opened, follow_symlinks=False)
        except OSError:
            return False
        return stat.S_ISREG(status.st_mode)

    def open(self, name: str, flags: int = os.O_RDONLY) -> int:
        """Return a file opened; a link is not followed."""
        with self._holder(name) as (holder, last):
            return os.open(holder._at(last), flags | _NO_LINKS | _BINARY, 0o666, dir_fd=holder._opened)

    def size(self, name: str) -> int:
        """Return how large a file is [byte]."""
        with self._holder(name) as (holder, last):
            return os.stat(holder._at(last), dir_fd=holder._opened, follow_symlinks=False).st_size

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
            with self._holder(name) as (holder, last):
                os.stat(holder._at(last), dir_fd=holder._opened, follow_symlinks=False)
        except OSError:
            return False
        return True

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
