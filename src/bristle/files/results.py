"""A folder of results appears whole or not at all, and never in place of what a person made.

Everything is written and synced in a folder beside the one wanted, which changes names with it in one step; the old one is
removed last. What a killed program left behind is removed by the next one that succeeds there. Nothing is ever removed
but files that bristle wrote and that nobody changed (`bristle.files.owned`).
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import stat
import threading
import time
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Literal

from bristle.core.content import Readable, noting_what_is_read, read_in
from bristle.core.errors import InputError, InputWarning
from bristle.files import owned
from bristle.files.folder import exchange, folder_wanted, rename_new
from bristle.files.owned import NOTE, Folder, Note

SUMMARY = "summary.json"  # The file that every folder of results of a command holds

_WRITING = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS, errno.EIO, errno.ENAMETOOLONG}
PATIENCE = 2.0  # [s]
_open: set[Results] = set()
_removing = threading.Lock()

State = Literal["written", "dead", "unknown"]


class Results:
    """A folder while results are written into it: ``folder / "report.html"`` is where a file of it is written.

    A file may lie in a folder below, ``folder / "figures/time.svg"``, which is made with the first one. A name is noted
    before its path is given, so that what is bristle's own is known whatever happens.
    """

    def __init__(self, path: Path, note: int) -> None:
        self.path = path
        self._note: int | None = note
        self._names: list[str] = []

    def __truediv__(self, name: str) -> Path:
        """Note a file as one of the results, and return where to write it."""
        if not owned.is_own_name(name):
            raise ValueError(f"{name!r} is not the name of a file")
        if self._note is not None and name not in self._names:
            owned.write_line(self._note, {"file": name})
            self._names.append(name)
        path = self.path / name
        if path.parent != self.path:
            path.parent.mkdir(exist_ok=True)
        return path

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file of the results, text in UTF-8 with plain line ends; what cannot be encoded is escaped."""
        path = self / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace"))
        return path

    def sync(self) -> None:
        """Note what the files hold, and have all of it on the disk."""
        if not self._names or self._note is None:
            raise RuntimeError("results without a file")
        with Folder(self.path) as folder:
            for name in self._names:
                owned.write_line(self._note, {"file": name, "sha256": folder.checksum(name)})
                with os.fdopen(folder.open(name, os.O_RDWR), "rb") as file:
                    os.fsync(file.fileno())
        os.fsync(self._note)
        for holder in sorted({(self.path / name).parent for name in self._names} | {self.path}, reverse=True):
            owned.sync_folder(holder)

    def close(self) -> None:
        """Let go of the note."""
        if self._note is not None:
            os.close(self._note)
        self._note = None


@contextmanager
def results_folder(out: str | os.PathLike[str], *, force: bool = False, reads: Iterable[Readable | None] = ()) -> Iterator[Results]:
    """Give a folder to write results into; leaving the block without an error makes it appear as `out`.

    What would prevent that (`out` exists, no place to write) is refused on entry, before any work is done.
    """
    target = folder_wanted(out)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError("no permission to write there", path=str(target), mend="Name a folder of your own")
    for path, note, state in () if os.path.lexists(target) else _unfinished_in(target.parent):
        # Results whose name a program had taken away as it was killed, to put others in their place, get it back.
        if path.suffix == ".replaced" and state == "dead" and note.target == target.name:
            with suppress(OSError):
                rename_new(path, target)
    results = None
    try:
        with noting_what_is_read(reads):
            _check_free(target, force)
            results = _begin(target)
            _refuse_two_at_once(results.path, target)
            yield results
            results.sync()
            _publish(results, target, force)
    except BaseException as error:
        if results is not None:
            _abandon(results)
        if isinstance(error, OSError):
            prefixes = (str(target), *([str(results.path)] if results is not None else []))
            concerns = isinstance(error.filename, (str, os.PathLike)) and os.fspath(error.filename).startswith(prefixes)
            if error.errno in _WRITING or concerns:
                raise _unwritable(target, error) from error
        raise
    with suppress(OSError):  # what programs left that were killed: only theirs, only dead ones
        for path, _, state in _unfinished_in(target.parent):
            if state == "dead":
                owned.remove_own(path, half_written=True)


def remove_unfinished() -> None:
    """Remove what is being written in this process: for one that is about to be ended by force, from another thread."""
    for results in list(_open):
        _abandon(results)
    # The thread that writes may be about to do the same.
    if _removing.acquire(timeout=PATIENCE):
        _removing.release()


def _check_free(target: Path, force: bool) -> None:
    """Refuse a folder that is there, but for unchanged results of bristle's own that are to be replaced."""
    try:
        status = os.lstat(target)
    except FileNotFoundError:
        return
    except OSError as error:
        raise _unwritable(target, error) from None
    if stat.S_ISLNK(status.st_mode):
        raise InputError(f"is a link to {os.readlink(target)}", path=str(target), mend="Name the folder itself")
    if not stat.S_ISDIR(status.st_mode):
        raise InputError("is a file, not a folder", path=str(target), mend="Name another folder")
    try:
        with Folder(target) as folder:
            _check_own(folder, target)
            used = read_in(target)
            for is_so, message, mend in (
                (not force, "exists already", "Name another folder, or add --force to replace these results"),
                (used, f"holds what is read here: {owned.listed(used)}", "It would be replaced with the rest: name another folder"),
                (target.is_mount(), "is a mount point and cannot be renamed", "Name a folder in it"),
                (not status.st_mode & stat.S_IWUSR, "is write-protected", "Name another folder"),
            ):
                if is_so:
                    raise InputError(message, path=str(target), mend=mend)
    except OSError as error:
        raise _unwritable(target, error) from None


