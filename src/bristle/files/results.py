"""Write a folder of results completely or not at all, without replacing files of the user.

bristle writes and syncs all files in a temporary folder, which replaces the wanted folder in one step; the old folder is
removed last. The next successful program in this place removes the remains of killed programs. bristle removes only
unchanged files that it wrote (`bristle.files.owned`).
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

SUMMARY = "summary.json"  # Name of the file with the numbers of a run, in every folder of results

_WRITING = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS, errno.EIO, errno.ENAMETOOLONG}
PATIENCE = 2.0  # [s]
_open: set[Results] = set()
_removing = threading.Lock()

State = Literal["written", "dead", "unknown"]


class Results:
    """A folder of results during writing: ``folder / "report.html"`` is the path of a file in it.

    A file may be in a subfolder, ``folder / "figures/time.svg"``; the first file makes the subfolder. Each name is noted
    before its path is returned, so that the files of bristle are known even after a crash.
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
        """Write a file of the results, text in UTF-8 with LF line ends; characters that cannot be encoded are escaped."""
        path = self / name
        path.write_bytes(
            content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
        )
        return path

    def sync(self) -> None:
        """Note the checksums of the files, and flush everything to the disk."""
        if not self._names or self._note is None:
            raise RuntimeError("results without a file")
        with Folder(self.path) as folder:
            for name in self._names:
                owned.write_line(self._note, {"file": name, "sha256": folder.checksum(name)})
                with os.fdopen(folder.open(name, os.O_RDWR), "rb") as file:
                    os.fsync(file.fileno())
        os.fsync(self._note)
        for holder in sorted(
            {(self.path / name).parent for name in self._names} | {self.path}, reverse=True
        ):
            owned.sync_folder(holder)

    def close(self) -> None:
        """Close the note."""
        if self._note is not None:
            os.close(self._note)
        self._note = None


@contextmanager
def results_folder(
    out: str | os.PathLike[str], *, force: bool = False, reads: Iterable[Readable | None] = ()
) -> Iterator[Results]:
    """Yield a folder for results; it appears as `out` when the block ends without an error.

    Obstacles (`out` exists, no permission to write) are refused on entry, before any work.
    """
    target = folder_wanted(out)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(
            "no permission to write there",
            path=str(target),
            mend="Name a folder where you can write",
        )
    for path, note, state in () if os.path.lexists(target) else _unfinished_in(target.parent):
        # Restore the name of results that a killed program had renamed in order to replace them.
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
            concerns = isinstance(error.filename, (str, os.PathLike)) and os.fspath(
                error.filename
            ).startswith(prefixes)
            if error.errno in _WRITING or concerns:
                raise _unwritable(target, error) from error
        raise
    with suppress(OSError):  # remains of killed programs only
        for path, _, state in _unfinished_in(target.parent):
            if state == "dead":
                owned.remove_own(path, half_written=True)


def remove_unfinished() -> None:
    """Remove unfinished results of this process; call it from another thread before the process is killed."""
    for results in list(_open):
        _abandon(results)
    # The writing thread may be doing the same.
    if _removing.acquire(timeout=PATIENCE):
        _removing.release()


