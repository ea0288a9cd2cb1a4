"""A folder that grows over several runs of a command: each file appears complete or not at all.

Its note (`bristle.files.owned`) lists each file with its SHA-256 before the file appears. bristle writes damaged files
again and never replaces files that the user made or changed. Only one process writes at a time.
"""

import errno
import hashlib
import os
import re
import secrets
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bristle.core.errors import InputError, InputWarning
from bristle.files import owned
from bristle.files.folder import folder_wanted
from bristle.files.owned import NOTE, UNFINISHED, Folder, Note

DAMAGED = ".damaged"  # suffix of a kept file whose content differs from the written content
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.EACCES, errno.EPERM}


class Growing:
    """A folder with exclusive write access for this process."""

    def __init__(self, folder: Folder, opened: int, note: Note | None) -> None:
        self.path, self._folder, self._opened = folder.path, folder, opened
        self._sums: dict[str, set[str]] = {
            name: set(sums) for name, sums in (note.sums if note else {}).items()
        }
        self._writing = threading.Lock()

    def __truediv__(self, name: str) -> Path:
        """Return the path of a file in the folder."""
        return self.path / name

    @property
    def names(self) -> list[str]:
        """Names of the written files that still exist."""
        return [
            name for name, sums in self._sums.items() if any(sums) and self._folder.is_file(name)
        ]

    def has_held(self, name: str, content: str) -> bool:
        """Return whether a file was written with exactly this content."""
        return hashlib.sha256(
            content.encode("utf-8", "backslashreplace")
        ).hexdigest() in self._sums.get(name, ())

    def is_whole(self, name: str) -> bool:
        """Return whether a file exists with the written content."""
        return name in self.names and self._folder.checksum(name) in self._sums[name]

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None if it is missing or differs from the written content."""
        if name not in self.names:
            return None
        with os.fdopen(self._folder.open(name), "rb") as file:
            content = file.read()
        return content if hashlib.sha256(content).hexdigest() in self._sums[name] else None

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file; it appears complete under its name and replaces an earlier version."""
        if not owned.is_own_name(name):
            raise ValueError(f"{name!r} is not the name of a file")
        data = (
            content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
        )
        with self._writing:
            try:
                self._place_file(name, data)
            except OSError as error:
                if error.errno in (errno.ENOTDIR, errno.ELOOP):
                    raise InputError(
                        "is a link or a file, not a folder",
                        path=str((self.path / name).parent),
                        mend="Move it to another place",
                    ) from error
                if error.errno not in _FULL:
                    raise
                reason = os.strerror(error.errno or 0).lower()
                raise InputError(
                    f"cannot be written: {reason}",
                    path=str(self.path / name),
                    mend="Make room on the disk and repeat the command. Existing files stay",
                ) from error
        return self.path / name

    def _place_file(self, name: str, data: bytes) -> None:
        holder = name.rpartition("/")[0]
        if holder:
            self._folder.make(holder)
        present = self._folder.is_there(name)
        if present and not self.is_whole(name):
            raise InputError(
                "was changed, or was not written by bristle",
                path=str(self.path / name),
                mend="Move it to another place, because bristle would replace it",
            )
        partial = f"{holder}/" * bool(holder) + f"bristle-{secrets.token_hex(16)}.partial"
        owned.write_line(self._opened, {"file": partial})
        try:
            with os.fdopen(
                self._folder.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb"
            ) as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            checksum = hashlib.sha256(data).hexdigest()
            owned.write_line(self._opened, {"file": name, "sha256": checksum})
            os.fsync(self._opened)
            self._sums.setdefault(name, set()).add(checksum)
            (self._folder.replace if present else self._folder.rename)(partial, name)
        except BaseException:
            with suppress(OSError):
                self._folder.remove(partial)
            raise
        owned.sync_folder((self.path / name).parent)

    def make(self, name: str) -> None:
        """Make a folder in it if it is missing."""
        self._folder.make(name)

    def claim(self, name: str) -> None:
        """Note a file that the command writes itself, line by line."""
        if name not in self._sums:
            owned.write_line(self._opened, {"file": name})
            self._sums[name] = set()

    def remove(self, name: str) -> None:
        """Remove a written file, unless its content was changed."""
        if self.is_whole(name):
            self._folder.remove(name)

    def set_all_aside(self, names: Iterable[str]) -> None:
        """Rename files with content of another origin, because the user may have written it, and warn; they will be written again."""
        for name in names:
            aside, count = f"{name}{DAMAGED}", 1
            while self._folder.is_there(aside):
                count += 1
                aside = f"{name}{DAMAGED}-{count}"
            self._folder.rename(name, aside)
            what = "is damaged, or was written by somebody else: bristle keeps it as"
            warnings.warn(
                f"{self.path / name} {what} {aside}, and writes the file again",
                InputWarning,
                stacklevel=2,
            )


