"""What is bristle's own in a folder: exactly the files that a note in it names, as bristle wrote them.

The note ``.bristle-results`` has one JSON object a line. The first says who wrote it, each other one names a file,
before it is written and again, with its SHA-256, once all are. What the note does not name, or what has another content
by now, is a person's. A file may lie in a folder below: ``figures/time.svg``. Links are never followed.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import stat
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

__all__ = [
    "NOTE",
    "Folder",
    "Note",
    "is_own_name",
    "is_plain",
    "lock",
    "new_note",
    "note_in",
    "remove_own",
    "strangers_in",
    "sync_folder",
    "write_line",
]

NOTE = ".bristle-results"
LARGEST_NOTE = 2**20  # [byte]
CHUNK = 2**20
DEEPEST = 2  # names in the path of a file
_NO_LINKS = getattr(os, "O_NOFOLLOW", 0)
_BINARY = getattr(os, "O_BINARY", 0)
_LOCKED_BYTE = 2**30  # far behind the end of a note: where locks keep others from reading, they keep nobody from it


@dataclass(frozen=True)
class Note:
    """What the note of a folder says.

    Parameters
    ----------
    token : str
        What tells this folder from any other.
    target : str
        What the folder was to be called.
    began : int
        When it was made [ns since 1970].
    files : mapping of str to str
        SHA-256 by name; empty for a file that may be half written.
    """

    token: str
    target: str
    began: int
    files: Mapping[str, str]

    @property
    def folders(self) -> list[str]:
        """The folders below that hold files of it."""
        return sorted({name.partition("/")[0] for name in self.files if "/" in name})


class Folder:
    """A folder that is held open, so that what is done in it is done in that very folder, whatever its path is now.

    Files of it are named as they stand in it, those in a folder below with that folder: ``figures/time.svg``.

    Parameters
    ----------
    path : Path
        The folder.
    above : Folder, optional
        The folder that holds it, held open.

    Raises
    ------
    OSError
        If it cannot be opened, or is a link.
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

    def checksum(self, name: str) -> str:
        """Return the SHA-256 of a file."""
        digest = hashlib.sha256()
        with os.fdopen(self.open(name), "rb") as file:
            while chunk := file.read(CHUNK):
                digest.update(chunk)
        return digest.hexdigest()

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


def new_note(folder: Path, token: str, target: str) -> int:
    """Write the note into a folder that was just made; return it opened and locked.

    Raises
    ------
    OSError
        If there is one already, or it cannot be written.
    """
    with Folder(folder) as inside:
        opened = inside.open(NOTE, os.O_RDWR | os.O_CREAT | os.O_EXCL)
    try:
        # Locked before anything stands in it: a note that can be read and is not locked is that of a dead process.
        lock(opened)
        write_line(
            opened, {"bristle": version("bristle"), "folder": token, "target": target, "began": str(time.time_ns())}
        )
    except BaseException:
        os.close(opened)
        raise
    return opened


def write_line(opened: int, line: Mapping[str, str]) -> None:
    """Append a line to a note."""
    text = json.dumps(line).encode() + b"\n"
    while text:
        text = text[os.write(opened, text) :]


def lock(opened: int) -> bool:
    """Lock a note, without waiting; return False where locks are not known. It ends with the process.

    Raises
    ------
    BlockingIOError
        If another process has it.
    """
    try:
        import fcntl
    except ImportError:
        return _lock_byte(opened)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a file system of another machine may know none
        return False
    return True


def _lock_byte(opened: int) -> bool:
    import msvcrt

    at = os.lseek(opened, 0, os.SEEK_CUR)
    try:
        os.lseek(opened, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
    except OSError as error:
        raise BlockingIOError(errno.EAGAIN, "locked") from error
    finally:
        os.lseek(opened, at, os.SEEK_SET)
    return True


def note_in(folder: Folder) -> Note | None:
    """Return the note of a folder; None where it has none that bristle wrote."""
    try:
        if not folder.is_file(NOTE):
            return None
        with os.fdopen(folder.open(NOTE), "rb") as file:
            text = file.read(LARGEST_NOTE + 1)
    except OSError:
        return None
    return _note_of(text) if len(text) <= LARGEST_NOTE else None


def _note_of(text: bytes) -> Note | None:
    head, *lines = _objects_in(text)
    token, target, began = (head.get(key) for key in ("folder", "target", "began"))
    if "bristle" not in head or not (isinstance(token, str) and isinstance(target, str) and isinstance(began, str)):
        return None
    if not re.fullmatch(r"\d{1,20}", began):
        return None
    files: dict[str, str] = {}
    for line in lines:
        name, checksum = line.get("file"), line.get("sha256", "")
        if not isinstance(name, str) or not isinstance(checksum, str) or not is_own_name(name):
            return None
        files[name] = checksum
    return Note(token, target, int(began), files)


def _objects_in(text: bytes) -> Iterator[dict[str, object]]:
    """Yield the objects of the whole lines, the first one in any case: the last line may be cut."""
    complete = text.decode("utf-8", "replace").split("\n")[:-1]
    for index, line in enumerate(complete or [""]):
        try:
            parsed = json.loads(line)
        except (ValueError, RecursionError):
            parsed = None
        if isinstance(parsed, dict):
            yield parsed
        elif index == 0:
            yield {}


def sync_folder(folder: Path) -> None:
    """Have on the disk what a folder says is in it."""
    if os.name != "posix":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def is_plain(name: str) -> bool:
    """Return whether this is the name of something in a folder, and leads nowhere else."""
    return name not in ("", ".", "..", NOTE) and not set(name) & {"/", "\\", "\0"}


def is_own_name(name: str) -> bool:
    """Return whether this is the name of something in a folder, or in a folder below it, and leads nowhere else."""
    parts = name.split("/")
    return len(parts) <= DEEPEST and all(map(is_plain, parts))


def strangers_in(folder: Folder, note: Note) -> tuple[list[str], list[str]]:
    """Return what a person put into a folder, and what of bristle's own a person changed."""
    present = list(_names_in(folder, note.folders))
    foreign = [name for name in present if name not in note.files]
    own = [name for name in present if name in note.files]
    changed = [name for name in own if not folder.is_file(name) or folder.checksum(name) != note.files[name]]
    return foreign, changed


def _names_in(folder: Folder, opened: list[str]) -> Iterator[str]:
    """Yield what is in a folder but its note; of folders that bristle wrote into, what is in them."""
    for name in folder.names():
        if name == NOTE:
            continue
        try:
            inside = folder.below(name) if name in opened else None
            with inside or contextlib.nullcontext():
                yield from [name] if inside is None else [f"{name}/{child}" for child in inside.names()]
        except OSError:  # a file or a link is in its place
            yield name


def remove_own(path: Path, *, half_written: bool = False) -> bool:
    """Remove what is bristle's own in a folder, and the folder if nothing else is in it.

    Parameters
    ----------
    path : Path
        The folder.
    half_written : bool
        Whether files of which the note has no checksum are bristle's own, too: they were being written.

    Returns
    -------
    bool
        Whether the folder is gone.
    """
    try:
        with Folder(path) as folder:
            note = note_in(folder)
            if note is None:
                return False
            for name, checksum in note.files.items():
                with contextlib.suppress(OSError):
                    is_own = folder.is_file(name) and (folder.checksum(name) == checksum if checksum else half_written)
                    if is_own:
                        folder.remove(name)
            for name in note.folders:
                with contextlib.suppress(OSError):
                    folder.remove_empty(name)
            if folder.names() == [NOTE]:
                folder.remove(NOTE)
        os.rmdir(path)
    except OSError:
        return False
    return True