def _check_free(target: Path, force: bool) -> None:
    """Refuse an existing folder, except unchanged results of bristle with `force`."""
    try:
        status = os.lstat(target)
    except FileNotFoundError:
        return
    except OSError as error:
        raise _unwritable(target, error) from None
    if stat.S_ISLNK(status.st_mode):
        raise InputError(
            f"is a link to {os.readlink(target)}", path=str(target), mend="Name the folder itself"
        )
    if not stat.S_ISDIR(status.st_mode):
        raise InputError("is a file, not a folder", path=str(target), mend="Name another folder")
    try:
        with Folder(target) as folder:
            _check_own(folder, target)
            used = read_in(target)
            for is_so, message, mend in (
                (
                    not force,
                    "exists already",
                    "Name another folder, or add --force to replace these results",
                ),
                (
                    used,
                    f"contains input files of this command: {owned.listed(used)}",
                    "Name another folder, because bristle would replace this folder",
                ),
                (
                    target.is_mount(),
                    "is a mount point and cannot be renamed",
                    "Name a folder in it",
                ),
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
        message, mend = (
            "exists already, and bristle did not make it",
            "Name a new folder, or remove this empty folder",
        )
    elif note is None and SUMMARY in present:
        message = f"contains results without the file {NOTE}, which lists the files of bristle (bristle 0.1 did not write it)"
        mend = f"{rename}, or remove by hand the files that you no longer need: {owned.listed(present)}"
    elif note is None:
        message, mend = f"contains other files than results: {owned.listed(present)}", rename
    elif note.kind:
        message = f"contains a {note.kind} of many runs, which bristle never replaces"
        mend = f"{rename}, or remove this folder by hand"
    else:
        foreign, changed = owned.strangers_in(folder, note)
        if not foreign and not changed:
            return
        reason = (
            "contains other files besides the results"
            if foreign
            else "contains files that were changed"
        )
        message = f"{reason}: {owned.listed(foreign or changed)}"
        mend = "Name another folder. Or move these files to another place, because bristle would replace the whole folder"
    raise InputError(message, path=str(target), mend=mend)


def _begin(target: Path) -> Results:
    """Make the temporary folder with an unused name, and note that bristle made it."""
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
    """Remove a folder that is empty except for a note; the note must be empty unless the folder is `own`."""
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
        # If the limit of open files was reached, closing one may help.
        removed = removed or owned.remove_own(results.path, half_written=True)
    if not removed and os.path.lexists(results.path):
        warnings.warn(
            f"bristle keeps {results.path}, because it contains other files or cannot be removed",
            InputWarning,
            stacklevel=2,
        )


def _unfinished_in(parent: Path) -> Iterator[tuple[Path, Note, State]]:
    """Yield temporary folders of running and of killed programs."""
    for name in sorted(os.listdir(parent)):
        if (match := re.fullmatch(r"bristle-([0-9a-f]{32})\.(?:partial|replaced)", name)) is None:
            continue
        with suppress(OSError), Folder(parent / name) as folder:
            note = owned.note_in(folder)
            if note is None:
                if os.lstat(parent / name).st_mtime < time.time() - 60.0:  # [s]
                    # Of a program killed before it wrote the note; otherwise empty.
                    _remove_begun(parent / name)
                continue
            # Else a user folder: a copy, or a renamed folder.
            if match[1] in (note.token, note.aside):
                yield parent / name, note, _state_of(folder)


def _state_of(folder: Folder) -> State:
    """Return whether a program writes into a folder; in doubt, or with another owner, the folder is left unchanged."""
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
    """Refuse to write if another program already writes there; of two simultaneous programs, the earlier continues."""
    writing = {
        path: (note.began, path.name)
        for path, note, state in _unfinished_in(target.parent)
        if state == "written" and note.target == target.name
    }
    if own in writing and min(writing.values()) < writing[own]:
        raise InputError(
            "another process is writing results to this folder",
            path=str(target),
            mend="Wait for its end, or name another folder",
        )


def _publish(results: Results, target: Path, force: bool) -> None:
    """Publish the results without replacing changes that the user made meanwhile."""
    if os.name == "nt":
        results.close()  # Windows cannot rename a folder with an open file
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
        # Wait, because another successful process may be removing them, too.
        if owned.remove_own(old) or not os.path.lexists(old):
            return
    warnings.warn(f"{old}: the replaced results could not be removed", InputWarning, stacklevel=2)


def _replace(new: Path, target: Path) -> Path:
    """Replace a folder by another; return the new path of the old folder, which its note states in advance."""
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
        mend="The old results are unchanged. Close programs that use these files, make room on the disk, or name another folder",
    )