@contextmanager
def growing_folder(
    out: str | os.PathLike[str],
    kind: str,
    *,
    made_anew: Callable[[str], bool] = lambda name: False,
    used: Callable[[str], bool] = lambda name: True,
) -> Iterator[tuple[Growing, list[str]]]:
    """Open a new or existing folder exclusively for this process; yield it with its damaged files."""
    path = folder_wanted(out)
    if os.path.lexists(path) and not path.is_dir():
        raise InputError("is a file, not a folder", path=str(path), mend="Name another folder")
    try:
        if not os.path.lexists(path):
            os.mkdir(path)
        with Folder(path) as folder:
            note = owned.note_in(folder)
            opened = (
                _new_note_in(folder, path, kind)
                if note is None
                else folder.open(NOTE, os.O_RDWR | os.O_APPEND)
            )
            try:
                try:
                    owned.lock(opened)
                except BlockingIOError:
                    holder = (
                        f" (process {note.process})" if note is not None and note.process else ""
                    )
                    raise InputError(
                        f"another process{holder} is writing to this folder",
                        path=str(path),
                        mend="Wait for its end, or name another folder",
                    ) from None
                damaged = _looked_through(folder, note, path, kind, made_anew, used) if note else []
                owned.complete(opened)
                owned.write_line(opened, {"process": str(os.getpid())})
                for name in note.files if note is not None else ():
                    # An unfinished file of a killed process: the lock shows that no process writes. A user file was refused before.
                    if UNFINISHED.fullmatch(name) and folder.is_file(name):
                        with suppress(OSError):
                            folder.remove(name)
                yield Growing(folder, opened, note), damaged
            finally:
                os.close(opened)
    except OSError as error:
        if isinstance(error.filename, (str, os.PathLike)) and not str(error.filename).startswith(
            str(path)
        ):
            raise
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"cannot be written: {reason}",
            path=str(path),
            mend="Name another folder, or repeat the command",
        ) from error


def _new_note_in(folder: Folder, path: Path, kind: str) -> int:
    """Create the note of an empty folder and return it opened."""
    if folder.names() == [NOTE] and not folder.size(NOTE):
        folder.remove(NOTE)  # of a process that was killed before it wrote a line
    if present := folder.names():
        present = [inside for name in present for inside in _opened(folder, name)] or present
        raise InputError(
            f"is not a folder of a {kind}, but contains {owned.listed(present)}",
            path=str(path),
            mend="Name another folder",
        )
    return owned.new_note(path, secrets.token_hex(16), path.name, kind)


def verified(path: Path, names: list[str]) -> None:
    """Refuse files of a folder whose content differs from the written content."""
    with Folder(path) as folder:
        note = owned.note_in(folder)
        if folder.is_there(NOTE) and not (note and note.is_intact):
            raise InputError(DAMAGED_NOTE, path=str(path / NOTE), mend=MEND_NOTE)
        damaged = (
            [name for name in names if folder.checksum(name) not in note.sums.get(name, ())]
            if note is not None
            else []
        )
    if damaged:
        raise InputError(
            f"contains files that are damaged or were not written here: {owned.listed(damaged)}",
            path=str(path),
            mend="Repeat the command that wrote the folder. It repeats the damaged runs and keeps the damaged files under new names",
        )


DAMAGED_NOTE = "is damaged or was changed, so bristle no longer knows which files it wrote"
MEND_NOTE = "Undo the change to this file. Or name another folder, into which the command writes everything again"


def _looked_through(
    folder: Folder,
    note: Note,
    path: Path,
    kind: str,
    made_anew: Callable[[str], bool],
    used: Callable[[str], bool],
) -> list[str]:
    """Return the damaged files to write again; refuse files that the user made or changed."""
    if note.kind != kind:
        message = f"contains {f'a {note.kind}' if note.kind else 'results of another command'}, not a {kind}"
        raise InputError(message, path=str(path), mend="Name another folder")
    foreign, changed = owned.strangers_in(folder, note)
    if NOTE in changed:
        raise InputError(DAMAGED_NOTE, path=str(path / NOTE), mend=MEND_NOTE)
    foreign = [inside for name in foreign for inside in _opened(folder, name)]
    foreign = [
        name
        for name in foreign
        if used(name) and not re.search(rf"{re.escape(DAMAGED)}(-\d+)?$", name)
    ]
    if foreign:
        raise InputError(
            f"contains files that bristle did not write: {owned.listed(foreign)}",
            path=str(path),
            mend="Move these files to another place, because the command would replace or read them",
        )
    # Others are unfinished
    changed = [name for name in changed if not UNFINISHED.fullmatch(name) or note.sums[name]]
    if altered := [name for name in changed if UNFINISHED.fullmatch(name) or not made_anew(name)]:
        raise InputError(
            f"contains files that were changed: {owned.listed(altered)}",
            path=str(path),
            mend="Move these files to another place, because the command would replace them",
        )
    return changed


def _opened(folder: Folder, name: str) -> list[str]:
    """Return the names in a subfolder, or the name itself if it is not a folder; an empty folder gives an empty list."""
    try:
        with folder.below(name) as inside:
            return [f"{name}/{child}" for child in inside.names()]
    except OSError:
        return [name]
