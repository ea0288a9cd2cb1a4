"""`serve`: the application on this machine, and its temporary folder.

A killed server removes no files. Therefore each folder contains a note, which its server locks as long as the server
runs. The note names the folder, so that a copy of the note is not valid for another folder. An unlocked note marks the
folder of a killed server. The next server removes this folder, but no other folder with a similar name.
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

from bristle.apps.lab.server.limits import Limits
from bristle.core import InputError, MissingExtraError
from bristle.files import lock

PREFIX = "bristle-lab-"
NOTE = ".bristle-lab"


@contextmanager
def own_folder() -> Iterator[Path]:
    """Give a new folder that only this user can read, and remove it with its contents at the end.

    First remove the folders of killed servers of this user.
    """
    _remove_left_behind()
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    try:
        note = os.open(folder / NOTE, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            # Locked while it is empty: a readable, unlocked note marks a dead server.
            lock(note)
            os.write(note, _words_of(folder.name, folder.stat()))
            yield folder
        finally:
            os.close(note)
    finally:
        for inside in folder.glob("*"):
            if inside.is_dir():
                shutil.rmtree(inside, ignore_errors=True)
        shutil.rmtree(folder, ignore_errors=True)  # with the note last


def _words_of(name: str, status: os.stat_result) -> bytes:
    return f"bristle lab --serve keeps its logs here: {name} {status.st_ino}\n".encode()


def _remove_left_behind() -> None:
    """Remove the folders of dead servers of this user."""
    if os.name != "posix":  # there folders have no owner, and open files cannot be removed
        return
    for path in sorted(Path(tempfile.gettempdir()).glob(f"{PREFIX}*")):
        # Another user's folder, a live server, or a removal by another server.
        with suppress(OSError):
            opened = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                _remove_if_dead(path, opened)
            finally:
                os.close(opened)


def _remove_if_dead(path: Path, folder: int) -> None:
    """Remove an open folder, whether or not it was moved, if its note allows it."""
    note = os.open(NOTE, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder)
    try:
        status = os.fstat(folder)
        is_ours = {status.st_uid, os.fstat(note).st_uid} == {os.getuid()}
        if is_ours and os.read(note, 200) == _words_of(path.name, status) and lock(note):
            # The note is last, so that a failed removal is repeated.
            for name in os.listdir(folder):
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


def serve(
    *,
    port: int = 0,
    opens: bool = True,
    limits: Limits | None = None,
    announce: Callable[[str], None] = print,
) -> None:
    """Serve the lab to browsers of this machine until the process ends; port 0 takes any free port.

    `announce` is called once with the address, which contains the token.
    """
    for package in ("starlette", "uvicorn"):
        if find_spec(package) is None:
            raise MissingExtraError.of("lab --serve", "lab")
    from bristle.apps.lab.server.application import application

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
    """Return a server of an application on a socket, with timeouts for silent clients."""
    import uvicorn

    from bristle.apps.lab.server.application import protocol_with_limits

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
    """Return a socket that accepts connections from this machine only."""
    if not 0 <= port < 2**16:
        raise InputError(
            "is not a port", path="--port", value=port, allowed="0 to 65535, 0 for any free port"
        )
    try:
        # Queue for a browser that is faster than the server.
        return socket.create_server((LOOPBACK, port), backlog=BACKLOG)
    except OSError as error:
        reason = str(error.strerror).partition(" (while")[0]  # followed by the address
        raise InputError(
            f"cannot be opened: {reason}",
            path="--port",
            value=port,
            mend="Leave --port out: bristle takes a free port",
        ) from None
