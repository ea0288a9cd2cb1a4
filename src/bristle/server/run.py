"""`serve`: the application on this machine, until it is ended, and the folder that is removed with it.

A server that is killed removes nothing. So each folder has a note, which its server holds locked as long as it lives,
however it ends. The note names the folder, so that it speaks for no copy of it. What has such a note, locked by nobody,
is what a dead server left; all else that is called alike stays as it is. The next server removes it.
"""

import os
import secrets
import shutil
import socket
import stat
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bristle.core import InputError, MissingExtraError
from bristle.files import lock
from bristle.server.limits import Limits

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


LOOPBACK = "127.0.0.1"
BACKLOG = 128  # connections waiting


def serve(*, port: int = 0, opens: bool = True, limits: Limits | None = None, announce: Callable[[str], None] = print) -> None:
    """Serve the lab to browsers of this machine until the process is ended; port 0 is any that is free.

    `announce` is called once with the address, which holds the token.
    """
    for package in ("starlette", "uvicorn"):
        if find_spec(package) is None:
            raise MissingExtraError.of("lab --serve", "lab")
    from bristle.server.application import application

    bounds, token = limits or Limits(), secrets.token_urlsafe(32)
    with listening_on(port) as listening, own_folder() as folder:
        free_port: int = listening.getsockname()[1]
        app = application(folder, token, free_port, bounds)
        announce(f"http://{LOOPBACK}:{free_port}/#{token}")
        if opens:
            file = app.state.opening.offer()
            threading.Thread(target=webbrowser.open, args=(file.as_uri(),), daemon=True).start()
        server_of(app, bounds).run(sockets=[listening])


def server_of(app: Any, limits: Limits) -> Any:
    """Return what serves an application to a socket, and has no patience with clients that are silent."""
    import uvicorn

    from bristle.server.application import protocol_with_limits

    config = uvicorn.Config(
        app,
        http=protocol_with_limits(limits),
        ws="none",
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,
        backlog=BACKLOG,
        timeout_keep_alive=5,  # [s], as the next
        timeout_graceful_shutdown=1,
    )
    return uvicorn.Server(config)


def listening_on(port: int) -> socket.socket:
    """Return a socket that hears this machine only."""
    if not 0 <= port < 2**16:
        raise InputError("is no port", path="--port", value=port, allowed="0 to 65535, 0 for one that is free")
    try:
        return socket.create_server((LOOPBACK, port), backlog=BACKLOG)  # a browser that is faster than the server waits for it
    except OSError as error:
        reason = str(error.strerror).partition(" (while")[0]  # behind it is the address
        raise InputError(
            f"cannot be listened to: {reason}", path="--port", value=port, mend="Leave --port away: a free one is taken"
        ) from None
