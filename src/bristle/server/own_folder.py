"""`own_folder`: where a server keeps what it was given; the folder ends with it, or with the start of the next one.

A server that is killed removes nothing. So each folder has a note, which its server holds locked as long as it lives,
however it ends. The note names the folder, so that it speaks for no copy of it. What has such a note, locked by nobody,
is what a dead server left; all else that is called alike stays as it is.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bristle.files.owned import lock

PREFIX = "bristle-lab-"
NOTE = ".bristle-lab"


@contextmanager
def own_folder() -> Iterator[Path]:
    """Give a new folder that only this user can look into, and remove it at the end, with all that is in it.

    Folders that servers of this user left, as they were killed, are removed first.
    """
    _remove_left_behind()
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    try:
        note = os.open(folder / NOTE, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            # Locked before anything stands in it: a note that can be read and is not locked is that of a dead server.
            lock(note)
            os.write(note, _words_of(folder.name, folder.stat()))
            yield folder
        finally:
            os.close(note)
    finally:
        for inside in folder.glob("*"):
            if inside.is_dir():
                shutil.rmtree(inside, ignore_errors=True)
        shutil.rmtree(folder, ignore_errors=True)  # with the note, which goes last


def _words_of(name: str, status: os.stat_result) -> bytes:
    return f"bristle lab --serve keeps its logs here: {name} {status.st_ino}\n".encode()


def _remove_left_behind() -> None:
    """Remove the folders of dead servers of this user."""
    if os.name != "posix":  # where folders have no owner, and what is open cannot be removed
        return
    for path in sorted(Path(tempfile.gettempdir()).glob(f"{PREFIX}*")):
        with suppress(OSError):  # it is somebody else's, lives, or is being removed by another server that starts
            opened = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                _remove_if_dead(path, opened)
            finally:
                os.close(opened)


def _remove_if_dead(path: Path, folder: int) -> None:
    """Remove a folder that is held open, whatever its path is now, if its note says so."""
    note = os.open(NOTE, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder)
    try:
        status = os.fstat(folder)
        is_ours = {status.st_uid, os.fstat(note).st_uid} == {os.getuid()}
        if is_ours and os.read(note, 200) == _words_of(path.name, status) and lock(note):
            for name in os.listdir(folder):  # the note goes last: what could not be removed is found again
                if stat.S_ISDIR(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
                    shutil.rmtree(name, dir_fd=folder)
                elif name != NOTE:
                    os.unlink(name, dir_fd=folder)
            os.unlink(NOTE, dir_fd=folder)
            os.rmdir(path)
    finally:
        os.close(note)