def _check_own(folder: Folder, target: Path) -> None:
    note, present = owned.note_in(folder), folder.names()
    rename, foreign, changed = "Name another folder", [], []
    if note is None and not present:
        message, mend = "exists already, and bristle did not make it", "Name a new folder, or remove this empty one"
    elif note is None and SUMMARY in present:
        message = (
            f"holds results without the note {NOTE} that tells what is bristle's own there, as those of bristle 0.1: they are not replaced"
        )
        mend = f"{rename}, or remove by hand what is no longer needed: {owned.listed(present)}"
    elif note is None:
        message, mend = f"holds something else than results: {owned.listed(present)}", rename
    elif note.kind:
        message = f"holds a {note.kind}, which grew over many runs and is replaced by nothing"
        mend = f"{rename}, or remove this one by hand"
    else:
        foreign, changed = owned.strangers_in(folder, note)
        if not foreign and not changed:
            return
        reason = "holds files besides the results" if foreign else "holds files that were changed since"
        message = f"{reason}: {owned.listed(foreign or changed)}"
        mend = "Move them elsewhere, for the whole folder is replaced, or name another"
    raise InputError(message, path=str(target), mend=mend)


def _begin(target: Path) -> Results:
    """Make the folder to write into, with a name that nobody has, and note that it is bristle's own."""
    token = secrets.token_hex(16)
    path = target.with_name(f"bristle-{token}.partial")
    try:
        os.mkdir(path)
        results = Results(path, owned.new_note(path, token, target.name))
        _open.add(results)
    except BaseException as error:
        _remove_begun(path, own=True)
        if isinstance(error, OSError):
            raise _unwritable(target, error) from error
        raise
    return results


def _remove_begun(path: Path, *, own: bool = False) -> None:
    """Remove a folder in which nothing stands but, perhaps, a note; an empty note where the folder may be another's."""
    with suppress(OSError):
        with Folder(path) as folder:
            if folder.names() == [NOTE] and (own or not folder.size(NOTE)):
                folder.remove(NOTE)
        os.rmdir(path)


def _abandon(results: Results) -> None:
    with _removing:
        _open.discard(results)
        removed = owned.remove_own(results.path, half_written=True)
        results.close()
        # Where no more files can be opened, the one just closed may be what was lacking.
        removed = removed or owned.remove_own(results.path, half_written=True)
    if not removed and os.path.lexists(results.path):
        warnings.warn(f"{results.path} stays: it holds what bristle did not write, or cannot be removed", InputWarning, stacklevel=2)


def _unfinished_in(parent: Path) -> Iterator[tuple[Path, Note, State]]:
    """Yield folders that programs write into, or wrote into as they were killed."""
    for name in sorted(os.listdir(parent)):
        if (match := re.fullmatch(r"bristle-([0-9a-f]{32})\.(?:partial|replaced)", name)) is None:
            continue
        with suppress(OSError), Folder(parent / name) as folder:
            note = owned.note_in(folder)
            if note is None:
                if os.lstat(parent / name).st_mtime < time.time() - 60.0:  # [s]
                    _remove_begun(parent / name)  # killed before the note was written; nothing else is in it
                continue
            if match[1] in (note.token, note.aside):  # else a person's own: a copy, or a folder that was renamed
                yield parent / name, note, _state_of(folder)


def _state_of(folder: Folder) -> State:
    """Return whether a program writes into a folder: it is left alone where that cannot be told, or it is another's."""
    opened = folder.open(NOTE, os.O_RDWR)
    try:
        locked = owned.lock(opened)
        own = not hasattr(os, "getuid") or os.fstat(opened).st_uid == os.getuid()
    except BlockingIOError:
        return "written"
    finally:
        os.close(opened)
    return "dead" if locked and own else "unknown"


def _refuse_two_at_once(own: Path, target: Path) -> None:
    """Refuse to write where another program has begun to; of two that begin at once, the earlier one goes on."""
    writing = {
        path: (note.began, path.name)
        for path, note, state in _unfinished_in(target.parent)
        if state == "written" and note.target == target.name
    }
    if own in writing and min(writing.values()) < writing[own]:
        raise InputError("another process is writing results there", path=str(target), mend="Wait for it to end, or name another folder")


def _publish(results: Results, target: Path, force: bool) -> None:
    """Let the results appear; what a person did there meanwhile is not replaced."""
    if os.name == "nt":
        results.close()  # there a folder with an open file in it cannot be renamed
    _check_free(target, force)
    old = _replace(results.path, target) if os.path.lexists(target) else None
    if old is None:
        rename_new(results.path, target)
    _open.discard(results)
    owned.sync_folder(target.parent)
    results.close()
    if old is None:
        return
    for pause in (0.0, 0.02, 0.2):  # [s]
        time.sleep(pause)
        # Another process that succeeds here may be removing them, too, and is waited for.
        if owned.remove_own(old) or not os.path.lexists(old):
            return
    warnings.warn(f"{old}: the results replaced could not be removed", InputWarning, stacklevel=2)


def _replace(new: Path, target: Path) -> Path:
    """Put a folder in the place of another one; return where that one is now, which its note says before."""
    owned.note_aside(target, new.stem.removeprefix("bristle-"))
    if exchange(new, target):
        return new
    aside = new.with_suffix(".replaced")
    rename_new(target, aside)
    try:
        rename_new(new, target)
    except BaseException:
        rename_new(aside, target)
        raise
    return aside


def _unwritable(target: Path, error: OSError | RuntimeError) -> InputError:
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    return InputError(
        f"the results cannot be written: {reason}",
        path=str(target),
        mend="Nothing was changed there. Close what has its files open, make room, or name a folder elsewhere",
    )
